"""Signatures are pymavlink's, byte for byte; what an attacker can send changes nothing.

An attacker hears all frames, forges any header, and sends at any time and on any link. It does not
have the key.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from random import Random
from typing import Any

import pytest
from garbage import frame, payload_of
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from companion.errors import CompanionError
from companion.mavlink.framing import MavlinkCodec, dialect, split_frames
from companion.mavlink.signing import (
    BEHIND,
    EPOCH_UNIX_S,
    HARMLESS,
    KEPT_EVERY,
    KEPT_EVERY_S,
    LATEST,
    REQUESTS,
    STREAMS,
    UNITS_PER_S,
    MayBeUnsigned,
    Refused,
    Signing,
    SigningKey,
    Stamps,
    harmless,
    of_signed_vehicle,
    of_unsigned_vehicle,
)

KEY, OTHER_KEY = SigningKey(bytes(range(32))), SigningKey(bytes(32))
NOW_S = 1.8e9
NOW = int((NOW_S - EPOCH_UNIX_S) * UNITS_PER_S)
STATION, VEHICLE = MavlinkCodec(255, 190), MavlinkCodec(1, 1)


def signing(key: SigningKey = KEY, start_unix_s: float = NOW_S, **options: Any) -> Signing:
    return Signing(key, start_unix_s, **options)


def start(codec: MavlinkCodec = STATION) -> bytes:
    """An unsigned command to the companion."""
    return codec.pack(dialect.MAVLink_command_long_message(1, 191, 300, 0, *(0.0,) * 7))


def heartbeat(codec: MavlinkCodec = VEHICLE) -> bytes:
    return codec.pack(dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3))


def stamp_of(frame: bytes) -> int:
    return int.from_bytes(frame[-12:-6], "little")


def pymavlink(key: SigningKey, link: int = 0, stamp: int = NOW) -> Any:
    peer = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
    peer.signing.secret_key, peer.signing.link_id = key.secret, link
    peer.signing.timestamp, peer.signing.sign_outgoing = stamp, True
    return peer


MESSAGES = st.sampled_from([kind for _, kind in sorted(common.mavlink_map.items())])


@given(st.data())
def test_signatures_are_those_of_pymavlink(data: st.DataObject) -> None:
    """Both ways, for every message of the dialect and any key, link and time."""
    key = SigningKey(data.draw(st.binary(min_size=32, max_size=32)))
    link, start_s = data.draw(st.integers(0, 255)), data.draw(st.integers(EPOCH_UNIX_S, 2**31))
    kind, seed = data.draw(MESSAGES), data.draw(st.integers(0, 2**32))
    stamp = (start_s - EPOCH_UNIX_S) * UNITS_PER_S
    payload = Random(seed).randbytes(kind.unpacker.size)
    peer = pymavlink(key, link, stamp)
    unsigned = bytes(message_of(kind, payload).pack(dialect.MAVLink(None, 255, 190)))
    (ours,) = signing(key, start_s).send(0.0, [unsigned], link)
    peer.signing.timestamp += 1
    theirs = bytes(message_of(kind, payload).pack(peer))
    assert ours == theirs
    assert signing(key, start_s).receive(0.0, [theirs]) == [theirs]
    decoded = pymavlink(key, link, stamp).decode(bytearray(ours))
    assert decoded.get_signed() and decoded.get_msgbuf() == ours


def message_of(kind: Any, payload: bytes) -> Any:
    """A message with a payload, as it would be packed again."""
    packed = bytes([len(payload), 0, 0, 0, 255, 190, *kind.id.to_bytes(3, "little")]) + payload
    crc = dialect.mcrf4xx(packed + bytes([kind.crc_extra]), 0xFFFF)
    frame = bytearray(b"\xfd" + packed + crc.to_bytes(2, "little"))
    return dialect.MAVLink(None, 255, 190).decode(frame)


def test_our_time_stamps_increase_strictly_and_follow_the_clock() -> None:
    ours = signing()
    sent = [f for now_s in (0.0, 0.0, 1.0, 0.5, 2.0) for f in ours.send(now_s, [start()] * 3)]
    stamps = [stamp_of(frame) - NOW for frame in sent]
    assert stamps == sorted(set(stamps))
    second = UNITS_PER_S
    assert [s for s in stamps if s > second][:6] == [second + i for i in range(1, 7)]
    assert stamps[-3:] == [2 * second + 1, 2 * second + 2, 2 * second + 3]


@pytest.mark.parametrize("year", [2015, 2026, 2058])
def test_a_time_stamp_counts_10_us_since_2015(year: int) -> None:
    """https://mavlink.io/en/guide/message_signing.html, "timestamp"."""
    now = datetime(year, 3, 4, 5, 6, 7, tzinfo=UTC)
    since = now - datetime(2015, 1, 1, tzinfo=UTC)
    (sent,) = signing(start_unix_s=now.timestamp()).send(0.0, [start()])
    assert stamp_of(sent) == since / timedelta(microseconds=10) + 1


