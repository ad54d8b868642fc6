"""Component 191 as ground stations see it: services of the wire, without a flight."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from autopilot import ACCEPTED, ARM, Autopilot, of_type
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.flight_events.skills import PlaceReached, SkillFailed
from companion.flight_events.sortie import RunEnded, RunFailed, TaskSatisfied
from companion.ground.component import WANTED, Component
from companion.ground.operations import SystemStatus
from companion.ground.parameters import NAMES
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.parameters import INT32, REAL32, decode, encode
from companion.mission.signals import Signal
from companion.outcomes import Refusal
from companion.tick import TICK_S
from companion.vehicle.wire import Wire

DOCS = Path(__file__).parents[3] / "docs"
STATION = (255, 190)
START, PAUSE = dialect.MAV_CMD_MISSION_START, dialect.MAV_CMD_DO_PAUSE_CONTINUE
RETURN, USER_1 = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH, dialect.MAV_CMD_USER_1
ITEM = dialect.MAV_CMD_DO_SET_MISSION_CURRENT
REQUEST, INTERVAL = dialect.MAV_CMD_REQUEST_MESSAGE, dialect.MAV_CMD_SET_MESSAGE_INTERVAL
NOT_NOW = dialect.MAV_RESULT_TEMPORARILY_REJECTED
DENIED, UNSUPPORTED = dialect.MAV_RESULT_DENIED, dialect.MAV_RESULT_UNSUPPORTED


class Desk:
    """Where operators' wishes arrive; it says no if it has a reason."""

    def __init__(self) -> None:
        self.system_status = SystemStatus.STANDBY
        self.awaited = frozenset({"MAV_CMD_USER_1"})
        self.asked: list[str] = []
        self.refusal: Refusal | None = None

    def start(self) -> Refusal | None:
        return self._note("start")

    def pause(self) -> Refusal | None:
        return self._note("pause")

    def resume(self) -> Refusal | None:
        return self._note("resume")

    def return_home(self) -> Refusal | None:
        return self._note("return home")

    def _note(self, what: str) -> Refusal | None:
        self.asked.append(what)
        return self.refusal


class Radio:
    """The component on a wire with an autopilot that was heard, and ground stations."""

    def __init__(self) -> None:
        self.desk = Desk()
        self.component = Component(self.desk)
        self.now_s = 0.0
        self.readings: list[tuple[Signal, float]] = []
        self._wire = Wire()
        self._wire.listen(WANTED, frozenset())
        self._wire.parse(Autopilot().telemetry())
        self._ear = MavlinkCodec(0, 0)

    def raw(self, *datagrams: bytes) -> list[Any]:
        """One tick; what left, as messages."""
        self.now_s += TICK_S
        messages = self._wire.parse(list(datagrams))
        self.readings = self.component.receive(self.now_s, self._wire.system, messages)
        leaving = self.component.transmit(self.now_s)
        self.unknown = [m for m in leaving if m.id not in dialect.mavlink_map]
        sent = [m for d in self._wire.pack(leaving) for m in self._ear.parse(d)]
        for message in sent:
            message.left_s = self.now_s
        return sent

    def say(self, *messages: Any, sender: tuple[int, int] = STATION) -> list[Any]:
        return self.raw(*(MavlinkCodec(*sender).pack(m) for m in messages))

    def run(self, seconds: float) -> list[Any]:
        return [m for _ in range(round(seconds / TICK_S)) for m in self.raw()]

    def ask(self, number: int, *parameters: float, target: tuple[int, int] = (1, 191)) -> list[Any]:
        return self.say(command(number, *parameters, target=target))

    def result(self, number: int, *parameters: float) -> int:
        (answer,) = of_type(self.ask(number, *parameters), "COMMAND_ACK")
        assert answer.command == number
        assert (answer.target_system, answer.target_component) == STATION
        return int(answer.result)


def command(number: int, *parameters: float, target: tuple[int, int] = (1, 191)) -> Any:
    filled = (*parameters, *[0.0] * (7 - len(parameters)))
    return dialect.MAVLink_command_long_message(*target, number, 0, *filled)


@pytest.fixture
def radio() -> Radio:
    return Radio()


# -- heartbeat -------------------------------------------------------------------------------------


def test_the_heartbeat_is_an_onboard_controllers_at_1_hz(radio: Radio) -> None:
    beats = of_type(radio.run(20.0), "HEARTBEAT")
    assert {(b.type, b.autopilot, b.get_srcComponent()) for b in beats} == {(18, 8, 191)}
    assert {b.base_mode & dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED for b in beats} == {0}
    gaps = [later.left_s - earlier.left_s for earlier, later in pairwise(beats)]
    assert all(1.0 - 1e-6 <= gap <= 1.0 + TICK_S + 1e-6 for gap in gaps)


