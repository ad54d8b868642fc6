"""The worlds of the surveillance mission, as shipped and shorter, and its flights in the latter."""

from __future__ import annotations

import pytest
import short_hall
from interference import Start
from lockstep import Lockstep, World
from operated import Operated

from companion.mission.model import Mission
from sitl.world.scenario import read_scenario


@pytest.fixture(scope="session")
def hall() -> World:
    return read_scenario(short_hall.SHIPPED)


@pytest.fixture(scope="session", name="short_hall")
def read_short_hall() -> World:
    return short_hall.short_hall()


@pytest.fixture
def start(surveillance: Mission, short_hall: World) -> Start:
    """A flight of the surveillance mission that has not begun yet."""

    def begin(world: World = short_hall, **options: object) -> Lockstep:
        return Lockstep(surveillance, world, **options)  # type: ignore[arg-type]

    return begin


@pytest.fixture(scope="session")
def undisturbed(surveillance: Mission, short_hall: World) -> Lockstep:
    return Lockstep(surveillance, short_hall).until_the_end()


@pytest.fixture
def operated(surveillance: Mission, short_hall: World) -> Operated:
    """A mission that is flown at once; the program ends with it."""
    return Operated(surveillance, short_hall)


@pytest.fixture
def hosted(surveillance: Mission, short_hall: World) -> Operated:
    """A program that waits for operators to start the mission."""
    return Operated(surveillance, short_hall, is_hosted=True)
