"""Goals are pursued until they are observed, and the pilot wins; against a scripted autopilot."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from autopilot import (
    ACCEPTED,
    ARM,
    LAND,
    SET_MODE,
    TAKE_OFF,
    Meeting,
    in_offboard,
    of_type,
)

from companion.mavlink.framing import dialect
from companion.outcomes import Failed, Progress
from companion.vehicle.goal_pursuit import ASK_AGAIN_S
from companion.vehicle.goals import EFFECT_S
from companion.vehicle.heard_time import QUIET_S
from companion.vehicle.ports.goals import Goal


def test_the_goals_of_a_flight_and_their_commands(meeting: Meeting) -> None:
    in_offboard(meeting)
    assert meeting.pursue(Goal.HOLDING) is Progress.DONE
    assert meeting.pursue(Goal.LANDED) is Progress.DONE
    commands = of_type(meeting.autopilot.heard, "COMMAND_LONG")
    assert [c.command for c in commands] == [ARM, TAKE_OFF, SET_MODE, SET_MODE, LAND]
    assert {(c.target_system, c.target_component) for c in commands} == {(1, 1)}
    arm, take_off, offboard, loiter, land = commands
    assert (arm.param1, arm.param2) == (1.0, 0.0)  # arm, without force
    assert take_off.param7 == meeting.autopilot.home_altitude_m + 2.0  # above mean sea level
    assert all(math.isnan(getattr(take_off, f"param{i}")) for i in (4, 5, 6))
    assert (offboard.param1, offboard.param2, offboard.param3) == (1.0, 6.0, 0.0)
    assert (loiter.param1, loiter.param2, loiter.param3) == (1.0, 4.0, 3.0)
    assert math.isnan(land.param5) and math.isnan(land.param6)  # where it is


def test_a_goal_that_is_reached_already_sends_nothing(meeting: Meeting) -> None:
    meeting.autopilot.is_armed = True
    assert meeting.pursue(Goal.ARMED) is Progress.DONE
    assert of_type(meeting.autopilot.heard, "COMMAND_LONG") == []


def test_without_a_state_a_goal_waits(meeting: Meeting) -> None:
    assert meeting.vehicle.goals.pursue(Goal.ARMED) is Progress.RUNNING
    assert [m.get_type() for m in meeting.vehicle.transmit(0.0)] == ["TIMESYNC"]


def test_a_goal_is_reached_when_it_is_observed_and_not_when_it_is_accepted(
    meeting: Meeting,
) -> None:
    meeting.autopilot.is_idle = True
    sent = meeting.run(10.0, act=lambda: meeting.vehicle.goals.pursue(Goal.ARMED))
    commands = of_type(sent, "COMMAND_LONG")
    assert len(commands) >= 3
    assert {c.confirmation for c in commands} == {0}  # each of them is a new one
    assert all(
        later.left_s - earlier.left_s >= ASK_AGAIN_S for earlier, later in pairwise(commands)
    )
    meeting.autopilot.is_idle = False
    assert meeting.pursue(Goal.ARMED) is Progress.DONE


def test_a_goal_that_is_never_observed_fails_in_its_time(meeting: Meeting) -> None:
    meeting.autopilot.is_idle = True
    outcome = meeting.pursue(Goal.ARMED)
    assert outcome == Failed("not armed after 12 s")
    assert meeting.now_s == pytest.approx(EFFECT_S, abs=0.2)


def test_a_vehicle_on_its_way_has_all_of_its_time(meeting: Meeting) -> None:
    """The limit is for nothing that happens."""
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True
    begun_s = meeting.now_s
    meeting.tick(act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    meeting.autopilot.mode = "AUTO.TAKEOFF"
    assert meeting.pursue(Goal.AIRBORNE) == Failed("not airborne after 60 s")
    meeting.autopilot.mode, meeting.autopilot.position[2] = "AUTO.LOITER", -1.2
    assert meeting.now_s - begun_s == pytest.approx(60.0, abs=0.2)
    begun_s = meeting.now_s
    assert meeting.pursue(Goal.AIRBORNE) == Failed("not airborne after 12 s")
    assert meeting.now_s - begun_s == pytest.approx(EFFECT_S, abs=0.2)


def test_a_command_that_was_not_answered_is_not_repeated_once_it_has_its_effect(
    meeting: Meeting,
) -> None:
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.results[TAKE_OFF] = [None]
    act = lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE)  # noqa: E731
    assert len(of_type(meeting.run(1.2, act=act), "COMMAND_LONG")) == 3
    meeting.autopilot.mode = "AUTO.TAKEOFF"
    meeting.tick(act=act)
    assert of_type(meeting.run(8.0, act=act), "COMMAND_LONG") == []


def test_no_answer_at_all_fails_after_silence(meeting: Meeting) -> None:
    meeting.autopilot.results[ARM] = [None]
    outcome = meeting.pursue(Goal.ARMED)
    assert outcome == Failed("not armed: no answer")
    assert meeting.now_s == pytest.approx(5.0, abs=0.2)
    commands = of_type(meeting.autopilot.heard, "COMMAND_LONG")
    assert [c.confirmation for c in commands] == list(range(10))


@pytest.mark.parametrize("goal", [Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD])
def test_no_time_passes_and_no_command_leaves_while_nothing_is_heard(
    meeting: Meeting, goal: Goal
) -> None:
    if goal is not Goal.ARMED:
        meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True
    act = lambda: meeting.vehicle.goals.pursue(goal)  # noqa: E731
    meeting.run(2.0, act=act)
    meeting.is_quiet = True
    sent = meeting.run(60.0, act=act)
    assert [c for c in of_type(sent, "COMMAND_LONG") if c.left_s > 2.0 + 2 * QUIET_S] == []
    assert meeting.vehicle.goals.pursue(goal) is Progress.RUNNING
    meeting.is_quiet, meeting.autopilot.is_idle = False, False
    assert meeting.pursue(goal) is Progress.DONE


def test_a_denial_is_final_and_says_what_the_autopilot_said(meeting: Meeting) -> None:
    meeting.autopilot.results[ARM] = [dialect.MAV_RESULT_DENIED]
    text = dialect.MAVLink_statustext_message(2, b"Arming denied: check level")
    meeting.tick(meeting.autopilot.codec.pack(text))
    outcome = meeting.pursue(Goal.ARMED)
    assert outcome == Failed("not armed: denied (autopilot: Arming denied: check level)")
    assert len(of_type(meeting.autopilot.heard, "COMMAND_LONG")) == 1


def test_a_temporary_rejection_is_asked_again_after_a_second(meeting: Meeting) -> None:
    rejected = dialect.MAV_RESULT_TEMPORARILY_REJECTED
    meeting.autopilot.results[ARM] = [rejected, rejected, ACCEPTED]
    sent = meeting.run(4.0, act=lambda: meeting.vehicle.goals.pursue(Goal.ARMED))
    times = [c.left_s for c in of_type(sent, "COMMAND_LONG")]
    assert len(times) == 3
    assert all(1.0 <= later - earlier <= 1.2 for earlier, later in pairwise(times))
    assert meeting.autopilot.is_armed


def test_a_vehicle_on_its_way_is_not_asked_again(meeting: Meeting) -> None:
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True
    act = lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE)  # noqa: E731
    meeting.tick(act=act)
    meeting.autopilot.mode = "AUTO.TAKEOFF"
    assert of_type(meeting.run(20.0, act=act), "COMMAND_LONG") == []
    meeting.autopilot.mode, meeting.autopilot.is_landed = "AUTO.LOITER", False
    meeting.autopilot.position[2] = -1.2
    assert meeting.pursue(Goal.AIRBORNE) is Progress.DONE


def test_a_goal_that_has_failed_may_be_pursued_again(meeting: Meeting) -> None:
    """With a command of its own, and all of its time."""
    meeting.autopilot.results[ARM] = [dialect.MAV_RESULT_DENIED, ACCEPTED]
    assert meeting.pursue(Goal.ARMED) == Failed("not armed: denied")
    assert meeting.pursue(Goal.ARMED) is Progress.DONE
    assert len(of_type(meeting.autopilot.heard, "COMMAND_LONG")) == 2


def test_a_goal_that_was_not_reached_in_its_time_has_all_of_it_again(meeting: Meeting) -> None:
    meeting.autopilot.is_idle = True
    assert meeting.pursue(Goal.ARMED) == Failed("not armed after 12 s")
    first_s = meeting.now_s
    assert meeting.pursue(Goal.ARMED) == Failed("not armed after 12 s")
    assert meeting.now_s - first_s == pytest.approx(EFFECT_S, abs=0.2)


def test_a_new_goal_ends_the_command_of_the_old_one(meeting: Meeting) -> None:
    meeting.autopilot.results[ARM] = [None]
    meeting.run(0.3, act=lambda: meeting.vehicle.goals.pursue(Goal.ARMED))
    sent = meeting.run(3.0, act=lambda: meeting.vehicle.goals.pursue(Goal.HOLDING))
    assert of_type(sent, "COMMAND_LONG") == []  # holding already, and nobody asks to arm