def test_the_first_heartbeat_comes_as_soon_as_the_system_is_known(radio: Radio) -> None:
    component = Component(radio.desk)
    component.receive(0.0, 0, [])
    assert component.transmit(0.0) == []
    component.receive(0.05, 1, [])
    assert [m.get_type() for m in component.transmit(0.05)] == ["HEARTBEAT"]


def test_a_change_of_the_status_is_told_at_once(radio: Radio) -> None:
    radio.run(0.3)
    for status, state in (
        (SystemStatus.ACTIVE, 4),
        (SystemStatus.CRITICAL, 5),
        (SystemStatus.STANDBY, 3),
    ):
        radio.desk.system_status = status
        (beat,) = of_type(radio.raw(), "HEARTBEAT")
        assert beat.system_status == state


# -- commands --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("asked", "what"),
    [
        ((START,), "start"),
        ((PAUSE, 0.0), "pause"),
        ((PAUSE, 1.0), "resume"),
        ((RETURN,), "return home"),
    ],
)
def test_what_an_operator_may_ask_for(radio: Radio, asked: Any, what: str) -> None:
    assert radio.result(*asked) == ACCEPTED
    radio.desk.refusal = Refusal("it rains")
    sent = radio.ask(*asked)
    (answer,), (text,) = of_type(sent, "COMMAND_ACK"), of_type(sent, "STATUSTEXT")
    assert answer.result == NOT_NOW
    assert (text.severity, text.text) == (dialect.MAV_SEVERITY_WARNING, "refused: it rains")
    assert radio.desk.asked == [what, what]
    assert radio.readings == []


@pytest.mark.parametrize("value", [0.5, 2.0, -1.0, math.nan, math.inf])
def test_neither_pause_nor_continue_is_denied(radio: Radio, value: float) -> None:
    assert radio.result(PAUSE, value) == DENIED
    assert radio.desk.asked == []


def test_there_are_no_mission_items(radio: Radio) -> None:
    assert radio.result(ITEM, 3.0) == DENIED


@pytest.mark.parametrize("form", ["long", "int"])
def test_a_command_that_an_event_waits_for_is_accepted(radio: Radio, form: str) -> None:
    call = command(USER_1)
    if form == "int":
        call = dialect.MAVLink_command_int_message(1, 191, 0, USER_1, 0, 0, 0, 0, 0, 0, 0, 0, 0)
    (ack,) = of_type(radio.say(call), "COMMAND_ACK")
    assert (ack.command, ack.result) == (USER_1, ACCEPTED)
    assert radio.readings == [(Signal("COMMAND", "", "MAV_CMD_USER_1"), 1.0)]


def test_a_return_that_an_event_waits_for_does_both(radio: Radio) -> None:
    radio.desk.awaited = frozenset({"MAV_CMD_NAV_RETURN_TO_LAUNCH"})
    assert radio.result(RETURN) == ACCEPTED
    assert radio.desk.asked == ["return home"]
    assert len(radio.readings) == 1


@pytest.mark.parametrize("number", [ARM, USER_1 + 1, INTERVAL, 31999, 65535])
def test_every_other_command_is_answered_with_unsupported(radio: Radio, number: int) -> None:
    assert radio.result(number) == UNSUPPORTED
    assert radio.readings == []


@pytest.mark.parametrize("target", [(1, 1), (1, 25), (2, 191), (1, 0), (0, 0)])
def test_a_command_to_somebody_else_is_theirs_to_answer(
    radio: Radio, target: tuple[int, int]
) -> None:
    assert of_type(radio.ask(START, target=target), "COMMAND_ACK") == []
    assert of_type(radio.ask(USER_1, target=target), "COMMAND_ACK") == []
    assert radio.readings == [] and radio.desk.asked == []


def test_several_ask_in_one_tick_and_each_gets_its_own_answer(radio: Radio) -> None:
    stations = [(250 + i, 190 + i) for i in range(5)]
    packed = [MavlinkCodec(*s).pack(command(31100 + i)) for i, s in enumerate(stations)]
    answers = of_type(radio.raw(*packed), "COMMAND_ACK")
    got = {(a.target_system, a.target_component): a.command for a in answers}
    assert got == {station: 31100 + i for i, station in enumerate(stations)}


