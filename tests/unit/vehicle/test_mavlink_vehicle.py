"""A vehicle over MAVLink, byte for byte, against a scripted autopilot."""

from __future__ import annotations

import math
from typing import Any

import pytest
from autopilot import (
    ACCEPTED,
    CALL,
    CHARGE,
    ENVELOPE,
    TARGET,
    TICK_S,
    Autopilot,
    Meeting,
    battery,
    in_offboard,
    is_close,
    named,
    of_type,
)
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.geofence import KeptFence
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.signals import Signal
from companion.outcomes import Failed, Progress, Refusal
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.setpoints import Setpoint, hold_at
from companion.vehicle.ports.state import Mode

RETURN = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
USER_1 = dialect.MAV_CMD_USER_1
DISARM = dialect.MAV_CMD_COMPONENT_ARM_DISARM
SETPOINT = "SET_POSITION_TARGET_LOCAL_NED"
AHEAD = Setpoint((0.5, 0.2, -2.0), (1.0, 0.5, 0.1), (0.3, 0.2, 0.1), 0.4)


def command_to(target: tuple[int, int], number: int = RETURN) -> Any:
    return dialect.MAVLink_command_long_message(*target, number, 0, 0, 0, 0, 0, 0, 0, 0)


# -- who is who ------------------------------------------------------------------------------------


def test_other_systems_are_ignored(meeting: Meeting) -> None:
    in_offboard(meeting)
    state = meeting.vehicle.state
    other = Autopilot(system=2)
    other.mode, other.is_armed, other.position = "POSCTL", True, [5.0, 5.0, -1.0]
    meeting.tick(*other.telemetry(), other.codec.pack(named("target", 1)))
    assert meeting.vehicle.control.takeover is None
    assert meeting.readings == [(CHARGE, 80.0)]
    assert state is not None and meeting.vehicle.state is not None
    assert meeting.vehicle.state.motion.position == state.motion.position


def test_only_the_autopilot_says_where_the_vehicle_is(meeting: Meeting) -> None:
    meeting.tick()
    other = Autopilot(system=1, component=25)
    other.position, other.is_armed, other.mode = [5.0, 5.0, -1.0], True, "POSCTL"
    meeting.tick(*other.telemetry())
    assert meeting.vehicle.state is not None
    assert meeting.vehicle.state.motion.position == (0.0, 0.0, 0.0)
    assert not meeting.vehicle.state.heartbeat.is_armed


# -- setpoints -------------------------------------------------------------------------------------


