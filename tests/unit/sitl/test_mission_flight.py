"""Missions in flight, seen from the wire; which item comes next, against a plain expansion."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plans import (
    DELAY,
    JUMP,
    LAND,
    LOITER_TIME,
    RETURN,
    SPEED,
    TAKEOFF,
    WAYPOINT,
    action,
    place,
    upload,
)
from wire import NAN, Wire, gcs_heartbeat

from companion.geometry import horizontal_distance
from companion.mavlink.framing import dialect
from sitl.autopilot.mission_items import MissionCommand, MissionItem, speed_before
from sitl.autopilot.mission_plan import MissionPlan, PlanState
from sitl.flight.battery import BatterySpec
from sitl.world.scenario import Scenario

ACCEPTED, TEMPORARILY_REJECTED, DENIED = 0, 1, 2
START = dialect.MAV_CMD_MISSION_START
NOT_STARTED, ACTIVE, PAUSED, COMPLETE = 2, 3, 4, 5


def started(*items: object, **parameters: float) -> Wire:
    """A vehicle that has just been told to fly a mission."""
    wire = Wire(Scenario(parameters=parameters))
    wire.send(gcs_heartbeat())
    assert upload(wire, items) == 0
    wire.run(0.2)
    assert wire.command(START, 0, 0) == [ACCEPTED]
    return wire


def reached(wire: Wire) -> list[tuple[int, float]]:
    """Items in the order in which they were reported first in a row, and when."""
    told = [(h.message.seq, h.time_s) for h in wire.named("MISSION_ITEM_REACHED")]
    return [now for i, now in enumerate(told) if i == 0 or told[i - 1][0] != now[0]]


def order(wire: Wire) -> list[int]:
    return [seq for seq, _ in reached(wire)]


def flown(wire: Wire, limit_s: float = 60.0) -> None:
    wire.run_until(lambda: wire.simulation.mode != "AUTO.MISSION", limit_s)


def state(wire: Wire) -> int:
    wire.run(1.0)
    return int(wire.last("MISSION_CURRENT").mission_state)


def position(wire: Wire) -> tuple[float, float, float]:
    north, east, down = wire.simulation.flight.position
    return (north, east, -down)


SQUARE = [(10.0, 0.0, 5.0), (10.0, 10.0, 8.0), (0.0, 10.0, 5.0)]


def test_items_are_flown_in_order_and_the_vehicle_holds_at_the_last() -> None:
    wire = started(place(TAKEOFF, (0, 0, 5)), *(place(WAYPOINT, point) for point in SQUARE))
    nearest = [math.inf] * 3
    while wire.simulation.mode == "AUTO.MISSION":
        wire.run(0.02)
        nearest = [
            min(n, math.dist(p, position(wire))) for n, p in zip(nearest, SQUARE, strict=True)
        ]
        assert wire.now_s < 60
    assert order(wire) == [0, 1, 2, 3]
    assert all(distance_m <= math.hypot(2.0, 0.8) for distance_m in nearest)  # NAV_ACC_RAD
    assert wire.simulation.mode == "AUTO.LOITER"
    assert wire.texts()[-1] == "Mission finished, loitering"
    assert state(wire) == COMPLETE
    wire.run(4.0)
    assert position(wire) == pytest.approx(SQUARE[-1], abs=0.1)


def test_a_mission_is_denied_right_after_its_upload_and_later_arms_by_itself() -> None:
    wire = Wire()
    assert wire.command(START, 0, 0) == [DENIED]
    upload(wire, [place(TAKEOFF, (0, 0, 5))])
    wire.run(0.01)
    assert wire.command(START, 0, 0) == [DENIED]
    wire.run(2.0)
    assert wire.last("MISSION_CURRENT").mission_state == NOT_STARTED
    assert wire.command(START, 1, 0) == [DENIED]
    assert wire.command(START, NAN, 0) == [DENIED]
    assert wire.command(START, 0, 0) == [ACCEPTED]
    assert wire.simulation.is_armed
    assert state(wire) == ACTIVE


def test_a_mission_that_may_not_arm_is_rejected() -> None:
    wire = Wire(Scenario(battery=BatterySpec(0.06)))
    upload(wire, [place(TAKEOFF, (0, 0, 5))])
    wire.run(0.2)
    assert wire.command(START, 0, 0) == [TEMPORARILY_REJECTED]


def test_each_item_is_reported_at_once_and_the_last_one_ten_times_more() -> None:
    wire = started(place(TAKEOFF, (0, 0, 5)), action(530, 0, 2), action(2000, 0, 0, 1))
    flown(wire)
    wire.run(15.0)
    times = [h.time_s for h in wire.named("MISSION_ITEM_REACHED") if h.message.seq == 2]
    assert len(times) == 11
    assert [b - a for a, b in pairwise(times)] == pytest.approx([1] * 10, abs=0.02)
    assert order(wire) == [0, 1, 2]


def test_a_takeoff_is_put_before_a_waypoint_and_not_reported() -> None:
    wire = started(place(WAYPOINT, (10, 0, 6)))
    wire.run_until(lambda: position(wire)[2] > 5.0, 10.0)
    assert horizontal_distance(position(wire), (0, 0)) < 0.3
    assert order(wire) == []
    flown(wire)
    assert order(wire) == [0]


@pytest.mark.parametrize("height_m", [1.0, 0.0])
def test_no_takeoff_is_lower_than_mis_takeoff_alt(height_m: float) -> None:
    wire = started(place(TAKEOFF, (0, 0, height_m)))
    flown(wire)
    wire.run(4.0)
    assert position(wire)[2] == pytest.approx(2.5, abs=0.1)


def test_a_waypoint_holds_for_its_time() -> None:
    wire = started(
        place(TAKEOFF, (0, 0, 5)),
        place(WAYPOINT, (10, 0, 5), 3.0, 1.0),
        place(LOITER_TIME, (10, 0, 5), 4.0),
        action(DELAY, 2.0),
    )
    wire.run_until(lambda: horizontal_distance(position(wire), (10, 0)) <= 1.0, 20.0)
    arrived_s = wire.now_s
    flown(wire)
    times = dict(reached(wire))
    assert times[1] - arrived_s == pytest.approx(3.0, abs=0.1)
    assert times[2] - times[1] == pytest.approx(4.0, abs=0.1)
    assert times[3] - times[2] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("speed_mps", [pytest.param(None, marks=pytest.mark.long), 2.0])
def test_speed_between_waypoints(speed_mps: float | None) -> None:
    change = [action(SPEED, 1, speed_mps, -1)] if speed_mps else []
    wire = started(place(TAKEOFF, (0, 0, 5)), *change, place(WAYPOINT, (60, 0, 5)))
    wire.run_until(lambda: position(wire)[0] > 25, 40.0)
    assert wire.simulation.flight.velocity[0] == pytest.approx(speed_mps or 5.0, abs=0.1)


@pytest.mark.long
def test_a_heading_that_is_asked_for_is_reached() -> None:
    wire = started(
        place(TAKEOFF, (0, 0, 5)),
        place(WAYPOINT, (10, 0, 5), yaw_deg=90.0),
        place(WAYPOINT, (10, 20, 5), yaw_deg=-90.0),
    )
    headings: dict[int, float] = {}
    while wire.simulation.mode == "AUTO.MISSION":
        wire.run(0.02)
        for seq in order(wire)[len(headings) :]:
            headings[seq] = wire.last("GLOBAL_POSITION_INT").hdg / 100
    assert headings[1] == pytest.approx(90.0, abs=13.0)  # MIS_YAW_ERR
    assert headings[2] == pytest.approx(270.0, abs=13.0)


def test_the_states_of_a_plan() -> None:
    plan, waypoints = MissionPlan(), [MissionItem(MissionCommand.WAYPOINT)] * 2
    plan.load(waypoints, None, 0.0)
    assert (plan.state, plan.current) == (PlanState.NOT_STARTED, 0)
    assert plan.set_current(1)
    plan.note_disarming()
    assert (plan.state, plan.current) == (PlanState.NOT_STARTED, 1)
    assert plan.begin()
    assert (plan.state, plan.current) == (PlanState.STARTED, 1)
    plan.note_disarming()
    assert (plan.state, plan.current) == (PlanState.ENDED_EARLY, 1)
    assert plan.begin()
    assert (plan.state, plan.current) == (PlanState.STARTED, 0)
    plan.note_disarming()
    assert (plan.state, plan.current) == (PlanState.STARTED, 0)  # not at the last item
    assert plan.advance()
    assert not plan.advance()
    assert (plan.state, plan.current) == (PlanState.COMPLETE, 1)
    assert plan.begin()  # in the air: the last item once more
    assert not plan.advance()
    plan.note_disarming()
    assert (plan.state, plan.current) == (PlanState.ENDED, 1)
    assert plan.set_current(1)
    assert (plan.state, plan.current) == (PlanState.STARTED, 1)


def test_a_mission_that_is_left_goes_on_where_it_was() -> None:
    wire = started(
        place(TAKEOFF, (0, 0, 5)),
        action(SPEED, 1, 2.0, -1),
        place(WAYPOINT, (10, 0, 5)),
        place(WAYPOINT, (30, 0, 5)),
    )
    wire.run_until(lambda: position(wire)[0] > 15, 30.0)
    wire.set_mode("AUTO.LOITER")
    wire.run(4.0)
    assert state(wire) == PAUSED
    stopped_at = position(wire)
    wire.run(3.0)
    assert position(wire) == pytest.approx(stopped_at, abs=0.1)
    assert wire.set_mode("AUTO.MISSION") == [ACCEPTED, ACCEPTED]
    wire.run(3.0)
    assert wire.simulation.flight.velocity[0] == pytest.approx(2.0, abs=0.1)
    flown(wire)
    assert order(wire) == [0, 1, 2, 3]
    assert position(wire)[0] > 27


def test_return_hands_over_to_rtl() -> None:
    wire = started(
        place(TAKEOFF, (0, 0, 5)),
        place(WAYPOINT, (15, 0, 5)),
        action(RETURN),
        RTL_RETURN_ALT=8.0,
        RTL_DESCEND_ALT=5.0,
    )
    flown(wire)
    assert wire.simulation.mode == "AUTO.RTL"
    assert state(wire) == COMPLETE
    wire.run_until(lambda: not wire.simulation.is_armed, 60.0)
    assert horizontal_distance(position(wire), (0, 0)) < 0.3
    assert order(wire) == [0, 1, 2]


def test_land_ends_the_mission_and_the_next_one_begins_anew() -> None:
    wire = started(place(TAKEOFF, (0, 0, 4)), place(LAND, (8, 0, 0)))
    flown(wire)
    assert order(wire) == [0, 1]
    assert "Mission finished, landed" in wire.texts()
    assert horizontal_distance(position(wire), (8, 0)) < 0.3
    assert wire.run_until(lambda: not wire.simulation.is_armed, 5.0) == pytest.approx(2.0, abs=0.1)
    assert wire.last("MISSION_CURRENT").mission_state == COMPLETE
    assert wire.set_mode("AUTO.MISSION") == [ACCEPTED, ACCEPTED]
    assert wire.arm() == [ACCEPTED]
    flown(wire)
    assert order(wire) == [0, 1, 0, 1]


def test_a_landing_in_between_takes_off_again() -> None:
    wire = started(place(TAKEOFF, (0, 0, 3)), place(LAND, (4, 0, 0)), place(WAYPOINT, (8, 0, 3)))
    flown(wire)
    assert order(wire) == [0, 1, 2]
    assert position(wire)[2] > 2.0


def test_jumps_repeat_and_are_not_reported() -> None:
    wire = started(
        place(TAKEOFF, (0, 0, 4)),
        place(WAYPOINT, (4, 0, 4)),
        place(WAYPOINT, (-4, 0, 4)),
        action(JUMP, 1, 2),
    )
    flown(wire)
    assert order(wire) == [0, 1, 2, 1, 2, 1, 2]


def test_set_current_in_flight_flies_there_at_once() -> None:
    wire = started(
        place(TAKEOFF, (0, 0, 4)),
        place(WAYPOINT, (100, 0, 4)),
        place(WAYPOINT, (0, 10, 4)),
    )
    wire.run_until(lambda: position(wire)[0] > 3, 20.0)
    wire.send(dialect.MAVLink_mission_set_current_message(1, 1, 2))
    flown(wire)
    assert order(wire) == [0, 2]


def test_a_mission_changed_in_flight() -> None:
    wire = started(place(TAKEOFF, (0, 0, 4)), place(WAYPOINT, (100, 0, 4)))
    wire.run_until(lambda: position(wire)[0] > 3, 20.0)
    upload(wire, [place(WAYPOINT, (0, 8, 4)), place(WAYPOINT, (0, 100, 4))])
    wire.run_until(lambda: order(wire) == [0], 20.0)
    wire.run(6.0)
    assert position(wire)[1] > 15
    wire.send(dialect.MAVLink_mission_clear_all_message(1, 1, 0))
    wire.run(0.1)
    assert wire.simulation.mode == "AUTO.LOITER"
    assert wire.set_mode("AUTO.MISSION") == [ACCEPTED, TEMPORARILY_REJECTED]


@pytest.mark.long
def test_an_item_without_autocontinue_is_not_left() -> None:
    wire = started(
        place(TAKEOFF, (0, 0, 4)),
        place(WAYPOINT, (5, 0, 4), autocontinue=0),
        place(WAYPOINT, (10, 0, 4)),
    )
    wire.run(20.0)
    assert order(wire) == [0, 1]
    assert position(wire) == pytest.approx((5.0, 0.0, 4.0), abs=0.1)


@pytest.mark.parametrize(
    ("command", "value"),
    [
        pytest.param(command, value, marks=[pytest.mark.long] if (i + j) % 8 else [])
        for i, command in enumerate(sorted({*map(int, MissionCommand), 2000}))
        for j, value in enumerate([NAN, math.inf, 3e38, -3e38])
    ],
)
def test_no_parameter_makes_an_item_fail(command: int, value: float) -> None:
    parameters = (value,) * 3
    item = (
        action(command, *parameters, value)
        if command in (RETURN, DELAY, JUMP, SPEED, 2000)
        else place(command, (5, 5, value), *parameters, yaw_deg=value)
    )
    wire = started(place(TAKEOFF, (0, 0, 2.5)), item, place(WAYPOINT, (0, 0, 3)))
    wire.run(8.0)
    assert 0 in order(wire)
    assert all(map(math.isfinite, wire.simulation.flight.position))


# Which item comes next.

JUMPS = st.builds(lambda to, times: (to, times), st.integers(-1, 6), st.integers(0, 3))
PLANS = st.lists(st.none() | JUMPS, min_size=1, max_size=6)


def expanded(plan: list[tuple[int, int] | None], most: int) -> list[int]:
    """The items that are flown, by rule: each jump as often as it says."""
    left = [0 if step is None else step[1] for step in plan]
    flown_items: list[int] = []
    at = 0
    while at < len(plan) and len(flown_items) < most:
        step = plan[at]
        if step is None:
            flown_items.append(at)
            at += 1
        elif left[at] and 0 <= step[0] < len(plan):
            left[at] -= 1
            at = step[0]
        else:
            at += 1
    return flown_items


@given(plan=PLANS)
def test_the_order_of_items_with_jumps(plan: list[tuple[int, int] | None]) -> None:
    items = [
        MissionItem(MissionCommand.WAYPOINT)
        if step is None
        else MissionItem(MissionCommand.DO_JUMP, (float(step[0]), float(step[1]), None, None))
        for step in [None, *((s[0] + 1, s[1]) if s else None for s in plan)]
    ]
    rule = expanded([None, *((s[0] + 1, s[1]) if s else None for s in plan)], 200)
    mission = MissionPlan()
    mission.load(items, None, 0.0)
    seen = [mission.current] if mission.begin() else []
    while len(seen) < 200 and mission.advance():
        seen.append(mission.current)
    straight = all(a is None or b is None for a, b in pairwise(plan))
    if straight:  # PX4 gives up a chain of many jumps
        assert seen == rule
    else:
        assert seen == rule[: len(seen)]
    assert mission.state is PlanState.COMPLETE or len(seen) == 200


def test_the_speed_in_force_is_that_of_the_last_change_before() -> None:
    items = [
        MissionItem(MissionCommand.WAYPOINT),
        MissionItem(MissionCommand.DO_CHANGE_SPEED, (1.0, 3.0, None, None)),
        MissionItem(MissionCommand.WAYPOINT),
        MissionItem(MissionCommand.DO_CHANGE_SPEED, (1.0, -1.0, None, None)),
        MissionItem(MissionCommand.WAYPOINT),
    ]
    assert [speed_before(items, i) for i in range(5)] == [None, None, 3.0, 3.0, None]
