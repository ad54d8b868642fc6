"""Frames as an attacker makes them, through the real parser: nothing is raised, nothing changes.

Bad checksums, forged senders, flags, signatures of another key, MAVLink 1, pieces of frames, and
datagrams of up to 64 KiB, by a seeded generator; taken in, verified, chosen and decoded as on the
companion's link. A few thousand by default, 2,000,000 with the markers `faults` and `long`.
"""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest
from autopilot import Autopilot
from garbage import any_frame, random_bytes, truncated_frame
from notes import Notes
from synthetic import mission

from companion.app import Companion
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.mavlink.framing import MavlinkCodec, dialect, split_frames
from companion.mavlink.intake import Intake
from companion.mavlink.signing import Signing, SigningKey, of_signed_vehicle

KEY, OTHER_KEY = SigningKey(bytes(range(32))), SigningKey(bytes(32))
NOW_S, TICK_S = 1.8e9, 0.05
PER_TICK = 25
ATTACKER, AUTOPILOT = ("127.0.0.1", 40000), ("127.0.0.1", 14580)
FRAMES = [
    4_000,
    pytest.param(1_000_000, marks=[pytest.mark.faults, pytest.mark.long]),
]
"""Of each of the two: with and without signing."""


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
    """More than is taken in: 2 to 64 KiB of frames."""
    return any_frame(rng) * rng.randrange(60, 240)


KINDS: list[Callable[[random.Random], bytes]] = [
    *(bad_checksum, flagged, other_key, mavlink_1, any_frame, random_bytes, truncated_frame)
]


def attacks(rng: random.Random) -> list[bytes]:
    found = [rng.choice(KINDS)(rng) for _ in range(PER_TICK)]
    return [*found, jumbo(rng)] if rng.random() < 0.05 else found


def means_nothing(datagram: bytes) -> bool:
    """Whether it is damaged, or from a component that the companion does not listen to."""
    return not any(
        m.get_srcSystem() == 1 or getattr(m, "target_component", 0) in (0, 191)
        for m in MavlinkCodec(0, 0).parse(datagram)
    )


class Aboard:
    """A companion with an autopilot that is heard in each tick, and what a fuzzer sends besides."""

    def __init__(self, signing: Signing | None) -> None:
        self.notes, self.beats = Notes(), 0
        self._companion = Companion(mission("G F at(A) & G F at(B)"), self.notes)
        self._autopilot, self._intake = Autopilot(), Intake()
        self._answers: list[bytes] = []
        self._signing, self._vehicle = signing, Signing(KEY, NOW_S) if signing else None

    def tick(self, now_s: float, datagrams: list[bytes]) -> None:
        own = [*self._answers, *self._autopilot.telemetry()]
        if self._vehicle is not None:
            own = self._vehicle.send(now_s, own)
        self._intake.begin_step()
        taken = [d for d in datagrams if self._intake.takes(ATTACKER, d, AUTOPILOT)]
        arrived = [*taken, *own]
        if self._signing is not None:
            arrived = self._signing.receive(now_s, arrived)
            assert [f for f in arrived if f in own] == own, "the autopilot is always heard"
        sent = self._companion.step(now_s, arrived)
        self.beats += sum(f[7:10] == b"\0\0\0" for d in sent for f in split_frames(d))
        self._answers = self._autopilot.answer(sent)


@pytest.mark.parametrize("is_signed", [True, False], ids=["signed", "unsigned"])
@pytest.mark.parametrize("number", FRAMES, ids=["few", "million"])
def test_a_companion_is_as_if_nobody_had_sent_anything(number: int, is_signed: bool) -> None:
    """With a key whatever was sent; without one, whatever is damaged or from somebody else."""
    rng = random.Random(11)
    signing = Signing(KEY, NOW_S, of_signed_vehicle) if is_signed else None
    disturbed = Aboard(signing)
    undisturbed = Aboard(Signing(KEY, NOW_S, of_signed_vehicle) if is_signed else None)
    sent = 0
    for tick in range(number // PER_TICK):
        said = attacks(rng)
        sent += len(said)
        if not is_signed:
            said = [datagram for datagram in said if means_nothing(datagram)]
        disturbed.tick(tick * TICK_S, said)
        undisturbed.tick(tick * TICK_S, [])
    assert sent >= number
    assert disturbed.notes.reports == undisturbed.notes.reports
    assert disturbed.beats == undisturbed.beats > 0
    assert PhaseEntered(Phase.TASK) in disturbed.notes.events
    if signing is not None:
        assert signing.refused.unsigned and signing.refused.forged and not signing.refused.old