def test_before_2015_time_stamps_begin_at_the_epoch_and_are_kept() -> None:
    """As on a machine whose clock was never set."""
    kept: list[Stamps] = []
    (sent,) = signing(start_unix_s=0.0, keep=kept.append).send(0.0, [start()])
    assert stamp_of(sent) == 1
    assert kept == [{(255, 190, 0): 1}]


def test_without_a_word_of_it_a_frame_leaves_on_link_0() -> None:
    (sent,) = signing().send(0.0, [start()])
    assert [sent] == signing().send(0.0, [start_of(sent)], 0)


def start_of(signed: bytes) -> bytes:
    """The command as it was before it was signed."""
    return signed[:2] + b"\0" + signed[3:-15] + unflagged(signed)


def test_what_is_signed_already_stays_as_it_is() -> None:
    signed = signing().send(0.0, [start()])
    assert signing(OTHER_KEY).send(0.0, signed) == signed


# -- attacks -------------------------------------------------------------------------------------

Attack = Callable[[list[bytes]], list[bytes]]


def forged(stamp: int, codec: MavlinkCodec = STATION, link: int = 0) -> bytes:
    """A command with a time stamp and without the right signature."""
    (frame,) = signing(OTHER_KEY).send(0.0, [start(codec)], link)
    return frame[:-12] + stamp.to_bytes(6, "little") + frame[-6:]


def damaged(heard: list[bytes]) -> list[bytes]:
    """Each bit of a frame changed once; of the header only where a frame is left."""
    frame = heard[-1]
    spoilt = [
        frame[:at] + bytes([frame[at] ^ 1 << bit]) + frame[at + 1 :]
        for at in range(3, len(frame))
        for bit in range(8)
    ]
    return [f for f in spoilt if split_frames(f) == [f]]


ATTACKS: dict[str, Attack] = {
    "unsigned": lambda heard: [start(), start(VEHICLE), heartbeat()],
    "MAVLink 1": lambda heard: [
        bytes(dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3).pack(v1(), True))
    ],
    "signature cut off": lambda heard: [
        f[:2] + b"\0" + f[3:-15] + unflagged(f) for f in heard if f[7:10] != b"\0\0\0"
    ],
    "another key": lambda heard: signing(OTHER_KEY).send(9.0, [start(), heartbeat()]),
    "the key of zeros": lambda heard: signing(SigningKey(bytes(32))).send(9.0, [start()]),
    "damaged": damaged,
    "replayed": lambda heard: heard * 2,
    "replayed backwards": lambda heard: heard[::-1],
    "poisoned with the last time stamp": lambda heard: [forged(2**48 - 2), forged(2**48 - 1)],
    "poisoned on all links": lambda heard: [
        forged(2**48 - 2, codec, link) for codec in (STATION, VEHICLE) for link in range(256)
    ],
    "many streams": lambda heard: [
        forged(NOW + 10 * UNITS_PER_S, MavlinkCodec(n, m)) for n in range(1, 64) for m in range(32)
    ],
    "moved to another link": lambda heard: [f[:-13] + b"\x07" + f[-12:] for f in heard],
    "a later time stamp": lambda heard: [
        f[:-12] + (stamp_of(f) + UNITS_PER_S).to_bytes(6, "little") + f[-6:] for f in heard
    ],
}


def v1() -> Any:
    return dialect.MAVLink(None, srcSystem=1, srcComponent=1)


