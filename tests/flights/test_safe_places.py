"""A task without a plan in flight: the vehicle lands at the safe place that it reaches soonest.

The mission is the one of docs/missions.md, in a world where its payload refuses.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from lockstep import Lockstep

from companion.errors import NoPlanError
from companion.flight_events.sortie import (
    ControlTakenBack,
    FlightFoundAgain,
    ReturnBegun,
    ReturnFailed,
)
from companion.flights.simulated_world import world_of
from companion.geometry import horizontal_distance
from companion.mission.loader import load_mission
from companion.mission.model import Mission

DOCS = Path(__file__).parents[2] / "docs" / "missions.md"
REFUSES = {"component": 25, "command": "MAV_CMD_USER_1", "otherwise": "DENIED"}
CRATE = {"name": "crate", "circle": {"east_m": 26, "north_m": 24, "radius_m": 1.5}}
"""On North."""


@cache
def rounds() -> Mission:
    """The mission of the documentation."""
    _, _, section = DOCS.read_text(encoding="utf-8").partition("## Safe places\n")
    return load_mission(section.split("```yaml\n", 1)[1].split("```", 1)[0])


def fly(options: dict[str, Any] | None = None, **world: Any) -> Lockstep:
    scenario = {"version": 1, "payload": REFUSES, **world}
    return Lockstep(rounds(), world_of(rounds(), scenario), **(options or {}))


def away_m(flight: Lockstep, place: str) -> float:
    return horizontal_distance(flight.simulation.flight.position, rounds().places[place].position)


def landed_at(flight: Lockstep, place: str) -> None:
    flight.until_the_end()
    assert flight.exit_code == NoPlanError.exit_code
    assert not flight.simulation.is_armed and flight.simulation.collisions == 0
    assert away_m(flight, place) < 0.8


def test_it_lands_at_the_nearest() -> None:
    flight = fly()
    landed_at(flight, "North")
    assert [each.place for each in flight.of(ReturnBegun)] == ["North"]


@pytest.mark.long
def test_a_crate_on_it_leads_to_the_next() -> None:
    flight = fly(lidar={"range_m": 8}, obstacles=[CRATE | {"present": True}])
    landed_at(flight, "East")
    assert [each.place for each in flight.of(ReturnBegun)] == ["North", "East"]
    assert [each.place for each in flight.of(ReturnFailed)] == ["North"]


@pytest.mark.long
@pytest.mark.parametrize("away_s", [1.0, 4.0])
def test_a_companion_that_is_killed_on_the_way_goes_on_to_a_safe_place(away_s: float) -> None:
    flight = fly({"has_station": True, "resumes": True})
    flight.until_reported(ReturnBegun).run(1.5)
    flight.kill()
    flight.run(away_s)
    flight.restart()
    flight.until_reported(FlightFoundAgain).until_reported(ControlTakenBack)
    landed_at(flight, "North")
    assert flight.armings == 1
