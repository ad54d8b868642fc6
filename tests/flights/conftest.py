"""The world of the surveillance mission, as it is shipped, and one in which it takes less time."""

from __future__ import annotations

import pytest
import short_hall
from lockstep import World

from sitl.world.scenario import read_scenario


@pytest.fixture(scope="session")
def hall() -> World:
    return read_scenario(short_hall.SHIPPED)


@pytest.fixture(scope="session", name="short_hall")
def read_short_hall() -> World:
    return short_hall.short_hall()