def unflagged(frame: bytes) -> bytes:
    """The checksum of a command that was signed, without the flag."""
    crc = dialect.mcrf4xx(frame[1:2] + b"\0" + frame[3:-15] + bytes([152]), 0xFFFF)
    return int(crc).to_bytes(2, "little")


@pytest.mark.parametrize("attack", ATTACKS.values(), ids=ATTACKS)
@pytest.mark.parametrize("is_restarted", [False, True], ids=["same run", "after a restart"])
def test_of_an_attack_nothing_is_accepted(attack: Attack, is_restarted: bool) -> None:
    """And who has the key is heard as before, at once."""
    kept: list[Stamps] = []
    ours = signing(may_be_unsigned=of_signed_vehicle, keep=kept.append)
    station, vehicle = signing(), signing()
    heard = []
    for second in range(8):
        now_s = float(second)
        sent = station.send(now_s, [start()] * 2) + vehicle.send(now_s, [heartbeat()] * 2)
        assert ours.receive(now_s, sent) == sent
        heard += sent
    now_s = 8.0
    if is_restarted:
        now_s = 0.0
        later_s = NOW_S + 8.0
        ours = signing(start_unix_s=later_s, may_be_unsigned=of_signed_vehicle, heard=kept[-1])
    attacks = attack(heard)
    assert attacks and ours.receive(now_s, attacks) == []
    assert sum(ours.refused) == len(attacks)
    sent = station.send(10.0, [start()]) + vehicle.send(10.0, [heartbeat()])
    assert ours.receive(now_s, sent) == sent


def test_attacks_are_frames_that_are_commands_without_signing() -> None:
    """They are not refused for another reason."""
    heard = signing().send(0.0, [start()])
    ear = MavlinkCodec(0, 0)
    for name in ("unsigned", "signature cut off", "another key", "replayed", "many streams"):
        for attack in ATTACKS[name](heard):
            assert len(ear.parse(attack)) == 1, name


def test_a_frame_counts_once_on_whichever_link_it_comes() -> None:
    vehicle = signing()
    (sent,) = signing().send(0.0, [start()])
    assert vehicle.receive(0.0, [sent]) == [sent]
    assert vehicle.receive(0.1, [sent]) == []  # the same object serves all links


def test_our_own_frames_are_not_accepted_when_they_come_back() -> None:
    kept: list[Stamps] = []
    ours = signing(keep=kept.append)
    sent = ours.send(0.0, [heartbeat(), start()])
    assert ours.receive(0.1, sent) == []
    assert signing(heard=kept[-1]).receive(0.1, sent) == []


def test_unsigned_and_replayed_before_the_peer_is_known() -> None:
    """Old captures of a stream that is new: at most a minute is accepted, and after it nothing."""
    old, recent = signing(start_unix_s=NOW_S - 61.0), signing(start_unix_s=NOW_S - 59.0)
    ours = signing()
    assert ours.receive(0.0, old.send(0.0, [start()])) == []
    (first,) = recent.send(0.0, [start()])
    assert ours.receive(0.0, [first]) == [first]
    assert ours.receive(0.0, [first]) == []


@given(st.lists(st.tuples(st.floats(0.0, 30.0), st.booleans()), max_size=60), st.booleans())
def test_nothing_that_was_accepted_is_accepted_after_a_restart(
    sent_at: list[tuple[float, bool]], is_clock_known: bool
) -> None:
    """Whenever the program ends: what was kept is at most `KEPT_EVERY_S` old for each stream."""
    kept: list[Stamps] = [{}]
    ours, station, vehicle = signing(keep=kept.append), signing(), signing()
    accepted = []
    for at_s, is_station in sorted(sent_at):
        codec, peer = (STATION, station) if is_station else (VEHICLE, vehicle)
        accepted += ours.receive(at_s, peer.send(at_s, [start(codec)]))
    assert len(accepted) == len(sent_at)
    again_s = NOW_S + 30.0 if is_clock_known else NOW_S - 1e6
    again = signing(start_unix_s=again_s, heard=kept[-1])
    assert again.receive(0.0, accepted) == []
    late_s = 30.0 + KEPT_EVERY_S + 0.1
    fresh = station.send(late_s, [start()])
    assert again.receive(0.0, fresh) == fresh