def test_a_setpoint_on_the_wire(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.fly(AHEAD)
    (sent,) = of_type(meeting.tick(), SETPOINT)
    assert (sent.target_system, sent.target_component) == (1, 1)
    assert sent.coordinate_frame == dialect.MAV_FRAME_LOCAL_NED
    assert sent.type_mask == dialect.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
    assert is_close((sent.x, sent.y, sent.z), AHEAD.position)
    assert is_close((sent.vx, sent.vy, sent.vz), AHEAD.velocity)
    assert is_close((sent.afx, sent.afy, sent.afz), AHEAD.acceleration)
    assert math.isclose(sent.yaw, 0.4, rel_tol=1e-6)
    assert sent.time_boot_ms == pytest.approx(1000 * meeting.now_s, abs=1)


def test_the_mission_begins_at_home_wherever_the_local_frame_does(meeting: Meeting) -> None:
    meeting.autopilot.home = [3.0, -4.0, 0.5]
    meeting.autopilot.position = [3.0, -4.0, 0.5]
    in_offboard(meeting)
    meeting.tick()
    state = meeting.vehicle.state
    assert state is not None and is_close(state.motion.position, (0.0, 0.0, -2.0))
    meeting.vehicle.setpoints.fly(AHEAD)
    (sent,) = of_type(meeting.tick(), SETPOINT)
    assert is_close((sent.x, sent.y, sent.z), (3.5, -3.8, -1.5))


def test_one_setpoint_leaves_per_transmit_and_none_by_itself(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.fly(AHEAD)
    for _ in range(40):
        assert len(of_type(meeting.tick(), SETPOINT)) == 1
    meeting.vehicle.release()
    assert of_type(meeting.run(2.0), SETPOINT) == []


def test_setpoints_pass_the_gate(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.fly(hold_at((50.0, 0.0, -2.0), 0.0))
    (sent,) = of_type(meeting.tick(), SETPOINT)
    assert is_close((sent.x, sent.y, sent.z), (0.0, 0.0, -2.0))
    assert meeting.vehicle.setpoints.refusal == Refusal("outside the fence")
    meeting.vehicle.setpoints.fly(AHEAD)
    meeting.tick()
    assert meeting.vehicle.setpoints.refusal is None


def test_the_gate_keeps_to_a_fence_that_came_later(meeting: Meeting) -> None:
    in_offboard(meeting)
    around = ((-9.0, -9.0), (-9.0, 9.0), (0.5, 9.0), (0.5, -9.0))
    ahead = ((-1.0, 0.2), (-1.0, 0.4), (9.0, 0.4), (9.0, 0.2))
    outside = Refusal("outside the autopilot's own fence")
    for fence, position, refusal in (
        (KeptFence((), ()), (0.6, 0.0, -2.0), None),
        (KeptFence((around,), ()), (0.6, 0.0, -2.0), outside),
        (KeptFence((), (ahead,)), (0.0, 0.3, -2.0), Refusal("in a keep-out zone")),
    ):
        meeting.vehicle.setpoints.keep_within(fence)
        meeting.vehicle.setpoints.fly(hold_at(position, 0.0))
        meeting.tick()
        assert meeting.vehicle.setpoints.refusal == refusal


def test_the_gate_follows_the_speed_limit_in_force(meeting: Meeting) -> None:
    in_offboard(meeting)
    for limit_mps, refusal in ((1.0, Refusal("1.1 m/s is too fast")), (1.2, None)):
        meeting.vehicle.setpoints.set_speed_limit(limit_mps)
        meeting.vehicle.setpoints.fly(AHEAD)
        meeting.tick()
        assert meeting.vehicle.setpoints.refusal == refusal


def test_the_gate_knows_what_is_of_the_task_and_whether_that_is_violated(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.set_violated(True)
    for is_for_task, refusal in ((True, Refusal("the task is violated")), (False, None)):
        meeting.vehicle.setpoints.fly(AHEAD, is_for_task=is_for_task)
        meeting.tick()
        assert meeting.vehicle.setpoints.refusal == refusal


def test_a_heading_that_is_heard_no_longer_holds(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.autopilot.unsent = {"ATTITUDE"}
    sent: Any = None
    for _ in range(12):
        meeting.vehicle.setpoints.fly(AHEAD)
        (sent,) = of_type(meeting.tick(), SETPOINT)
    assert meeting.vehicle.setpoints.refusal == Refusal("the heading is 0.6 s old")
    assert sent.vx == 0.0


def test_no_setpoint_leaves_in_another_mode_than_ours(meeting: Meeting) -> None:
    meeting.pursue(Goal.ARMED)
    meeting.pursue(Goal.AIRBORNE)
    meeting.vehicle.setpoints.fly(hold_at((0.0, 0.0, -2.0), 0.0))
    assert of_type(meeting.run(2.0), SETPOINT) == []


def test_setpoints_are_streamed_before_offboard_is_asked_for(meeting: Meeting) -> None:
    meeting.pursue(Goal.ARMED)
    meeting.pursue(Goal.AIRBORNE)
    meeting.vehicle.setpoints.fly(hold_at((0.0, 0.0, -2.0), 0.0))
    before = len(meeting.autopilot.heard)
    meeting.pursue(Goal.OFFBOARD)
    kinds = [m.get_type() for m in meeting.autopilot.heard[before:]]
    assert kinds[: kinds.index("COMMAND_LONG")].count(SETPOINT) >= 20  # a second of them


def test_stale_telemetry_holds_and_then_is_silent(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.fly(AHEAD)
    meeting.tick()
    meeting.is_quiet = True
    heard_s = meeting.now_s
    sent = of_type(meeting.run(5.0), SETPOINT)
    velocities = [(m.left_s - heard_s, m.vx) for m in sent]
    assert all(is_close((vx,), (1.0,)) for age_s, vx in velocities if age_s < 0.49)
    assert all(vx == 0.0 for age_s, vx in velocities if age_s > 0.51)
    assert velocities[-1][0] == pytest.approx(3.0, abs=2 * TICK_S)
    meeting.is_quiet = False
    assert len(of_type(meeting.tick(), SETPOINT)) == 1


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_position_that_is_not_a_number_is_no_position(meeting: Meeting, number: float) -> None:
    in_offboard(meeting)
    meeting.vehicle.setpoints.fly(AHEAD)
    meeting.tick()
    known = meeting.vehicle.state
    meeting.autopilot.yaw_rad = number
    sent: list[Any] = []
    for _ in range(12):
        meeting.autopilot.position = [number, 0.0, -2.0]
        sent = of_type(meeting.tick(), SETPOINT)
    state = meeting.vehicle.state
    assert known is not None and state is not None
    assert state.motion.position == known.motion.position
    assert state.attitude.yaw_rad == known.attitude.yaw_rad
    assert [m.vx for m in sent] == [0.0]  # old by now, so it holds


# -- commands of skills ----------------------------------------------------------------------------


def payload(answer: int, target: tuple[int, int] = (1, 191)) -> bytes:
    """An answer of the payload to our command."""
    message = dialect.MAVLink_command_ack_message(USER_1, answer, 0, 0, *target)
    return MavlinkCodec(1, 25).pack(message)


@pytest.mark.parametrize("target", [(1, 191), (0, 0)])  # to us, or by a sender that names nobody
def test_a_command_to_a_component_and_its_answer(meeting: Meeting, target: tuple[int, int]) -> None:
    meeting.tick()
    ticket = meeting.vehicle.payloads.send(25, USER_1, (1.5, -2.0), None)
    (sent,) = of_type(meeting.tick(), "COMMAND_LONG")
    assert (sent.target_system, sent.target_component, sent.command) == (1, 25, USER_1)
    assert [sent.param1, sent.param2, sent.param3, sent.param7] == [1.5, -2.0, 0.0, 0.0]
    assert meeting.vehicle.payloads.outcome(ticket) is Progress.RUNNING
    meeting.tick(payload(ACCEPTED, target))
    assert meeting.vehicle.payloads.outcome(ticket) is Progress.DONE


def test_a_refusal_is_handed_on_in_words(meeting: Meeting) -> None:
    meeting.tick()
    ticket = meeting.vehicle.payloads.send(25, USER_1, (), None)
    meeting.tick(payload(dialect.MAV_RESULT_TEMPORARILY_REJECTED))
    assert meeting.vehicle.payloads.outcome(ticket) is Progress.RUNNING
    meeting.tick(payload(dialect.MAV_RESULT_UNSUPPORTED))
    outcome = meeting.vehicle.payloads.outcome(ticket)
    assert outcome == Failed("unsupported")


def test_an_answer_to_somebody_else_is_not_ours(meeting: Meeting) -> None:
    meeting.tick()
    ticket = meeting.vehicle.payloads.send(25, USER_1, (), None)
    theirs = dialect.MAVLink_command_ack_message(USER_1, ACCEPTED, 0, 0, 255, 190)
    meeting.tick(MavlinkCodec(1, 25).pack(theirs))
    meeting.tick(MavlinkCodec(2, 25).pack(theirs))
    assert meeting.vehicle.payloads.outcome(ticket) is Progress.RUNNING


def test_a_forgotten_command_is_not_sent_again(meeting: Meeting) -> None:
    meeting.tick()
    meeting.vehicle.payloads.forget(meeting.vehicle.payloads.send(25, USER_1, (), None))
    assert of_type(meeting.run(3.0), "COMMAND_LONG") == []


@pytest.mark.parametrize("component", [0, 1, 25])
def test_a_command_that_moves_the_vehicle_never_leaves(component: int, meeting: Meeting) -> None:
    meeting.tick()
    ticket = meeting.vehicle.payloads.send(component, DISARM, (0.0, 21196.0), None)
    assert of_type(meeting.run(1.0), "COMMAND_LONG") == []
    outcome = meeting.vehicle.payloads.outcome(ticket)
    assert isinstance(outcome, Failed)
    assert outcome.reason.startswith("not sent: ")


# -- readings --------------------------------------------------------------------------------------


def test_signals_come_in_their_order_and_instances_apart(meeting: Meeting) -> None:
    meeting.is_quiet = True
    meeting.tick(*meeting.autopilot.telemetry())
    detector = MavlinkCodec(1, 26)
    texts = [named("target", 3), named("other", 9), battery(42), named("target", 0)]
    meeting.tick(*(detector.pack(m) for m in texts))
    assert meeting.readings == [(TARGET, 3.0), (CHARGE, 42.0), (TARGET, 0.0)]
    meeting.tick()
    assert meeting.readings == []


def test_an_unknown_charge_is_no_number(meeting: Meeting) -> None:
    meeting.autopilot.battery_percent = -1
    meeting.tick()
    assert meeting.readings == []
    assert meeting.vehicle.state is not None
    assert meeting.vehicle.state.battery.percent is None


def test_an_unknown_charge_of_the_system_is_no_number_either() -> None:
    charge = Signal("SYS_STATUS", "", "battery_remaining")
    meeting = Meeting(ENVELOPE, frozenset({charge}))
    meeting.tick()
    for percent in (-1, 55):
        status = dialect.MAVLink_sys_status_message(0, 0, 0, 0, 0, 0, percent, *[0] * 6)
        meeting.tick(meeting.autopilot.codec.pack(status))
        assert meeting.readings == ([] if percent < 0 else [(charge, 55.0)])


def test_a_number_that_is_not_finite_is_not_handed_on() -> None:
    height = Signal("NAMED_VALUE_FLOAT", "height", "value")
    meeting = Meeting(ENVELOPE, frozenset({height}))
    meeting.tick()
    for value in (math.nan, math.inf, 2.5):
        message = dialect.MAVLink_named_value_float_message(0, b"height", value)
        meeting.tick(MavlinkCodec(1, 26).pack(message))
    assert meeting.readings == [(height, 2.5)]


# -- whatever arrives ------------------------------------------------------------------------------

TAKEN = [0, 22, 30, 32, 75, 76, 77, 147, 242, 245, 252, 253]
"""Numbers of the messages that are looked into; HEARTBEAT is the first, STATUSTEXT the last."""
MESSAGE_IDS = st.sampled_from(TAKEN) | st.sampled_from(sorted(dialect.mavlink_map))


@st.composite
def frames(draw: st.DrawFn) -> bytes:
    """A well-formed frame of any message with any payload, from our autopilot or a neighbour."""
    kind = dialect.mavlink_map[draw(MESSAGE_IDS)]
    payload = draw(st.binary(min_size=1, max_size=255))[: kind.unpacker.size]
    sender = dialect.MAVLink(None, 1, draw(st.sampled_from([1, 25, 191])))
    message = dialect.MAVLink_message(kind.id, kind.msgname)
    return bytes(message._pack(sender, kind.crc_extra, payload))


SIGNALS = frozenset({TARGET, CHARGE, CALL, Signal("STATUSTEXT", "", "severity")})


@pytest.mark.slow
@drawn(150)
@given(st.lists(frames() | st.binary(max_size=300), max_size=12))
def test_no_datagram_raises_or_lets_anything_but_good_setpoints_out(datagrams: list[bytes]) -> None:
    meeting = in_offboard(Meeting(ENVELOPE, SIGNALS))
    meeting.vehicle.setpoints.fly(AHEAD)
    sent = meeting.tick(*datagrams)
    assert all(map(math.isfinite, dict(meeting.readings).values()))
    for setpoint in of_type(sent, SETPOINT):
        numbers = [setpoint.x, setpoint.y, setpoint.z, setpoint.vx, setpoint.vy, setpoint.vz]
        assert all(map(math.isfinite, [*numbers, setpoint.yaw]))
    state = meeting.vehicle.state
    assert state is not None and state.heartbeat.mode in Mode
    assert all(
        map(math.isfinite, (*state.motion.position, *state.motion.velocity, state.attitude.yaw_rad))
    )


def test_junk_between_frames_loses_none_of_them(meeting: Meeting) -> None:
    stub = b"\xfd\xff\x00"
    junk = [stub, b"", b"\xfe", b"hello", bytes(300), stub]
    meeting.is_quiet = True
    mixed = [d for frame in meeting.autopilot.telemetry() for d in (frame, *junk)]
    meeting.tick(*mixed)
    assert meeting.vehicle.state is not None
    assert meeting.readings == [(CHARGE, 80.0)]


def test_a_frame_with_a_wrong_checksum_changes_nothing(meeting: Meeting) -> None:
    in_offboard(meeting)
    meeting.autopilot.mode = "POSCTL"
    heartbeat = bytearray(meeting.autopilot.telemetry()[0])
    heartbeat[-1] ^= 0xFF
    meeting.is_quiet = True
    meeting.tick(bytes(heartbeat))
    assert meeting.vehicle.control.takeover is None
