"""A vehicle with a range finder stops before what no map shows, however fast its mission is."""

from __future__ import annotations

import math
from typing import Any

import meadow
import pytest
from lockstep import COMPANION, VEHICLE, Air, Deaf, Lockstep, clear

from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import SpeedLimitedBySight
from companion.flight_events.sortie import Phase, PhaseEntered, SetpointRefused
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.motion.speed_in_sight import fastest_mps
from companion.vehicle_profile import VehicleProfile

Box = dict[str, list[float]]

FIELD = [[-15, -15], [90, -15], [90, 15], [-15, 15]]
QUICK_MPS = 8.0
IN_SIGHT_MPS = fastest_mps(8.0, VehicleProfile())
ACROSS: Box = {"east_m": [40, 41], "north_m": [-20, 20]}
PILLAR: Box = {"east_m": [40, 41], "north_m": [-0.7, 0.3]}
DATA: dict[str, Any] = meadow.DATA | {
    "places": meadow.DATA["places"] | {"A": {"east_m": 70, "north_m": 0, "up_m": 3}},
    "task": {"visit": "F at(A)"},
    "patience_s": 2,
}


def flight(
    *boxes: Box, up: Air = clear, low: bool = False, about: Any = None, **limits: Any
) -> Lockstep:
    """To A, 70 m away, over a field with boxes that no map shows; low is 2 m above it."""
    bounds = {"speed_mps": QUICK_MPS, "up_m": [1, 10], "fence": FIELD} | limits
    places = {name: place | ({"up_m": 2} if low else {}) for name, place in DATA["places"].items()}
    mission = load_mission(DATA | {"limits": bounds, "places": places})
    world = {
        "version": 1,
        "map": {"east_m": [-30, 120], "north_m": [-30, 30]},
        "lidar": {},
        "obstacles": [{"name": f"box{i}", "box": box} for i, box in enumerate(boxes)],
    } | (about or {})
    return Lockstep(mission, world_of(mission, world), up=up, has_station=True)


def fastest_told_mps(flown: Lockstep) -> float:
    """Of the setpoints of a flight."""
    sent = (said.message for said in flown.setpoints)
    return max(math.hypot(m.vx, m.vy, m.vz) for m in sent if math.isfinite(m.vx))


@pytest.mark.parametrize(
    "box", [pytest.param(ACROSS, marks=pytest.mark.long), PILLAR], ids=["across", "pillar"]
)
def test_it_stops_or_goes_round(box: Box) -> None:
    flown = flight(box).until_the_end()
    assert flown.simulation.collisions == 0
    assert fastest_told_mps(flown) == pytest.approx(IN_SIGHT_MPS, rel=0.01)
    assert flown.exit_code == (0 if box is PILLAR else 3)


@pytest.mark.long
def test_a_vehicle_that_leans_and_sees_less_flies_no_faster_than_that() -> None:
    """With the drag of PX4's own vehicle it leans by 30 degrees into a wind of 4 m/s."""
    wind = {"east_mps": -4, "turbulence_mps": 0.4}
    flown = flight(ACROSS, low=True, about={"airframe": "px4_sih", "wander": {}, "wind": wind})
    flown.until_the_end()
    assert flown.simulation.collisions == 0 and flown.exit_code == 3
    told = flown.of(SpeedLimitedBySight)
    assert told[0].sight_m == 8.0 and min(each.sight_m for each in told) < 4.0


def test_a_vehicle_that_leans_for_a_moment_alone_is_not_slowed() -> None:
    flown = flight(low=True).until_the_end()
    assert flown.exit_code == 0
    assert flown.of(SpeedLimitedBySight) == [SpeedLimitedBySight(4.57, QUICK_MPS, 8.0)]


def test_the_same_mission_that_may_fly_beyond_sight_hits_it() -> None:
    """So the limit is what keeps it unhurt."""
    flown = flight(ACROSS, beyond_sight=True).until_the_end()
    assert flown.of(SpeedLimitedBySight) == []
    assert fastest_told_mps(flown) == pytest.approx(QUICK_MPS, rel=0.01)
    assert flown.simulation.collisions > 0


def test_it_is_told_before_arming_and_planned_with() -> None:
    flown = flight().until_reported(PhaseEntered, phase=Phase.TASK)
    assert flown.of(SpeedLimitedBySight) == [SpeedLimitedBySight(4.57, QUICK_MPS, 8.0)]
    assert flown.of(PlanReplaced) == []


def test_what_is_first_heard_in_flight_slows_the_flight_under_way() -> None:
    deaf = Deaf(dialect.MAVLINK_MSG_ID_OBSTACLE_DISTANCE)
    deaf.is_deaf = True
    flown = flight(up=deaf).until_reported(PhaseEntered, phase=Phase.TASK)
    flown.run(5.0)
    assert fastest_told_mps(flown) > IN_SIGHT_MPS + 1.0
    deaf.is_deaf, before = False, len(flown.setpoints)
    flown.run(3.0)
    flown.one(SpeedLimitedBySight)
    del flown.said[:before]
    flown.until_the_end()
    assert flown.of(SetpointRefused) == []
    assert flown.exit_code == 0


def test_an_operator_may_slow_it_further_and_not_past_its_sight() -> None:
    flown = flight().until_reported(PhaseEntered, phase=Phase.TASK)
    flown.run(1.0)
    for asked_mps, allowed_mps in ((1.0, 1.0), (50.0, IN_SIGHT_MPS)):
        name, real32 = b"CMP_SPEED_MAX", dialect.MAV_PARAM_TYPE_REAL32
        order = dialect.MAVLink_param_set_message(VEHICLE, COMPANION, name, asked_mps, real32)
        flown.station_says(order)
        flown.run(5.0)
        del flown.said[:]
        flown.run(0.5)
        assert fastest_told_mps(flown) == pytest.approx(allowed_mps, rel=0.01)
