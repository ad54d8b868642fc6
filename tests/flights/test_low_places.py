"""Places lower than a height is certain: told where the position is not exact, before arming."""

from __future__ import annotations

import pytest
from lockstep import Lockstep
from meadow import DATA

from companion.flight_events.skills import ClearanceChanged, LowPlacesFlown
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.flights.simulated_world import world_of
from companion.mission.loader import load_mission

LIMITS = {"speed_mps": 4, "up_m": [0.5, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
NOISE = {"version": 1, "happens": [{"at_s": 0.1, "gps": {"noise_m": 0.25}}]}


def flown(up_m: float, world: dict[str, object] | None) -> Lockstep:
    """On its way to A, which is so high."""
    places = DATA["places"] | {"A": DATA["places"]["A"] | {"up_m": up_m}}
    asked = load_mission(DATA | {"limits": LIMITS, "places": places})
    return Lockstep(asked, world_of(asked, world)).until_reported(PhaseEntered, phase=Phase.TASK)


def test_a_low_place_is_told_once_and_before_arming() -> None:
    flight = flown(1.2, NOISE)
    assert flight.one(LowPlacesFlown) == LowPlacesFlown(("A",), 1.5, 1.4)
    armed_s = flight.time_of(PhaseEntered, phase=Phase.ARMING)
    assert flight.time_of(LowPlacesFlown) < armed_s


@pytest.mark.parametrize(("up_m", "is_exact"), [(1.2, True), (1.5, False)])
def test_where_the_position_is_exact_or_the_place_high_enough_nothing_is(
    up_m: float, is_exact: bool
) -> None:
    flight = flown(up_m, None if is_exact else NOISE)
    assert not flight.of(LowPlacesFlown)
    assert bool(flight.of(ClearanceChanged)) is not is_exact
