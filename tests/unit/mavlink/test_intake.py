"""A flood takes no more than its share, and nobody else's."""

from __future__ import annotations

import random

import pytest

from companion.mavlink.framing import MavlinkCodec, dialect, split_frames
from companion.mavlink.intake import (
    LONGEST,
    PEER_FRAMES,
    READS,
    SENDER_FRAMES,
    STRANGERS_FRAMES,
    Address,
    Intake,
)

PEER, OTHER = ("127.0.0.1", 14580), ("127.0.0.1", 40000)
HEARTBEAT = MavlinkCodec(1, 1).pack(dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3))
EMPTY = b"\xfe\x00\x00\x01\x01\x00\x00\x00"  # the shortest frame, of MAVLink 1
FLOODS = {
    "heartbeats": HEARTBEAT,
    "many frames each": EMPTY * (LONGEST // len(EMPTY)),
    "no frames": bytes(LONGEST),
    "marks of frames": b"\xfd" * LONGEST,
    "nothing": b"",
    "too long": EMPTY * 8188,
}


def taken(intake: Intake, sender: Address, datagram: bytes, number: int = 5_000) -> list[bytes]:
    return [datagram for _ in range(number) if intake.takes(sender, datagram, PEER)]


def frames(datagrams: list[bytes]) -> int:
    return sum(len(split_frames(datagram)) for datagram in datagrams)


@pytest.mark.parametrize("flood", FLOODS.values(), ids=FLOODS)
@pytest.mark.parametrize(
    ("sender", "share"), [(PEER, PEER_FRAMES), (OTHER, SENDER_FRAMES)], ids=["peer", "other"]
)
def test_frames_and_bytes_of_a_step_are_bounded(flood: bytes, sender: Address, share: int) -> None:
    intake = Intake()
    for _ in range(3):
        intake.begin_step()
        found = taken(intake, sender, flood)
        assert len(found) <= share
        assert frames(found) <= share + LONGEST // len(EMPTY)
        assert sum(map(len, found)) <= 64 * share + LONGEST


@pytest.mark.parametrize(
    ("sender", "share"), [(PEER, PEER_FRAMES), (OTHER, SENDER_FRAMES)], ids=["peer", "other"]
)
def test_a_share_is_counted_in_frames(sender: Address, share: int) -> None:
    intake = Intake()
    for _ in range(2):
        assert len(taken(intake, sender, HEARTBEAT)) == share
        intake.begin_step()


def test_the_shares_are_those_of_the_traffic_and_of_a_step() -> None:
    """A PX4 sends a companion 233 messages a second; a step of 50 ms decodes 1,100 at 22,200/s."""
    longest_frames = 7 * 280
    packet = 1_500
    assert max(longest_frames, packet) < LONGEST <= 2 * packet
    assert 2 * 233 <= PEER_FRAMES <= 3 * 233
    assert 2 * SENDER_FRAMES <= STRANGERS_FRAMES
    assert PEER_FRAMES + STRANGERS_FRAMES < 1_100
    read_s = 2e-6
    assert PEER_FRAMES + STRANGERS_FRAMES < READS < 0.005 / read_s


@pytest.mark.parametrize("flood", FLOODS.values(), ids=FLOODS)
def test_no_flood_takes_the_place_of_the_peer(flood: bytes) -> None:
    intake = Intake()
    for port in range(2_000):
        taken(intake, ("127.0.0.1", port), flood, number=3)
    assert taken(intake, PEER, HEARTBEAT, 300) == [HEARTBEAT] * 300


def test_strangers_share_so_that_ports_are_no_use_to_a_flood() -> None:
    intake, chance = Intake(), random.Random(3)
    senders = [("127.0.0.1", chance.randrange(1, 65536)) for _ in range(10_000)]
    assert sum(intake.takes(sender, HEARTBEAT, PEER) for sender in senders) == STRANGERS_FRAMES


def test_a_quiet_sender_is_heard_beside_a_loud_one() -> None:
    intake = Intake()
    taken(intake, OTHER, HEARTBEAT)
    assert taken(intake, ("127.0.0.1", 14550), HEARTBEAT, 20) == [HEARTBEAT] * 20


def test_what_is_too_long_costs_its_sender_nothing_more() -> None:
    intake = Intake()
    assert intake.takes(OTHER, bytes(LONGEST + 1), PEER) is False
    assert intake.takes(OTHER, bytes(LONGEST), PEER) is True
    assert intake.dropped == 1


def test_what_is_dropped_is_told_when_it_has_doubled() -> None:
    intake, told = Intake(), []
    assert intake.news() == 0
    for _ in range(1_000):
        intake.takes(OTHER, bytes(LONGEST + 1), PEER)
        told.append(intake.news())
    assert [number for number in told if number] == [2**n for n in range(10)]
