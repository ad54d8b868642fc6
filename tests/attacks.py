"""Frames as an attacker makes them, by a seeded generator.

Bad checksums, forged senders, flags, signatures of another key, MAVLink 1, pieces of frames, random
bytes, and datagrams of up to 60 KiB.
"""

from __future__ import annotations

import random
from collections.abc import Callable

from garbage import any_frame, random_bytes, truncated_frame

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.signing import Signing, SigningKey

KEY, OTHER_KEY = SigningKey(bytes(range(32))), SigningKey(bytes(32))
"""Of the vehicle and its companion, and the attacker's."""
NOW_S = 1.8e9
PER_TICK = 25
LONGEST = 60 * 1024
"""UDP carries hardly more."""


def bad_checksum(rng: random.Random) -> bytes:
    """Of the vehicle's messages, one bit changed behind the header."""
    sender = MavlinkCodec(1, 1)
    frame = bytearray(sender.pack(telling(rng)))
    frame[rng.randrange(10, len(frame))] ^= 1 << rng.randrange(8)
    return bytes(frame)


def telling(rng: random.Random) -> object:
    """A message that would take control, or start something."""
    return rng.choice(
        [
            dialect.MAVLink_heartbeat_message(2, 12, 1, rng.getrandbits(32), 4, 3),
            dialect.MAVLink_command_long_message(1, 191, 300, 0, *(0.0,) * 7),
            dialect.MAVLink_local_position_ned_message(0, *(rng.uniform(-9, 9) for _ in "123456")),
            dialect.MAVLink_param_set_message(1, 191, b"CMP_SPEED_MAX", 1.0, 9),
        ]
    )


def flagged(rng: random.Random) -> bytes:
    """Incompatible flags, with and without the bytes of a signature."""
    frame = bytearray(any_frame(rng))
    frame[2] = rng.randrange(1, 256)
    return bytes(frame) + rng.randbytes(rng.choice([0, 13]))


def other_key(rng: random.Random) -> bytes:
    signing = Signing(OTHER_KEY, NOW_S + rng.uniform(-1e6, 1e6))
    sender = MavlinkCodec(1, rng.choice([1, 25, 190, 191]))
    return signing.send(0.0, [sender.pack(telling(rng))], rng.randrange(256))[0]


def mavlink_1(rng: random.Random) -> bytes:
    size = rng.randrange(64)
    return bytes([0xFE, size, 0, rng.randrange(4), rng.randrange(256), 0]) + rng.randbytes(size + 2)


def jumbo(rng: random.Random) -> bytes:
    """More than is taken in: 2 to 60 KiB of frames."""
    return (any_frame(rng) * rng.randrange(60, 240))[:LONGEST]


KINDS: list[Callable[[random.Random], bytes]] = [
    *(bad_checksum, flagged, other_key, mavlink_1, any_frame, random_bytes, truncated_frame)
]


def attacks(rng: random.Random) -> list[bytes]:
    """A few datagrams, now and then a long one among them."""
    found = [rng.choice(KINDS)(rng) for _ in range(PER_TICK)]
    return [*found, jumbo(rng)] if rng.random() < 0.05 else found


def means_nothing(datagram: bytes, system: int = 1) -> bool:
    """Whether it is damaged, or from a component that the companion of a system does not hear."""
    return not any(
        m.get_srcSystem() == system or getattr(m, "target_component", 0) in (0, 191)
        for m in MavlinkCodec(0, 0).parse(datagram)
    )