def test_every_button_for_qgroundcontrol_is_understood(radio: Radio) -> None:
    text = (DOCS / "companion.MavlinkActions.json").read_text(encoding="utf-8")
    file = json.loads(text)
    assert (file["version"], file["fileType"]) == (1, "MavlinkActions")
    users = {f"MAV_CMD_USER_{i}" for i in range(1, 6)}
    radio.desk.awaited = frozenset(users)
    for action in file["actions"]:
        parameters = [float(action.get(f"param{i}", 0.0)) for i in range(1, 8)]
        assert action["compId"] == 191
        assert radio.result(action["mavCmd"], *parameters) == ACCEPTED, action["label"]
    assert radio.desk.asked == ["start", "pause", "resume", "return home"]


# -- messages on request ---------------------------------------------------------------------------


def test_messages_on_request(radio: Radio) -> None:
    radio.run(0.3)
    version = of_type(radio.ask(REQUEST, 148.0), "AUTOPILOT_VERSION")
    assert len(version) == 1
    assert version[0].capabilities & dialect.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    assert len(of_type(radio.ask(REQUEST, 0.0), "HEARTBEAT")) == 1
    assert radio.result(REQUEST, 33.0) == UNSUPPORTED
    assert radio.result(REQUEST, math.nan) == UNSUPPORTED
    assert (
        len(
            of_type(
                radio.ask(dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1.0), "AUTOPILOT_VERSION"
            )
        )
        == 1
    )


def test_the_protocol_version_is_laid_out_as_common_xml_says(radio: Radio) -> None:
    """Its CRC_EXTRA is computed from the definition, by the rule of the MAVLink guide."""
    for asked in ((REQUEST, 300.0), (dialect.MAV_CMD_REQUEST_PROTOCOL_VERSION, 1.0)):
        radio.ask(*asked)
        (version,) = radio.unknown
        crc = dialect.x25crc(b"PROTOCOL_VERSION ")
        for kind, name, length in zip(
            version.fieldtypes, version.ordered_fieldnames, version.lengths, strict=True
        ):
            crc.accumulate(f"{kind} {name} ".encode())
            if length > 1:
                crc.accumulate(bytes([length]))
        assert (crc.crc & 0xFF) ^ (crc.crc >> 8) == version.crc_extra
        frame = MavlinkCodec(1, 191).pack(version)
        assert frame[7:10] == (300).to_bytes(3, "little")
        assert frame[10:15] == b"\xc8\0\xc8\0\xc8"  # zeros at the end are left out


# -- parameters ------------------------------------------------------------------------------------


def listed(sent: list[Any]) -> list[Any]:
    return of_type(sent, "PARAM_VALUE")


@pytest.mark.parametrize("component", [0, 191])
def test_the_list_is_complete(radio: Radio, component: int) -> None:
    values = listed(radio.say(dialect.MAVLink_param_request_list_message(1, component)))
    assert [v.param_index for v in values] == list(range(values[0].param_count))
    assert [v.param_id for v in values] == list(NAMES)
    assert {v.param_type for v in values} == {INT32, REAL32}
    for index, value in enumerate(values):
        by_index = dialect.MAVLink_param_request_read_message(1, 191, b"", index)
        by_name = dialect.MAVLink_param_request_read_message(1, 191, value.param_id.encode(), -1)
        for (again,) in (listed(radio.say(by_index)), listed(radio.say(by_name))):
            assert (again.param_id, again.param_value) == (value.param_id, value.param_value)


def test_a_list_of_somebody_else_is_not_ours(radio: Radio) -> None:
    assert listed(radio.say(dialect.MAVLink_param_request_list_message(1, 1))) == []
    assert listed(radio.say(dialect.MAVLink_param_request_list_message(2, 191))) == []


def test_an_unknown_name_is_an_error_only_if_we_were_asked(radio: Radio) -> None:
    def ask(component: int, name: bytes, index: int = -1) -> list[Any]:
        return radio.say(dialect.MAVLink_param_request_read_message(1, component, name, index))

    (error,) = of_type(ask(191, b"_HASH_CHECK"), "PARAM_ERROR")
    assert error.error == dialect.MAV_PARAM_ERROR_DOES_NOT_EXIST
    assert (error.target_system, error.target_component) == STATION
    assert of_type(ask(191, b"", 99), "PARAM_ERROR") != []
    assert of_type(ask(0, b"MPC_XY_VEL_MAX"), "PARAM_ERROR") == []


def put(radio: Radio, name: str, value: float, kind: int) -> list[Any]:
    """PARAM_SET; what left but heartbeats."""
    carried = encode(value, kind) if math.isfinite(value) else value
    request = dialect.MAVLink_param_set_message(1, 191, name.encode(), carried, kind)
    return [m for m in radio.say(request) if m.get_type() != "HEARTBEAT"]


