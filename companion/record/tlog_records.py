"""The records of a flight.tlog: eight bytes of time (microseconds since 1970) and a MAVLink frame.

Bytes in, records out, and the other way round; who opens files is elsewhere.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from companion.mavlink.framing import frame_size

_STAMP = struct.Struct(">Q")
_HEAD_BYTES = 3
"""Bytes at the start of a frame that determine its size."""


class TlogRecord(NamedTuple):
    """A frame, and when it went over the link.

    Attributes:
        stamp_us: microseconds since 1970.
    """

    stamp_us: int
    frame: bytes

    def __bytes__(self) -> bytes:
        """The record as it is in the file."""
        return _STAMP.pack(self.stamp_us) + self.frame

    @property
    def size(self) -> int:
        """The number of its bytes in the file."""
        return _STAMP.size + len(self.frame)


def whole_records(data: bytes) -> tuple[list[TlogRecord], bool]:
    """The complete records at the beginning of data, and whether no record begins behind them.

    >>> from companion.mavlink.framing import MavlinkCodec, dialect
    >>> ping = MavlinkCodec(1, 191).pack(dialect.MAVLink_ping_message(0, 7, 0, 0))
    >>> record = TlogRecord(5, ping)
    >>> whole_records(bytes(record) * 2 + bytes(record)[:-1]) == ([record] * 2, False)
    True
    >>> whole_records(bytes(record) + bytes(20)) == ([record], True)
    True
    """
    records: list[TlogRecord] = []
    at = 0
    while at + _STAMP.size + _HEAD_BYTES <= len(data):
        begin = at + _STAMP.size
        size = frame_size(data, begin)
        if size is None:
            return records, True
        if begin + size > len(data):
            break
        (stamp_us,) = _STAMP.unpack_from(data, at)
        records.append(TlogRecord(stamp_us, data[begin : begin + size]))
        at = begin + size
    return records, False
