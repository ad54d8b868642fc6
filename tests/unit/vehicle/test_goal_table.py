"""The table of goals by itself: what is asked for, in which words of MAVLink, and its bounds.

Sources: https://mavlink.io/en/messages/common.html for the parameters; PX4's custom modes.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from fakes import on_hold
from states import changed

from companion.mavlink.framing import dialect
from companion.vehicle.goals import APPROACHES, EFFECT_S, FALLEN_BACK, Pursuit
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Mode

NAN = math.nan
FLYING = replace(on_hold(50.0), landed_since_s=49.0)


@pytest.mark.parametrize(
    ("goal", "command", "parameters"),
    [
        (Goal.ARMED, dialect.MAV_CMD_COMPONENT_ARM_DISARM, (1, 0, 0, 0, 0, 0, 0)),
        (Goal.AIRBORNE, dialect.MAV_CMD_NAV_TAKEOFF, (NAN, NAN, NAN, NAN, NAN, NAN, 490.5)),
        (Goal.OFFBOARD, dialect.MAV_CMD_DO_SET_MODE, (1, 6, 0, 0, 0, 0, 0)),
        (Goal.HOLDING, dialect.MAV_CMD_DO_SET_MODE, (1, 4, 3, 0, 0, 0, 0)),
        (Goal.LANDED, dialect.MAV_CMD_NAV_LAND, (0, 0, 0, NAN, NAN, NAN, NAN)),
    ],
)
def test_what_is_asked_for(goal: Goal, command: int, parameters: tuple[float, ...]) -> None:
    assert APPROACHES[goal].command == command
    assert APPROACHES[goal].parameters(490.5) == pytest.approx(parameters, nan_ok=True)


def test_the_times_of_the_table() -> None:
    times = {goal: (each.lead_s, each.timeout_s) for goal, each in APPROACHES.items()}
    assert times == {
        Goal.ARMED: (0.0, math.inf),
        Goal.AIRBORNE: (0.0, 60.0),
        Goal.OFFBOARD: (1.0, math.inf),
        Goal.HOLDING: (0.0, math.inf),
        Goal.LANDED: (0.0, 120.0),
    }


def test_only_what_flies_needs_to_be_armed() -> None:
    needing = {goal for goal, each in APPROACHES.items() if each.needs_arming}
    assert needing == {Goal.AIRBORNE, Goal.OFFBOARD}


@pytest.mark.parametrize("is_landed", [True, False])
@pytest.mark.parametrize("is_armed", [True, False])
def test_landed_is_on_the_ground_and_disarmed(is_landed: bool, is_armed: bool) -> None:
    state = changed(FLYING, is_landed=is_landed, is_armed=is_armed)
    assert APPROACHES[Goal.LANDED].is_reached(state) is (is_landed and not is_armed)
    assert APPROACHES[Goal.ARMED].is_reached(state) is is_armed


@pytest.mark.parametrize("goal", [Goal.OFFBOARD, Goal.HOLDING])
@pytest.mark.parametrize("mode", list(Mode))
def test_a_goal_that_is_a_mode_is_reached_in_that_alone(goal: Goal, mode: Mode) -> None:
    wanted = Mode.OFFBOARD if goal is Goal.OFFBOARD else Mode.LOITER
    assert APPROACHES[goal].is_reached(changed(FLYING, mode=mode)) is (mode is wanted)


@pytest.mark.parametrize(
    ("news", "is_reached"),
    [
        ({}, True),
        ({"heartbeat_received_s": 49.0}, False),
        ({"heartbeat_received_s": 48.0}, False),
        ({"is_landed": True}, False),
        ({"mode": Mode.TAKEOFF}, False),
    ],
)
def test_airborne_is_a_hold_heard_after_the_ground_was_left(
    news: dict[str, object], is_reached: bool
) -> None:
    assert APPROACHES[Goal.AIRBORNE].is_reached(changed(FLYING, **news)) is is_reached


# -- a goal under way ------------------------------------------------------------------------------


def pursuit(goal: Goal, start_mode: Mode) -> Pursuit:
    return Pursuit(goal, APPROACHES[goal].passes | {start_mode}, start_mode, 100.0, 2.0, False)


def test_a_new_one_has_not_failed() -> None:
    assert not pursuit(Goal.ARMED, Mode.LOITER).has_failed


def test_the_mode_of_its_start_is_ours_until_it_was_left() -> None:
    landing = pursuit(Goal.LANDED, Mode.OFFBOARD)
    assert landing.admits(Mode.OFFBOARD, True, None)
    assert landing.admits(Mode.LAND, True, None)
    assert not landing.admits(Mode.OFFBOARD, True, None)


@pytest.mark.parametrize("goal", list(Goal))
@pytest.mark.parametrize("is_armed", [True, False])
@pytest.mark.parametrize("mode", [Mode.LOITER, Mode.OFFBOARD, Mode.ALTCTL, Mode.POSCTL])
def test_only_what_has_landed_falls_back(goal: Goal, is_armed: bool, mode: Mode) -> None:
    """To hold, to OFFBOARD, or to the mode in which it stood at first (ALTCTL here)."""
    begun = pursuit(goal, Mode.TAKEOFF)
    passes = mode in APPROACHES[goal].passes
    falls_back = goal is Goal.LANDED and not is_armed and mode is not Mode.POSCTL
    assert begun.admits(mode, is_armed, Mode.ALTCTL) is (passes or falls_back)


@pytest.mark.parametrize("fallen_back", [Mode.OFFBOARD, Mode.LOITER, Mode.ALTCTL])
@pytest.mark.parametrize("chosen", [Mode.LOITER, Mode.LAND, Mode.OFFBOARD, Mode.ALTCTL])
def test_what_stands_disarmed_falls_back_once(fallen_back: Mode, chosen: Mode) -> None:
    """What is chosen later, on a dock or in a wait on the ground, somebody has chosen."""
    landed = pursuit(Goal.LANDED, Mode.OFFBOARD)
    landed.admits(Mode.LAND, True, Mode.ALTCTL)
    for mode in (Mode.LAND, *[fallen_back] * FALLEN_BACK):
        assert landed.admits(mode, False, Mode.ALTCTL)
    assert landed.admits(chosen, False, Mode.ALTCTL) is (chosen is fallen_back)
    assert landed.admits(fallen_back, False, Mode.ALTCTL)


def test_one_that_says_late_where_it_falls_back_to_is_believed() -> None:
    landed = pursuit(Goal.LANDED, Mode.OFFBOARD)
    for mode in (*[Mode.LAND] * 20, Mode.LOITER):
        assert landed.admits(mode, False, None)
    assert not landed.admits(Mode.LAND, False, None)


@pytest.mark.parametrize("goal", list(Goal))
def test_what_has_no_effect_is_given_up_after_twelve_seconds(goal: Goal) -> None:
    """And after the time in which setpoints lead."""
    begun, late_s = pursuit(goal, Mode.POSCTL), EFFECT_S + APPROACHES[goal].lead_s
    assert begun.overdue_s(100.0 + late_s - 0.01, Mode.POSCTL) is None
    assert begun.overdue_s(100.0 + late_s, Mode.POSCTL) == late_s


@pytest.mark.parametrize(
    ("goal", "mode", "timeout_s"),
    [(Goal.AIRBORNE, Mode.TAKEOFF, 60.0), (Goal.LANDED, Mode.LAND, 120.0)],
)
def test_what_is_under_way_has_all_of_its_time(goal: Goal, mode: Mode, timeout_s: float) -> None:
    begun = pursuit(goal, Mode.LOITER)
    assert begun.overdue_s(100.0 + timeout_s - 0.01, mode) is None
    assert begun.overdue_s(100.0 + timeout_s, mode) == timeout_s