def test_a_clock_that_is_not_known_goes_on_where_it_was() -> None:
    """As on a Raspberry Pi, which starts in 1970."""
    kept: list[Stamps] = []
    signing(keep=kept.append).send(0.0, [start()])
    again = signing(start_unix_s=0.0, heard=kept[-1])
    (sent,) = again.send(0.0, [start()])
    assert stamp_of(sent) == NOW + 1 + KEPT_EVERY_S * UNITS_PER_S + 1
    assert again.receive(0.0, signing(start_unix_s=NOW_S - 61.0).send(0.0, [heartbeat()])) == []


def test_a_stream_that_is_new_may_be_a_minute_behind_and_not_10_us_more() -> None:
    """Behind the clock as it is then, not as it was at the start."""
    for now_s in (0.0, 100.0):
        for late, accepted in ((0, True), (1, False)):
            ours = signing()
            (sent,) = at(NOW + int(now_s) * UNITS_PER_S - 60 * UNITS_PER_S - late)
            assert ours.receive(now_s, [sent]) == [sent] * accepted


def at(stamp: int, codec: MavlinkCodec = STATION) -> list[bytes]:
    """A command that is signed with a time stamp."""
    elsewhere = {(9, 9, 9): stamp - 1 - KEPT_EVERY}
    sent = signing(start_unix_s=0.0, heard=elsewhere).send(0.0, [start(codec)])
    assert stamp_of(sent[0]) == stamp
    return sent


def test_time_stamps_are_kept_every_two_seconds() -> None:
    """As often as a restart makes up for, and not oftener: a disk is written for each."""
    kept: list[Stamps] = []
    ours = signing(keep=kept.append)
    for second in range(9):
        ours.send(float(second), [start()])
    assert [stamps[255, 190, 0] - NOW - 1 for stamps in kept] == [
        second * UNITS_PER_S for second in (0, 2, 4, 6, 8)
    ]


def test_after_a_restart_of_two_seconds_a_peer_is_heard_at_once() -> None:
    kept: list[Stamps] = []
    station = signing()
    signing(keep=kept.append).receive(0.0, station.send(0.0, [start()]))
    fresh = station.send(2.001, [start()])
    again = signing(start_unix_s=NOW_S + 2.001, heard=kept[-1])
    assert again.receive(0.0, fresh) == fresh


def test_ours_follows_the_time_stamps_that_are_accepted() -> None:
    ahead = signing(start_unix_s=NOW_S + 3600.0)
    ours = signing()
    assert ours.receive(0.0, ahead.send(0.0, [heartbeat()]))
    (sent,) = ours.send(0.0, [start()])
    assert stamp_of(sent) > NOW + 3600 * UNITS_PER_S
    assert ahead.receive(0.0, [sent]) == [sent]


def test_the_end_of_the_range_is_not_taken_over() -> None:
    """Not even from who has the key: what leaves must go on."""
    late_s = EPOCH_UNIX_S + LATEST / UNITS_PER_S
    ours = signing()
    assert ours.receive(0.0, signing(start_unix_s=late_s).send(0.0, [heartbeat()])) == []
    (sent,) = ours.send(0.0, [start()])
    assert stamp_of(sent) == NOW + 1
    assert ours.receive(0.0, at(LATEST)) == []
    last = at(LATEST - 1)
    assert ours.receive(0.0, last) == last


def test_the_table_of_streams_is_bounded() -> None:
    ours, peer = signing(), signing()
    accepted = [
        len(ours.receive(0.0, peer.send(0.0, [start(MavlinkCodec(n, 1))], link)))
        for n in range(1, 9)
        for link in range(64)
    ]
    assert sum(accepted) == STREAMS == 256
    assert accepted[:256] == [1] * 256
    late_s = 2 * BEHIND / UNITS_PER_S
    fresh = peer.send(late_s, [start(MavlinkCodec(9, 1))])
    assert ours.receive(late_s, fresh) == fresh  # in place of one that is old
    assert ours.receive(late_s, fresh) == []


