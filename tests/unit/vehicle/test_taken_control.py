"""The pilot and the failsafes win, whatever is pursued; against a scripted autopilot."""

from __future__ import annotations

import pytest
from autopilot import (
    ACCEPTED,
    ARM,
    SET_MODE,
    TICK_S,
    Meeting,
    in_offboard,
    of_type,
)

from companion.mavlink.framing import dialect
from companion.mavlink.px4_modes import custom_mode
from companion.outcomes import Failed, Progress
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.ports.state import Mode

SETPOINT = "SET_POSITION_TARGET_LOCAL_NED"
AHEAD = Setpoint((0.5, 0.2, -2.0), (1.0, 0.5, 0.1), (0.3, 0.2, 0.1), 0.4)


def heartbeat(meeting: Meeting, mode: str) -> bytes:
    """As if from the autopilot, in another mode, and disarmed."""
    message = dialect.MAVLink_heartbeat_message(2, 12, 1, custom_mode(mode), 3, 3)
    return meeting.autopilot.codec.pack(message)


# -- authority -------------------------------------------------------------------------------------


def test_a_mode_that_we_did_not_ask_for_ends_all_at_once_and_for_good(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.fly(AHEAD)
    meeting.vehicle.payloads.send(25, dialect.MAV_CMD_USER_1, (1.0,), None)
    meeting.autopilot.mode = "POSCTL"
    meeting.autopilot.is_idle = True
    sent = meeting.run(3.0)
    assert meeting.vehicle.control.takeover == Takeover(Mode.POSCTL, is_failsafe=False)
    assert sent == []
    assert meeting.vehicle.goals.pursue(Goal.OFFBOARD) == Failed("the pilot has control, in POSCTL")
    meeting.autopilot.mode = "OFFBOARD"
    sent = meeting.run(3.0, act=lambda: meeting.vehicle.goals.pursue(Goal.OFFBOARD))
    assert sent == []
    assert meeting.vehicle.control.takeover is not None


@pytest.mark.parametrize("goal", [Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD, Goal.HOLDING])
def test_a_single_heartbeat_of_another_mode_stops_and_ends_nothing(
    meeting: Meeting, goal: Goal
) -> None:
    """Forged, disarmed besides: nothing leaves until the autopilot itself is heard again."""
    if goal is Goal.HOLDING:
        in_offboard(meeting)
    elif goal is not Goal.ARMED:
        meeting.pursue(Goal.ARMED)
    meeting.vehicle.setpoints.fly(AHEAD)
    meeting.tick(act=lambda: meeting.vehicle.goals.pursue(goal))
    before, meeting.is_quiet = meeting.vehicle.state, True
    goals = meeting.vehicle.goals
    assert meeting.tick(heartbeat(meeting, "POSCTL"), act=lambda: goals.pursue(goal)) == []
    assert meeting.vehicle.control.is_doubted and meeting.vehicle.control.takeover is None
    assert meeting.vehicle.state == before
    assert meeting.run(0.8, act=lambda: meeting.vehicle.goals.pursue(goal)) == []
    meeting.is_quiet = False
    assert meeting.pursue(goal) is Progress.DONE
    assert not meeting.vehicle.control.is_doubted and meeting.vehicle.control.takeover is None


def test_release_ends_a_doubt(meeting: Meeting) -> None:
    """Nothing is asked for any more, so no mode is another one."""
    in_offboard(meeting)
    meeting.tick(heartbeat(meeting, "POSCTL"))
    meeting.vehicle.release()
    assert not meeting.vehicle.control.is_doubted
    meeting.autopilot.mode = "POSCTL"
    meeting.run(1.0)
    assert meeting.vehicle.control.takeover is None
    assert meeting.vehicle.state is not None and meeting.vehicle.state.heartbeat.mode is Mode.POSCTL


def test_a_failsafe_is_not_called_a_pilot(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.autopilot.mode = "AUTO.RTL"
    meeting.autopilot.system_status = dialect.MAV_STATE_CRITICAL
    meeting.tick()
    assert meeting.vehicle.control.takeover == Takeover(Mode.RTL, is_failsafe=True)


def test_a_mode_that_nobody_knows_was_chosen_by_somebody_else(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.autopilot.mode = "STABILIZED"
    meeting.run(2 * TICK_S)
    assert meeting.vehicle.control.takeover == Takeover(Mode.OTHER, is_failsafe=False)


@pytest.mark.parametrize("goal", [Goal.AIRBORNE, Goal.OFFBOARD, Goal.HOLDING, Goal.LANDED])
def test_the_pilot_wins_while_a_goal_is_pursued(meeting: Meeting, goal: Goal) -> None:
    if goal in (Goal.HOLDING, Goal.LANDED):
        in_offboard(meeting)
    else:
        meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True
    meeting.run(0.5, act=lambda: meeting.vehicle.goals.pursue(goal))
    assert meeting.vehicle.control.takeover is None
    meeting.autopilot.mode = "ALTCTL"
    meeting.run(2 * TICK_S)
    assert meeting.vehicle.control.takeover == Takeover(Mode.ALTCTL, is_failsafe=False)


@pytest.mark.parametrize("mode", ["AUTO.LOITER", "OFFBOARD", "POSCTL"])
def test_a_vehicle_that_has_landed_falls_back_to_a_mode_of_its_own(
    meeting: Meeting, mode: str
) -> None:
    """To the one chosen last that it may be armed in: ours, or that in which it stood at first."""
    meeting.autopilot.mode = "POSCTL"
    in_offboard(meeting)
    meeting.pursue(Goal.LANDED)
    meeting.autopilot.mode = mode
    meeting.tick()
    assert meeting.vehicle.control.takeover is None


def test_a_pilot_on_the_dock_is_not_overruled(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.pursue(Goal.LANDED)
    meeting.autopilot.mode = "MANUAL"
    sent = meeting.run(3.0, act=lambda: meeting.vehicle.goals.pursue(Goal.ARMED))
    assert meeting.vehicle.control.takeover == Takeover(Mode.MANUAL, is_failsafe=False)
    assert of_type(sent, "COMMAND_LONG") == []


@pytest.mark.parametrize("mode", ["POSCTL", "MANUAL", "ALTCTL", "STABILIZED"])
def test_the_pilot_wins_while_the_vehicle_is_armed(meeting: Meeting, mode: str) -> None:
    """From the first command on: three refusals to arm, and then the pilot takes the sticks."""
    meeting.autopilot.results[ARM] = [dialect.MAV_RESULT_TEMPORARILY_REJECTED] * 3 + [ACCEPTED]
    meeting.run(2.5, act=lambda: meeting.vehicle.goals.pursue(Goal.ARMED))
    meeting.autopilot.mode = mode
    sent = meeting.run(30.0, act=lambda: meeting.vehicle.goals.pursue(Goal.ARMED))
    assert of_type(sent, "COMMAND_LONG") == []
    takeover = meeting.vehicle.control.takeover
    assert takeover is not None and not takeover.is_failsafe
    assert not meeting.autopilot.is_armed


def test_before_the_first_goal_any_mode_is_welcome(meeting: Meeting) -> None:
    for mode in ("MANUAL", "POSCTL", "AUTO.LOITER"):
        meeting.autopilot.mode = mode
        meeting.tick()
    assert meeting.vehicle.control.takeover is None
    assert meeting.pursue(Goal.ARMED) is Progress.DONE


def test_a_vehicle_that_was_disarmed_is_not_asked_to_take_off(meeting: Meeting) -> None:
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_armed = False
    meeting.tick()
    sent = meeting.run(5.0, act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    assert of_type(sent, "COMMAND_LONG") == []
    outcome = meeting.vehicle.goals.pursue(Goal.AIRBORNE)
    assert outcome == Failed("not airborne: disarmed")


# -- a mode that was heard too long ago ------------------------------------------------------------


def test_a_stale_mode_is_not_the_hold_after_the_take_off(meeting: Meeting) -> None:
    """Heartbeats are lost while it climbs: the hold heard last is that of the ground."""
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True
    meeting.autopilot.unsent = {"HEARTBEAT"}
    meeting.run(1.0, act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    meeting.autopilot.mode, meeting.autopilot.is_landed = "AUTO.TAKEOFF", False
    for _ in range(60):
        meeting.tick(act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
        assert meeting.vehicle.goals.pursue(Goal.AIRBORNE) is Progress.RUNNING
    meeting.autopilot.unsent = set()
    meeting.run(1.0, act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    assert meeting.vehicle.control.takeover is None
    assert meeting.vehicle.goals.pursue(Goal.AIRBORNE) is Progress.RUNNING
    meeting.autopilot.mode, meeting.autopilot.position[2] = "AUTO.LOITER", -1.2
    assert meeting.pursue(Goal.AIRBORNE) is Progress.DONE


@pytest.mark.parametrize(("up_m", "is_pilot"), [(0.4, True), (0.6, False)])
def test_a_hold_in_the_climb_is_a_pilots_as_far_as_the_height_tells(
    up_m: float, is_pilot: bool, meeting: Meeting
) -> None:
    """Seen on a PX4: a take-off to 2 m ends by itself from 1.1 m up on, by its own estimate."""
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True
    meeting.tick(act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    meeting.autopilot.mode, meeting.autopilot.is_landed = "AUTO.TAKEOFF", False
    meeting.run(2.0, act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    meeting.autopilot.mode, meeting.autopilot.position[2] = "AUTO.LOITER", -up_m
    outcome = meeting.pursue(Goal.AIRBORNE, 5.0)
    assert outcome == (
        Failed("the pilot has control, in AUTO.LOITER") if is_pilot else Progress.DONE
    )


def test_no_mode_is_asked_for_while_the_mode_is_not_known(meeting: Meeting) -> None:
    """A pilot may have taken over in the meantime."""
    in_offboard(meeting)
    meeting.autopilot.unsent = {"HEARTBEAT"}
    meeting.run(2.0)
    meeting.autopilot.mode = "POSCTL"
    sent = meeting.run(2.0, act=lambda: meeting.vehicle.goals.pursue(Goal.HOLDING))
    assert of_type(sent, "COMMAND_LONG") == []
    meeting.autopilot.unsent = set()
    meeting.run(2 * TICK_S)
    assert meeting.vehicle.control.takeover == Takeover(Mode.POSCTL, is_failsafe=False)


def test_a_mode_on_the_way_is_not_a_take_over(meeting: Meeting) -> None:
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True
    meeting.tick(act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    for mode in ("AUTO.TAKEOFF", "AUTO.LOITER"):
        meeting.autopilot.mode = mode
        meeting.tick(act=lambda: meeting.vehicle.goals.pursue(Goal.AIRBORNE))
    assert meeting.vehicle.control.takeover is None


def test_a_parameter_is_asked_for_until_it_is_answered(meeting: Meeting) -> None:
    meeting.autopilot.parameters.clear()
    sent = meeting.run(2.0, act=lambda: meeting.vehicle.parameters.read("COM_OF_LOSS_T"))
    questions = of_type(sent, "PARAM_REQUEST_READ")
    assert {(q.target_system, q.target_component, q.param_id) for q in questions} == {
        (1, 1, "COM_OF_LOSS_T")
    }
    assert 3 <= len(questions) <= 4
    meeting.autopilot.parameters["COM_OF_LOSS_T"] = 0.5
    meeting.run(1.0)
    assert meeting.vehicle.parameters.read("COM_OF_LOSS_T") == 0.5
    assert of_type(meeting.run(2.0), "PARAM_REQUEST_READ") == []


def test_the_mode_of_the_start_is_the_pilots_once_it_was_left(meeting: Meeting) -> None:
    meeting.autopilot.mode = "POSCTL"
    meeting.pursue(Goal.ARMED)
    meeting.autopilot.is_idle = True

    def act() -> object:
        return meeting.vehicle.goals.pursue(Goal.AIRBORNE)

    meeting.tick(act=act)
    meeting.autopilot.mode, meeting.autopilot.is_landed = "AUTO.TAKEOFF", False
    meeting.tick(act=act)
    meeting.autopilot.mode = "POSCTL"
    sent = meeting.run(5.0, act=act)
    assert of_type(sent, "COMMAND_LONG") == []
    assert meeting.vehicle.control.takeover == Takeover(Mode.POSCTL, is_failsafe=False)


def test_a_vehicle_left_in_offboard_holds_before_it_arms(meeting: Meeting) -> None:
    """PX4 falls back to OFFBOARD after our landing, and arms there with setpoints alone."""
    meeting.autopilot.mode = "OFFBOARD"
    assert meeting.pursue(Goal.ARMED) is Progress.DONE
    hold, arm = of_type(meeting.autopilot.heard, "COMMAND_LONG")
    assert (hold.command, hold.param2, hold.param3) == (SET_MODE, 4.0, 3.0)
    assert arm.command == ARM
    assert meeting.vehicle.control.takeover is None


def test_a_mode_that_the_pilot_chose_is_armed_in(meeting: Meeting) -> None:
    meeting.autopilot.mode = "POSCTL"
    assert meeting.pursue(Goal.ARMED) is Progress.DONE
    assert [c.command for c in of_type(meeting.autopilot.heard, "COMMAND_LONG")] == [ARM]


def test_a_pilot_s_mode_instead_of_the_hold_ends_the_arming(meeting: Meeting) -> None:
    meeting.autopilot.mode = "OFFBOARD"
    meeting.autopilot.is_idle = True
    meeting.tick(act=lambda: meeting.vehicle.goals.pursue(Goal.ARMED))
    meeting.autopilot.mode = "POSCTL"
    assert isinstance(meeting.pursue(Goal.ARMED), Failed)
    assert meeting.vehicle.control.takeover == Takeover(Mode.POSCTL, is_failsafe=False)
    assert ARM not in [c.command for c in of_type(meeting.autopilot.heard, "COMMAND_LONG")]


def test_a_landed_vehicle_is_sent_no_setpoint_in_offboard(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.fly(AHEAD)
    assert meeting.pursue(Goal.LANDED) is Progress.DONE
    meeting.autopilot.heard.clear()
    meeting.autopilot.mode = "OFFBOARD"
    for _ in range(20):
        meeting.tick()
    assert of_type(meeting.autopilot.heard, SETPOINT) == []
