"""Messages on request and parameters of component 191, as a ground station sees them."""

from __future__ import annotations

import math
from typing import Any

import pytest
from autopilot import of_type
from ground_radio import STATION, Radio

from companion.flight_events.skills import PlaceReached, SkillFailed
from companion.flight_events.sortie import RunEnded, RunFailed, TaskSatisfied
from companion.ground.parameters import NAMES
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.parameters import INT32, REAL32, decode, encode

REQUEST, INTERVAL = dialect.MAV_CMD_REQUEST_MESSAGE, dialect.MAV_CMD_SET_MESSAGE_INTERVAL
DENIED, UNSUPPORTED = dialect.MAV_RESULT_DENIED, dialect.MAV_RESULT_UNSUPPORTED


@pytest.fixture
def radio() -> Radio:
    return Radio()


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
