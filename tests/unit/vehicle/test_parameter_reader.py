"""Single parameters of the autopilot: asked for until they are answered."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.parameters import INT32, REAL32, encode
from companion.vehicle.parameters import ASK_AGAIN_S, ParameterReader

AUTOPILOT = (1, 1)


def answer(name: str, value: float, kind: int) -> Any:
    """A PARAM_VALUE after its way over the wire."""
    message = dialect.MAVLink_param_value_message(name.encode(), encode(value, kind), kind, 1, 0)
    return MavlinkCodec(0, 0).parse(MavlinkCodec(*AUTOPILOT).pack(message))[0]


def test_it_asks_by_name_until_it_is_answered() -> None:
    reader = ParameterReader()
    assert reader.read("COM_OF_LOSS_T") is None
    (question,) = reader.due(0.0, AUTOPILOT)
    assert (question.target_system, question.target_component) == AUTOPILOT
    assert (question.param_id, question.param_index) == ("COM_OF_LOSS_T", -1)
    assert reader.due(ASK_AGAIN_S - 0.01, AUTOPILOT) == []
    assert len(reader.due(ASK_AGAIN_S, AUTOPILOT)) == 1
    reader.take(answer("COM_OF_LOSS_T", 0.5, REAL32))
    assert reader.read("COM_OF_LOSS_T") == 0.5
    assert reader.due(10.0, AUTOPILOT) == []


def test_asking_again_does_not_hurry() -> None:
    reader = ParameterReader()
    for now_s in (0.0, 0.1, 0.2):
        reader.read("COM_OF_LOSS_T")
        assert len(reader.due(now_s, AUTOPILOT)) == (now_s == 0.0)


@pytest.mark.parametrize("value", [0, 5, -1])
def test_whole_numbers_travel_as_px4_sends_them(value: int) -> None:
    reader = ParameterReader()
    reader.read("COM_OBL_RC_ACT")
    reader.take(answer("COM_OBL_RC_ACT", value, INT32))
    assert reader.read("COM_OBL_RC_ACT") == value


def test_what_was_not_asked_for_is_not_kept() -> None:
    reader = ParameterReader()
    reader.take(answer("COM_OF_LOSS_T", 0.5, REAL32))
    assert reader.read("COM_OF_LOSS_T") is None


def test_a_type_that_px4_does_not_use_is_no_answer() -> None:
    reader = ParameterReader()
    reader.read("COM_OF_LOSS_T")
    message = dialect.MAVLink_param_value_message(b"COM_OF_LOSS_T", math.nan, 10, 1, 0)
    reader.take(MavlinkCodec(0, 0).parse(MavlinkCodec(*AUTOPILOT).pack(message))[0])
    assert reader.read("COM_OF_LOSS_T") is None
