"""Datagrams that nobody in his right mind sends, made from a generator's numbers."""

from __future__ import annotations

import random
import struct

from pymavlink.generator.mavcrc import x25crc

from companion.mavlink.framing import dialect

SIZES = {"char": 1, "float": 4, "double": 8} | {
    f"{sign}int{bits}_t": bits // 8 for sign in ("", "u") for bits in (8, 16, 32, 64)
}
KINDS = sorted(dialect.mavlink_map)


def frame(
    number: int, payload: bytes, rng: random.Random, sender: tuple[int, int] | None = None
) -> bytes:
    """A MAVLink 2 frame of some or any component, with a good checksum."""
    system, component = sender or (rng.randrange(256), rng.randrange(256))
    head = struct.pack(
        "<BBBBBBBHB", 0xFD, len(payload), 0, 0, rng.randrange(256), system, component,
        number & 0xFFFF, number >> 16,
    )  # fmt: skip
    crc = x25crc(head[1:] + payload)
    crc.accumulate(bytes([dialect.mavlink_map[number].crc_extra]))
    return head + payload + struct.pack("<H", crc.crc)


def payload_of(number: int, rng: random.Random) -> bytes:
    return rng.randbytes(dialect.mavlink_map[number].unpacker.size)


def with_fields(number: int, payload: bytes, fields: dict[str, bytes]) -> bytes:
    """A payload with other values in some fields, if the message has them."""
    kind, changed, at = dialect.mavlink_map[number], bytearray(payload), 0
    types = dict(zip(kind.fieldnames, kind.fieldtypes, strict=True))
    for name, length in zip(kind.ordered_fieldnames, kind.array_lengths, strict=True):
        size = SIZES[types[name]] * max(1, length)
        if name in fields:
            changed[at : at + size] = fields[name].ljust(size, b"\0")[:size]
        at += size
    assert at == len(payload)
    return bytes(changed)


def random_bytes(rng: random.Random) -> bytes:
    return rng.choice((b"", b"\xfd", b"\xfe")) + rng.randbytes(rng.randrange(300))


def truncated_frame(rng: random.Random) -> bytes:
    whole = any_frame(rng)
    return whole[: rng.randrange(len(whole))]


def any_frame(rng: random.Random) -> bytes:
    number = rng.choice(KINDS)
    return frame(number, payload_of(number, rng), rng)
