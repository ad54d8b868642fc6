"""A vehicle that leans sees no walls where its beams meet the ground.

Where a map is true, what is seen changes none of its cells; and so no way is blocked.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from lockstep import Lockstep, World
from short_hall import seen_soon

from companion.flight_events.facts import PlacesCutOff
from companion.flight_events.skills import RouteBlocked
from companion.mission.model import Mission
from sitl.flight.estimate import Wander


def low(mission: Mission, up_m: float) -> Mission:
    """A mission whose places are all so high."""
    places = {
        name: replace(place, position=(*place.position[:2], -up_m))
        for name, place in mission.places.items()
    }
    return replace(mission, places=places)


def windy(world: World, wind_mps: float, **about: Any) -> World:
    """A world with wind from the south-west, and gusts of a tenth of it."""
    scenario, grid = world
    wind = (0.6 * wind_mps, 0.8 * wind_mps, 0.0)
    return replace(scenario, wind=wind, turbulence_mps=wind_mps / 10, **about), grid


@pytest.mark.parametrize(
    ("up_m", "wind_mps", "about"),
    [
        pytest.param(0.8, 0.0, {}, marks=pytest.mark.long),
        pytest.param(0.8, 8.0, {}, marks=pytest.mark.long),
        pytest.param(
            *(2.0, 4.0, {"airframe": "px4_sih", "wander": Wander(0.25, 0.3, 0.3)}),
            marks=pytest.mark.long,
        ),
        (1.0, 4.0, {"airframe": "px4_sih", "wander": Wander(0.25, 0.3, 0.8)}),
    ],
    ids=["calm", "windy", "PX4's drag and errors", "lower, and a height that is less exact"],
)
def test_in_wind_and_low_above_the_ground_no_way_is_blocked(
    up_m: float, wind_mps: float, about: dict[str, Any], surveillance: Mission, hall: World
) -> None:
    flown = Lockstep(low(surveillance, up_m), windy(seen_soon(hall), wind_mps, **about))
    flown.until_the_end()
    assert flown.exit_code == 0 and flown.simulation.collisions == 0
    assert flown.of(RouteBlocked) == [] and flown.of(PlacesCutOff) == []
    run = flown.companion._run
    assert run is not None and run._surroundings.grid is surveillance.grid