@pytest.mark.parametrize(
    ("name", "value", "kind"),
    [
        ("CMP_SPEED_MAX", 1.5, REAL32),
        ("CMP_BELIEF_RETRY", 30.0, REAL32),
        ("CMP_TEXT_LEVEL", 4, INT32),
    ],
)
def test_a_value_that_is_set_is_told_and_kept(
    radio: Radio, name: str, value: float, kind: int
) -> None:
    (answer,) = put(radio, name, value, kind)
    assert decode(answer.param_value, answer.param_type) == value
    assert radio.component.parameters[name] == value


@pytest.mark.parametrize(
    ("name", "value", "kind", "error"),
    [
        ("CMP_SPEED_MAX", 0.0, REAL32, "VALUE_OUT_OF_RANGE"),
        ("CMP_SPEED_MAX", math.nan, REAL32, "VALUE_OUT_OF_RANGE"),
        ("CMP_SPEED_MAX", 3, INT32, "VALUE_OUT_OF_RANGE"),
        ("CMP_TEXT_LEVEL", 8, INT32, "VALUE_OUT_OF_RANGE"),
        ("CMP_TICK_HZ", 50, INT32, "READ_ONLY"),
    ],
)
def test_a_value_that_cannot_be_is_refused_with_the_present_one(
    radio: Radio, name: str, value: float, kind: int, error: str
) -> None:
    before = radio.component.parameters[name]
    answer, refusal = put(radio, name, value, kind)
    assert decode(answer.param_value, answer.param_type) == before
    assert refusal.error == getattr(dialect, f"MAV_PARAM_ERROR_{error}")
    assert radio.component.parameters[name] == before


def test_the_level_of_texts_is_followed(radio: Radio) -> None:
    put(radio, "CMP_TEXT_LEVEL", 4, INT32)
    failed = SkillFailed("upload", "denied")
    radio.component.tell(radio.now_s, PlaceReached("A", "move"))
    radio.component.tell(radio.now_s, failed)
    assert [m.text for m in of_type(radio.run(1.0), "STATUSTEXT")] == [failed.text]


@pytest.mark.parametrize("ending", [TaskSatisfied(), RunFailed("landed", exit_code=5)])
def test_the_end_is_told_to_programs_after_all_texts(radio: Radio, ending: RunEnded) -> None:
    radio.run(0.3)
    radio.component.tell(radio.now_s, PlaceReached("a place " * 15, "move"))
    radio.component.tell(radio.now_s, ending)
    last = radio.component.transmit(radio.now_s, is_last=True)
    kinds = [m.get_type() for m in last]
    assert kinds == ["STATUSTEXT"] * 4 + ["NAMED_VALUE_INT"]
    assert (last[-1].name, last[-1].value) == ("exit_code", ending.exit_code)


# -- the rest --------------------------------------------------------------------------------------


def test_a_ping_to_all_is_answered(radio: Radio) -> None:
    (pong,) = of_type(radio.say(dialect.MAVLink_ping_message(7, 3, 0, 0)), "PING")
    assert (pong.time_usec, pong.seq) == (7, 3)
    assert (pong.target_system, pong.target_component) == STATION
    assert of_type(radio.say(dialect.MAVLink_ping_message(7, 3, 1, 191)), "PING") == []


def test_files_are_refused_at_once_where_nobody_takes_them(radio: Radio) -> None:
    request = dialect.MAVLink_file_transfer_protocol_message(0, 1, 191, [5, 0, 0, 4] + [0] * 247)
    (answer,) = of_type(radio.say(request), "FILE_TRANSFER_PROTOCOL")
    assert answer.payload[3] == 129  # NAK


@drawn(100)
@given(
    st.lists(
        st.tuples(st.sampled_from(sorted(WANTED)), st.binary(min_size=1, max_size=255)), max_size=8
    )
)
def test_no_payload_raises(payloads: list[tuple[str, bytes]]) -> None:
    """Any bytes in a well-formed frame that is addressed to us, or to all."""
    kinds = {k.msgname: k for k in dialect.mavlink_map.values()}
    radio = Radio()
    datagrams = []
    for name, payload in payloads:
        kind = kinds[name]
        sender = dialect.MAVLink(None, *STATION)
        message = dialect.MAVLink_message(kind.id, kind.msgname)
        datagrams.append(
            bytes(message._pack(sender, kind.crc_extra, payload[: kind.unpacker.size]))
        )
    radio.raw(*datagrams)
    assert all(math.isfinite(radio.component.parameters[name]) for name in NAMES)
