"""MAVLink 2 frames: converts messages to bytes and back, for one component on one link.

1. Each datagram is parsed on its own, so a damaged one never swallows frames of the next one.
2. Damaged frames, unknown messages, and frames with an unknown incompatibility flag are dropped and
   not counted; they never raise.

Source: https://mavlink.io/en/guide/serialization.html. Signatures are skipped here; `signing.py`
checks them before.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Container, Sequence
from functools import cache
from itertools import accumulate, chain
from operator import attrgetter, itemgetter
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import common

from companion.mavlink import added_messages

__all__ = [
    "Fields",
    "MavlinkCodec",
    "Message",
    "checksum",
    "choose",
    "decode",
    "dialect",
    "frame_size",
    "is_intact",
    "message_id",
    "message_of",
    "source",
    "split_frames",
]

dialect = added_messages.extended(common)
"""MAVLink's `common`, as pymavlink has it, with the messages that it lacks."""

_SIZES = [bytes([size]) for size in range(256)]
_HEADER = "<2x3BHB"
"""Behind the size: flags, sequence number, sender, and the message id in two parts."""
_HEADER_SIZE = struct.calcsize(_HEADER)
_LEAST_SIZE = _HEADER_SIZE + 1
"""With the first byte of the payload; only zeros behind it are cut off at the end of a frame."""
_CHECKSUM = struct.Struct("<H")
_MAGIC_1, _MAGIC_2 = 0xFE, 0xFD
_SHORTEST = 8
"""Bytes of a MAVLink 1 frame without payload."""
_UNKNOWN_FLAGS = 0xFF & ~dialect.MAVLINK_IFLAG_SIGNED
checksum = dialect.mcrf4xx
"""CRC-16/MCRF4XX of bytes, from an initial value."""

Message = Any
"""A pymavlink message; it never leaves the packages that speak MAVLink."""
Fields = tuple[Any, ...]
"""A message's fields in the order of its definition; extensions at the end may be left out."""


class MavlinkCodec:
    """Packs and parses the frames of one component on one link; keeps its sequence numbers.

    >>> codec = MavlinkCodec(1, 191)
    >>> (message,) = codec.parse(codec.pack(dialect.MAVLink_ping_message(0, 7, 0, 0)))
    >>> message.seq, source(message)
    (7, (1, 191))

    Args:
        system: own system id.
        component: own component id.

    Attributes:
        sequence: number of the next frame, 0 to 255.
    """

    def __init__(self, system: int, component: int) -> None:
        self.system = system
        self.component = component
        self.sequence = 0

    def pack(self, message: Message) -> bytes:
        """Returns the frame of a message from this component, with the next sequence number."""
        kind: Any = type(message)
        return self.frame(kind, _layout(kind).fields(message))

    def frame(self, kind: Any, fields: Fields) -> bytes:
        """Like `pack`, but from a message's class and fields; twice as fast, for frequent
        messages."""
        layout = _layout(kind)
        if missing := layout.length - len(fields):
            fields += layout.extensions[-missing:]
        whole = layout.pack(
            self.sequence, self.system, self.component, *layout.number, *layout.values(fields)
        )
        self.sequence = (self.sequence + 1) % 256
        body = whole.rstrip(b"\0")
        if len(body) < _LEAST_SIZE:
            body = whole[:_LEAST_SIZE]
        body = _SIZES[len(body) - _HEADER_SIZE] + body
        crc = checksum(layout.crc_extra, checksum(body, 0xFFFF))
        return b"\xfd" + body + _CHECKSUM.pack(crc)

    def parse(self, datagram: bytes) -> list[Message]:
        """Returns the intact, known messages of a datagram, in order; never raises."""
        messages = map(decode, split_frames(datagram))
        return [message for message in messages if message is not None]


class _Layout(NamedTuple):
    """The layout of a message on the wire; packs and unpacks in a third of pymavlink's time.

    Attributes:
        length: number of fields.
        fields: extracts the fields of a message, strings as bytes.
        extensions: defaults of the last fields, for those that are not given.
        values: converts fields to the order of the wire, with arrays unrolled.
        pack: packs what follows the size, from the header's values and those of the message.
        number: the message id: its lower 16 bits, and the rest.
        size: bytes of a payload, including zeros at its end.
        unpack: converts a payload of that size to values.
        fields_of: converts these values to fields, with arrays as lists.
    """

    length: int
    fields: Callable[[Message], Fields]
    extensions: Fields
    values: Callable[[Fields], Sequence[Any]]
    pack: Callable[..., bytes]
    number: tuple[int, int]
    crc_extra: bytes
    size: int
    unpack: Callable[[bytes], tuple[Any, ...]]
    fields_of: Callable[[tuple[Any, ...]], Sequence[Any]]


@cache
def _layout(kind: Any) -> _Layout:
    count, whole = len(kind.fieldnames), _HEADER + kind.unpacker.format.lstrip("<")
    names = list(map(_attribute, kind.fieldnames, kind.fieldtypes))
    return _Layout(
        count,
        attrgetter(*names) if count > 1 else lambda message: (getattr(message, names[0]),),
        getattr(kind.__init__, "__defaults__", None) or (),
        _values(kind),
        struct.Struct(whole).pack,
        (kind.id & 0xFFFF, kind.id >> 16),
        bytes([kind.crc_extra]),
        kind.unpacker.size,
        kind.unpacker.unpack,
        _fields_of(kind),
    )


def _attribute(name: str, type_: str) -> str:
    """The attribute in which a message has a field, strings as bytes."""
    return f"_{name}_raw" if type_ == "char" else name


