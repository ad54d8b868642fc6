"""The autopilot's side of the parameter protocol, as in PX4.

1. Integers are sent byte by byte.
2. A request for an unknown name is not answered.
3. A value of another type changes nothing; the answer is the present value.
4. A list is spread over time, so that no buffer overflows.
5. `_HASH_CHECK` is a checksum of all names and values, which saves QGroundControl the list.

Sources: https://mavlink.io/en/services/parameter.html; PX4, mavlink_parameters.cpp and
param_hash_check; observed answers of PX4.
"""

from __future__ import annotations

import struct
import zlib

from companion.mavlink.framing import Message
from companion.mavlink.parameters import INT32, asked_for, decode, value_message
from sitl.autopilot.parameters import PARAMETERS, Parameters, index_of

HASH_CHECK = "_HASH_CHECK"
HASH_INDEX = 65535
UINT32 = 5  # MAV_PARAM_TYPE_UINT32
NAMES = tuple(PARAMETERS)
LISTED = (HASH_CHECK, *PARAMETERS)
"""The answer to PARAM_REQUEST_LIST: the checksum first, then all in order."""
VOLATILE = frozenset({"COM_FLIGHT_UUID", "LND_FLIGHT_T_HI", "LND_FLIGHT_T_LO"})
"""Counters that change by themselves; the checksum leaves them out."""


def checksum(parameters: Parameters) -> int:
    """CRC-32 without inversions over each name and its value's four bytes, in order."""
    inverted = 0xFFFFFFFF
    for name, (param_type, _) in PARAMETERS.items():
        if name not in VOLATILE:
            value = parameters[name]
            raw = struct.pack("<i", int(value)) if param_type == INT32 else struct.pack("<f", value)
            inverted = zlib.crc32(name.encode() + raw, inverted)
    return inverted ^ 0xFFFFFFFF


def value_of(name: str, parameters: Parameters) -> Message:
    """PARAM_VALUE of a known parameter, or of the checksum."""
    if name == HASH_CHECK:
        value, param_type, index = float(checksum(parameters)), UINT32, HASH_INDEX
    else:
        value, param_type, index = parameters[name], PARAMETERS[name][0], index_of(name)
    return value_message(name, value, param_type, len(PARAMETERS), index)


def read(request: Message, parameters: Parameters) -> Message | None:
    """The answer to PARAM_REQUEST_READ; None for a parameter that does not exist."""
    is_checksum = request.param_index < 0 and request.param_id == HASH_CHECK
    name = HASH_CHECK if is_checksum else asked_for(request, NAMES)
    return value_of(name, parameters) if name is not None else None


def write(request: Message, parameters: Parameters) -> Message | None:
    """Executes PARAM_SET; the answer is the value that applies now."""
    name = request.param_id
    if name not in PARAMETERS:
        return None
    if request.param_type == PARAMETERS[name][0]:
        parameters.set(name, decode(request.param_value, request.param_type))
    return value_of(name, parameters)
