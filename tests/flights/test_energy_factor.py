"""Flights that take another energy than the mission says, and gauges that say odd things."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from lockstep import Lockstep
from two_docks import RESERVE, between_docks, lowest, text, two_docks

from companion.acting.replanning.replanner import Replanner
from companion.flight_events.energy import EnergyUsed, GaugeJumped
from companion.flight_events.plans import NoPlanFound, PlanReplaced
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import PauseEnded, VehicleLanded
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission

MISSIONS = Path(__file__).parents[2] / "missions"
INSIDE = ((-1.5, -1.5), (21.5, -1.5), (21.5, 13.5), (-1.5, 13.5))
"""Fence of the hall, east and north."""


def says(share: float) -> dict[str, list[list[float]]]:
    """The power of a mission that says such a share of what flights really take."""
    level = ((0, 189.4), (5, 192.0), (10, 204.8))
    climb = ((-1, 179.4), (0, 189.4), (3, 225.0))
    return {
        "level": [[speed, share * watts] for speed, watts in level],
        "climb": [[speed, share * watts] for speed, watts in climb],
    }


def fly(data: dict[str, Any], *happens: dict[str, Any], **options: Any) -> Lockstep:
    mission = load_mission(data)
    world = world_of(mission, between_docks(*happens, charge=0.27))
    return Lockstep(mission, world, seed=1, **options)


@pytest.mark.long
def test_flights_that_take_a_quarter_more_go_on_with_plans_that_know_it() -> None:
    battery = {"reserve": RESERVE, "capacity_wh": 75.5, "power_w": says(0.8)}
    battery["curve"] = [[0, 0], [20, 18.7], [60, 58], [80, 78.6], [90, 89.2], [100, 100]]
    flight = fly(two_docks(battery=battery))
    assert lowest(flight, 200.0) >= RESERVE - 0.3
    used = flight.of(EnergyUsed)
    assert len(used) >= 4 and used[-1].factor > 1.15, text(flight)
    assert abs(used[-1].expected_wh / used[-1].used_wh - 1) < 0.08
    assert not flight.of(NoPlanFound) and len(flight.of(PlanReplaced)) <= 4, text(flight)
    late = [s.time_s for s in flight.reports if isinstance(s.event, PlanReplaced)]
    assert all(time_s < 120.0 for time_s in late), text(flight)
    then = (s.event for s in flight.reports if s.time_s > 120.0)
    assert {"A", "B"} <= {e.place for e in then if isinstance(e, PlaceReached)}


@pytest.mark.long
@pytest.mark.parametrize("has_another", [True, False])
def test_flights_that_take_less_end_no_plan_where_there_is_no_other(
    has_another: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A plan made anew has less in hand than the one under way had; with a bound there is none."""
    battery = {"reserve": RESERVE, "capacity_wh": 75.5, "power_w": says(1.2)}
    if not has_another:
        monkeypatch.setattr(Replanner, "plan_now", lambda _: None)
    flight = fly(two_docks(battery=battery))
    flight.until(lambda: len(flight.of(EnergyUsed)) >= 3, limit_s=400.0).run(5.0)
    less = [e for e in flight.of(PlanReplaced) if "less energy" in e.reason]
    assert bool(less) == has_another, text(flight)
    assert not flight.of(NoPlanFound), text(flight)


def test_a_gauge_that_jumps_up_in_flight_is_not_believed() -> None:
    flight = fly(two_docks(), {"at_s": 18, "battery": {"charge": 0.9}})
    flight.until_reported(VehicleLanded)
    jump = flight.of(GaugeJumped)[0]
    assert jump.now_percent == 90 and jump.believed_percent == jump.before_percent < 27
    assert not flight.of(NoPlanFound), text(flight)


@pytest.mark.long
def test_a_pause_ends_when_the_charge_is_needed() -> None:
    flight = fly(two_docks(), has_station=True)
    flight.until_reported(PlaceReached, place="A")
    flight.station_commands(dialect.MAV_CMD_DO_PAUSE_CONTINUE, 0.0, component=191)
    flight.until_reported(PauseEnded, limit_s=600.0)
    flight.until_reported(VehicleLanded)
    assert not flight.of(NoPlanFound), text(flight)
    assert 100 * flight.simulation.flight.charge >= RESERVE


@pytest.mark.long
def test_among_shelves_the_first_stretch_takes_what_was_expected() -> None:
    """Bends make flights up to 1.7 times as long as their length says; nothing was learnt yet."""
    hall = MISSIONS / "maps" / "hall.yaml"
    sites = {"Home": (0, 0), "A": (3, 11), "B": (17.5, 10.5), "C": (17, 1.5), "E": (9.6, 0.2)}
    data = two_docks(
        map=str(hall),
        limits={"speed_mps": 3, "up_m": [0.5, 4], "fence": [list(corner) for corner in INSIDE]},
        places={
            n: {"east_m": east, "north_m": north, "up_m": 2} for n, (east, north) in sites.items()
        },
        sets={"Place": list(sites), "Pad": ["E"]},
        task={"patrol": "patrolling(A, B, C)"},
        battery={"reserve": RESERVE, "capacity_wh": 12.0},
    )
    world = {"version": 1, "map": str(hall), "airframe": "px4_sih", "wander": {}}
    pads = [{"east_m": 9.6, "north_m": 0.2, "radius_m": 2.0, "current_a": 100}]
    mission = load_mission(data)
    scenario = world | {"battery": {"charge": 0.5}, "pads": pads}
    flight = Lockstep(mission, world_of(mission, scenario), seed=1)
    flight.until_reported(EnergyUsed, 300.0)
    (used,) = flight.of(EnergyUsed)
    assert abs(used.used_wh / used.expected_wh - 1) <= 0.06