def test_a_stream_is_forgotten_when_none_of_its_frames_would_be_taken_for_new() -> None:
    """A minute old it could still be replayed; 10 us later it could not."""
    ours = signing()
    oldest, *others = [at(NOW + i, MavlinkCodec(1 + i // 128, i % 128)) for i in range(STREAMS)]
    for sent in (oldest, *others):
        assert ours.receive(0.0, sent) == sent
    for more, is_forgotten in ((0, False), (1, True)):
        now_s = (60 * UNITS_PER_S + more + 0.5) / UNITS_PER_S
        fresh = at(NOW + 60 * UNITS_PER_S, MavlinkCodec(9, 1))
        assert ours.receive(now_s, fresh) == fresh * is_forgotten
        assert ours.receive(now_s, oldest) == []


# -- unsigned ------------------------------------------------------------------------------------


def sample(number: int, sender: tuple[int, int]) -> bytes:
    rng = Random(number)
    return frame(number, payload_of(number, rng), rng, sender)


@pytest.mark.parametrize(
    ("may_be_unsigned", "wanted"),
    [
        (harmless, lambda number, component: number in HARMLESS),
        (
            of_signed_vehicle,
            lambda number, component: number in HARMLESS and (number, component) != (0, 1),
        ),
        (
            of_unsigned_vehicle,
            lambda number, component: number not in REQUESTS and component != 191,
        ),
    ],
    ids=["PX4", "signed vehicle", "unsigned vehicle"],
)
def test_which_messages_may_be_unsigned(
    may_be_unsigned: MayBeUnsigned, wanted: Callable[[int, int], bool]
) -> None:
    ours = signing(may_be_unsigned=may_be_unsigned)
    for sender in ((1, 1), (1, 191), (255, 190)):
        for number in dialect.mavlink_map:
            passed = ours.receive(0.0, [sample(number, sender)])
            assert bool(passed) is wanted(number, sender[1]), number


def test_px4_s_list() -> None:
    names = {dialect.mavlink_map[number].msgname for number in HARMLESS}
    assert names == {"HEARTBEAT", "RADIO_STATUS", "ADSB_VEHICLE", "COLLISION"}


def test_all_that_the_companion_answers_has_to_be_signed() -> None:
    from companion.ground.component import WANTED

    assert {dialect.mavlink_map[number].msgname for number in REQUESTS} > WANTED


# -- counts and keys -----------------------------------------------------------------------------


def test_what_was_refused_is_told_when_it_has_doubled() -> None:
    ours = signing()
    told = []
    for _ in range(9):
        ours.receive(0.0, [start()])
        told.append(ours.news())
    assert ours.refused == Refused(unsigned=9, forged=0, old=0)
    counts = [None if refused is None else refused.unsigned for refused in told]
    assert counts == [1, 2, None, 4, None, None, None, 8, None]
    assert str(Refused(1, 2, 3)) == "1 unsigned, 2 with another key, 3 too old"


def test_each_refused_frame_counts_once_by_its_reason() -> None:
    """A sequence number of MAVLink 1 stands where MAVLink 2 has its flags."""
    ours, sent = signing(), signing().send(0.0, [start()])
    old = v1()
    for unsigned in range(1, 5):
        beat = dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3)
        assert ours.receive(0.0, [bytes(beat.pack(old, True))]) == []
        old.seq += 1
        assert ours.refused == Refused(unsigned, 0, 0)
    assert ours.receive(0.0, sent) == sent
    for number in range(1, 4):
        assert ours.receive(0.0, [*sent, *ATTACKS["another key"](sent)[:1]]) == []
        assert ours.refused == Refused(4, number, number)


def test_a_key_is_not_printed() -> None:
    key = SigningKey.from_passphrase("secret words")
    for text in (repr(key), str(key), f"{key}"):
        assert text == "SigningKey(...)"


def test_a_passphrase_makes_qgroundcontrol_s_key() -> None:
    """SHA-256 of "abc": FIPS 180-2, B.1."""
    assert SigningKey.from_passphrase("abc").secret.hex().startswith("ba7816bf8f01cfea414140de5dae")


def test_64_hexadecimal_digits_are_a_key() -> None:
    assert SigningKey.from_hex(KEY.secret.hex()).secret == KEY.secret
    with pytest.raises(CompanionError, match="is 64 hexadecimal digits"):
        SigningKey.from_hex("zz" * 32)


@pytest.mark.parametrize("text", ["", "00" * 31, "00" * 33, "zz" * 32, "ü"])
def test_something_else_is_no_key(text: str) -> None:
    with pytest.raises(CompanionError, match="a signing key"):
        SigningKey.from_hex(text)
