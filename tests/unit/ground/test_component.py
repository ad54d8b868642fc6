"""Component 191 as ground stations see it: services of the wire, without a flight."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from autopilot import ACCEPTED, ARM, of_type
from drawn import drawn
from ground_radio import STATION, Radio, command
from hypothesis import given
from hypothesis import strategies as st

from companion.ground.component import WANTED, Component
from companion.ground.operations import SystemStatus
from companion.ground.parameters import NAMES
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.signals import Signal
from companion.outcomes import Refusal
from companion.tick import TICK_S

DOCS = Path(__file__).parents[3] / "docs"
START, PAUSE = dialect.MAV_CMD_MISSION_START, dialect.MAV_CMD_DO_PAUSE_CONTINUE
RETURN, USER_1 = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH, dialect.MAV_CMD_USER_1
ITEM = dialect.MAV_CMD_DO_SET_MISSION_CURRENT
REQUEST, INTERVAL = dialect.MAV_CMD_REQUEST_MESSAGE, dialect.MAV_CMD_SET_MESSAGE_INTERVAL
NOT_NOW = dialect.MAV_RESULT_TEMPORARILY_REJECTED
DENIED, UNSUPPORTED = dialect.MAV_RESULT_DENIED, dialect.MAV_RESULT_UNSUPPORTED


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
