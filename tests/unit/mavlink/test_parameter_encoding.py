"""PX4's byte-wise integers in a float field."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.parameters import INT32, REAL32, decode, encode

SIGNALLING = 0x7F800000, 0x7FC00000  # between them, sign aside, a float32 is a signalling NaN


def is_signalling_nan(value: int) -> bool:
    return SIGNALLING[0] < value & 0x7FFFFFFF < SIGNALLING[1]


@given(st.integers(-(2**31), 2**31 - 1).filter(lambda v: not is_signalling_nan(v & 0xFFFFFFFF)))
def test_integers_come_back_through_a_frame(value: int) -> None:
    message = dialect.MAVLink_param_value_message(b"A", encode(value, INT32), INT32, 1, 0)
    frame = MavlinkCodec(1, 1).pack(message)
    assert struct.pack("<i", value).rstrip(b"\0") in frame  # the bytes themselves travel
    (received,) = MavlinkCodec(0, 0).parse(frame)
    assert decode(received.param_value, received.param_type) == value


@given(st.floats(width=32, allow_nan=False))
def test_floats_come_back(value: float) -> None:
    assert decode(encode(value, REAL32), REAL32) == value


def test_what_a_real_px4_sent() -> None:
    assert decode(1.4069036581821163e-41, INT32) == 10040  # SYS_AUTOSTART
    assert encode(5, INT32) == 7.006492321624085e-45  # COM_OBL_RC_ACT set to 5
    assert (
        decode(-501987388948480.0, 5)
        == struct.unpack("<I", struct.pack("<f", -501987388948480.0))[0]
    )


@pytest.mark.parametrize(
    ("value", "param_type"), [(2**31, INT32), (1e39, REAL32), (1.5, INT32), (1, 10), (1, 0)]
)
def test_what_does_not_fit_is_refused(value: float, param_type: int) -> None:
    with pytest.raises(ValueError):
        encode(value, param_type)