def _values(kind: Any) -> Callable[[Fields], Sequence[Any]]:
    order = [kind.fieldnames.index(name) for name in kind.ordered_fieldnames]
    in_order = tuple if order == sorted(order) else itemgetter(*order)
    arrays = [i for i, length in enumerate(kind.lengths) if length > 1]
    if not arrays:
        return in_order

    def laid_out(fields: Fields) -> list[Any]:
        values = list(in_order(fields))
        for i in reversed(arrays):
            values[i : i + 1] = values[i]
        return values

    return laid_out


def _fields_of(kind: Any) -> Callable[[tuple[Any, ...]], Sequence[Any]]:
    order = [kind.ordered_fieldnames.index(name) for name in kind.fieldnames]
    if sum(kind.lengths) == len(kind.lengths) and "char" not in kind.fieldtypes:
        return itemgetter(*order) if len(order) > 1 else tuple
    ends = list(accumulate(kind.lengths))
    places = [(ends[i] - kind.lengths[i], kind.lengths[i]) for i in order]

    def fields_of(values: tuple[Any, ...]) -> list[Any]:
        fields = [
            values[at] if length == 1 else list(values[at : at + length]) for at, length in places
        ]
        return [each.rstrip(b"\0") if isinstance(each, bytes) else each for each in fields]

    return fields_of


def decode(frame: bytes) -> Message | None:
    """Returns the message of a frame; None if it is damaged or unknown."""
    return message_of(frame) if is_intact(frame) else None


def message_of(frame: bytes) -> Message:
    """Returns the message of an intact frame."""
    kind: Any = dialect.mavlink_map[message_id(frame)]
    layout, length = _layout(kind), frame[1]
    if frame[0] == _MAGIC_2:
        begin, flags, sender = 10, frame[2:4], frame[4:7]
    else:
        begin, flags, sender = 6, b"\0\0", frame[2:5]
    payload = frame[begin : begin + length]
    values = layout.unpack(payload[: layout.size].ljust(layout.size, b"\0"))
    message = kind(*layout.fields_of(values))
    header = message._header
    header.incompat_flags, header.compat_flags = flags
    header.mlen, (header.seq, header.srcSystem, header.srcComponent) = length, sender
    message._msgbuf = frame
    (message._crc,) = _CHECKSUM.unpack_from(frame, begin + length)
    return message


def message_id(frame: bytes) -> int:
    """Returns the id of the message in a frame."""
    if frame[0] == _MAGIC_2:
        return int.from_bytes(frame[7:10], "little")
    return frame[5]


def is_intact(frame: bytes) -> bool:
    """Whether the checksum of a frame is right; False for unknown messages, which cannot be
    checked.
    """
    kind = dialect.mavlink_map.get(message_id(frame))
    if kind is None:
        return False
    end = frame[1] + (10 if frame[0] == _MAGIC_2 else 6)  # of the payload
    expected = checksum(_layout(kind).crc_extra, checksum(frame[1:end], 0xFFFF))
    return bool(expected == frame[end] | frame[end + 1] << 8)


def source(message: Message) -> tuple[int, int]:
    """Returns the system and component id that sent a message."""
    return (message.get_srcSystem(), message.get_srcComponent())


def split_frames(datagram: bytes) -> list[bytes]:
    """Returns the frames of a datagram, by their headers; other bytes are skipped.

    A frame with an unknown incompatibility flag is skipped as a whole, so that nothing inside it is
    taken for a frame.
    """
    at, size = 0, len(datagram)
    if size >= 12 and datagram[0] == _MAGIC_2 and datagram[1] + 12 == size and not datagram[2]:
        return [datagram]  # one frame without a signature, as nearly always
    frames: list[bytes] = []
    while at + _SHORTEST <= size:
        length = frame_size(datagram, at)
        if length is None:
            at += 1
            continue
        is_understood = datagram[at] == _MAGIC_1 or not datagram[at + 2] & _UNKNOWN_FLAGS
        if is_understood and at + length <= size:
            frames.append(datagram[at : at + length])
        at += length
    return frames


def frame_size(data: bytes, at: int) -> int | None:
    """Returns the size of a frame from its first three bytes; None if no frame begins there."""
    if data[at] == _MAGIC_2:
        is_signed = data[at + 2] & dialect.MAVLINK_IFLAG_SIGNED
        return 12 + data[at + 1] + (dialect.MAVLINK_SIGNATURE_BLOCK_LEN if is_signed else 0)
    return 8 + data[at + 1] if data[at] == _MAGIC_1 else None


def choose(
    datagrams: list[bytes], wanted: Container[int], continual: Container[int]
) -> list[bytes]:
    """Returns, in order, the intact frames that are worth decoding; decoding is the slowest step.

    Args:
        datagrams: of one link, as they arrived together.
        wanted: ids of the messages that somebody reads.
        continual: ids of messages of which only the newest counts, such as positions that come more
            often than they are used; MAVLink 1 frames are all kept.
    """
    chosen: list[bytes] = []
    newest: dict[bytes, int] = {}
    for frame in chain.from_iterable(map(split_frames, datagrams)):
        number = message_id(frame)
        if number not in wanted or not is_intact(frame):
            continue  # it must not replace an intact one
        if number in continual and frame[0] == _MAGIC_2:
            sender_and_message = frame[5:10]
            other = newest.get(sender_and_message)
            if other is not None:
                if (frame[4] - chosen[other][4]) % 256 >= 128:  # sequence numbers
                    continue
                chosen[other] = b""
            newest[sender_and_message] = len(chosen)
        chosen.append(frame)
    return [frame for frame in chosen if frame]
