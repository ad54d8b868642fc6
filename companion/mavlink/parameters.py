"""PX4's byte-wise encoding of integer parameters in the float field of the parameter protocol.

PX4 copies the four bytes of an integer into PARAM_VALUE.param_value (capability
MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE); the type field says how to read them back.

Source: https://mavlink.io/en/services/parameter.html#parameter-encoding. Left out: the 64-bit
types, which do not fit into the field. Integers whose bytes form a signalling NaN (2139095041 to
2143289343 and -8388607 to -4194305) may be changed on the way, because processors turn such a float
into a quiet NaN. No PX4 parameter has such a value.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from companion.mavlink.framing import Message, dialect

INT32 = 6  # MAV_PARAM_TYPE_INT32
REAL32 = 9  # MAV_PARAM_TYPE_REAL32

_LAYOUTS = {1: "<Bxxx", 2: "<bxxx", 3: "<Hxx", 4: "<hxx", 5: "<I", INT32: "<i", REAL32: "<f"}
"""MAV_PARAM_TYPE -> layout of the four bytes."""


def encode(value: float, param_type: int) -> float:
    """Returns the float that carries a value on the wire.

    Args:
        value: within the range of the type; integral for the integer types.
        param_type: MAV_PARAM_TYPE, at most 32 bit.

    Raises:
        ValueError: the type does not fit into the field, or the value does not fit the type.

    >>> decode(encode(5, INT32), INT32)
    5
    """
    if param_type != REAL32 and value != int(value):
        raise ValueError(f"{value} is not a whole number")
    try:
        raw = struct.pack(_layout(param_type), float(value) if param_type == REAL32 else int(value))
    except (struct.error, OverflowError) as error:
        raise ValueError(f"{value} does not fit into parameter type {param_type}") from error
    return float(struct.unpack("<f", raw)[0])


def decode(param_value: float, param_type: int) -> float | int:
    """Returns the value that a float on the wire carries; the inverse of `encode`.

    Raises:
        ValueError: the type does not fit into the field.
    """
    value: float | int = struct.unpack(_layout(param_type), struct.pack("<f", param_value))[0]
    return value


def value_message(name: str, value: float, param_type: int, count: int, index: int) -> Message:
    """Returns the PARAM_VALUE of one of `count` parameters.

    Raises:
        ValueError: as `encode`.
    """
    return dialect.MAVLink_param_value_message(
        name.encode(), encode(value, param_type), param_type, count, index
    )


def asked_for(request: Message, names: Sequence[str]) -> str | None:
    """Returns the name that a PARAM_REQUEST_READ requests, by index or by name; None if unknown."""
    index = request.param_index
    if index >= 0:
        return names[index] if index < len(names) else None
    return request.param_id if request.param_id in names else None


def _layout(param_type: int) -> str:
    if param_type not in _LAYOUTS:
        raise ValueError(f"parameter type {param_type} does not travel in a float")
    return _LAYOUTS[param_type]
