"""Frames: what is packed is parsed, and what is damaged disturbs nobody."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from companion.mavlink.framing import (
    MavlinkCodec,
    choose,
    decode,
    dialect,
    is_intact,
    message_id,
    source,
    split_frames,
)

STUBS = [b"", b"\xfd", b"\xfd\xff\x00", b"\xfe\xff", b"\xfd" + bytes(9), b"hello"]


def value(number: int) -> Any:
    return dialect.MAVLink_named_value_int_message(number, b"target", number)


def frame(number: int) -> bytes:
    return MavlinkCodec(1, 26).pack(value(number))


def old_frame(number: int) -> bytes:
    """The same in MAVLink 1."""
    return bytes(value(number).pack(dialect.MAVLink(None, 1, 26), force_mavlink1=True))


def signed_frame(number: int) -> bytes:
    sender = dialect.MAVLink(None, 1, 26)
    sender.signing.secret_key = bytes(32)
    sender.signing.sign_outgoing = True
    sender.signing.link_id, sender.signing.timestamp = 0, 1
    return bytes(value(number).pack(sender))


FRAMES = {"MAVLink 2": frame, "MAVLink 1": old_frame, "signed": signed_frame}


def values(messages: list[Any]) -> list[int]:
    return [message.value for message in messages]


# -- a codec ---------------------------------------------------------------------------------------


def test_frames_are_mavlink_2_and_say_who_sent_them() -> None:
    packed = MavlinkCodec(7, 191).pack(value(5))
    assert packed[0] == 0xFD
    (message,) = MavlinkCodec(0, 0).parse(packed)
    assert source(message) == (7, 191)
    assert (message.name, message.value) == ("target", 5)


def test_messages_that_pymavlink_lacks_are_packed_and_parsed_as_all_others() -> None:
    """REQUEST_EVENT (412), of the events service."""
    request = dialect.MAVLink_request_event_message(1, 1, 7, 9)
    (message,) = MavlinkCodec(0, 0).parse(MavlinkCodec(1, 191).pack(request))
    assert message.get_type() == "REQUEST_EVENT"
    assert (message.first_sequence, message.last_sequence) == (7, 9)


def test_the_sequence_number_counts_and_wraps() -> None:
    speaker, ear = MavlinkCodec(1, 1), MavlinkCodec(0, 0)
    numbers = [ear.parse(speaker.pack(value(0)))[0].get_seq() for _ in range(300)]
    assert numbers == [i % 256 for i in range(300)]


def example(kind: Any, number: int) -> Any:
    """A message with a value in every field; small numbers leave zeros at the end of some."""
    values = []
    for name, length in zip(kind.ordered_fieldnames, kind.array_lengths, strict=True):
        of_type = kind.fieldtypes[kind.fieldnames.index(name)]
        one: Any = b"a" * (length or 1) if of_type == "char" else number
        values.append(one if of_type == "char" or not length else [number] * length)
    return kind(**dict(zip(kind.ordered_fieldnames, values, strict=True)))


@pytest.mark.parametrize("number", [0, 1, 100])
def test_every_message_has_the_bytes_of_pymavlink(number: int) -> None:
    ours, theirs = MavlinkCodec(1, 191), dialect.MAVLink(None, srcSystem=1, srcComponent=191)
    for kind in dialect.mavlink_map.values():
        message = example(kind, number)
        assert ours.pack(message) == message.pack(theirs), kind.msgname
        theirs.seq = (theirs.seq + 1) % 256


@pytest.mark.parametrize("number", [0, 1, 100])
def test_every_message_is_decoded_as_pymavlink_decodes_it(number: int) -> None:
    codec, theirs = MavlinkCodec(1, 191), dialect.MAVLink(None, srcSystem=1, srcComponent=191)
    for kind in dialect.mavlink_map.values():
        if common.mavlink_map.get(kind.id) is not kind:
            continue  # one that pymavlink lacks: test_added_messages.py
        message = example(kind, number)
        frames = [codec.pack(message)]
        if kind.id < 256:
            frames.append(bytes(message.pack(theirs, force_mavlink1=True)))
        for packed in frames:
            heard, expected = decode(packed), theirs.decode(bytearray(packed))
            assert heard is not None
            assert heard == expected, kind.msgname
            assert heard.get_msgbuf() == packed
            assert vars(heard.get_header()) == vars(expected.get_header())


def test_extensions_that_are_left_out_are_what_pymavlink_makes_of_them() -> None:
    ours, theirs = MavlinkCodec(1, 191), dialect.MAVLink(None, srcSystem=1, srcComponent=191)
    extended = 0
    for kind in dialect.mavlink_map.values():
        extensions = len(kind.__init__.__defaults__ or ())
        message = example(kind, 1)
        given = tuple(getattr(message, name) for name in kind.fieldnames)
        for left_out in {1, extensions} & set(range(1, extensions + 1)):
            fields = given[: len(given) - left_out]
            if any(isinstance(field, str) for field in fields):
                continue
            assert ours.frame(kind, fields) == kind(*fields).pack(theirs), kind.msgname
            theirs.seq = (theirs.seq + 1) % 256
            extended += 1
    assert extended > 50


@given(st.integers(0, 2**24 - 1))
def test_a_message_s_id_has_three_bytes_the_lowest_first(number: int) -> None:
    """https://mavlink.io/en/guide/serialization.html, also beyond the dialect's ids."""
    kind = type("Far", (dialect.MAVLink_ping_message,), {"id": number})
    packed = MavlinkCodec(1, 191).frame(kind, (0, 7, 0, 0))
    assert packed[7:10] == number.to_bytes(3, "little")
    assert message_id(packed) == number


def test_hearing_does_not_disturb_speaking() -> None:
    both = MavlinkCodec(1, 1)
    both.pack(value(0))
    both.parse(frame(1))
    assert both.parse(both.pack(value(0)))[0].get_seq() == 1


@pytest.mark.parametrize("kind", FRAMES)
def test_every_kind_of_frame_is_heard(kind: str) -> None:
    assert values(MavlinkCodec(0, 0).parse(FRAMES[kind](5))) == [5]


def test_the_messages_of_a_datagram_keep_their_order() -> None:
    datagram = frame(1) + old_frame(2) + signed_frame(3)
    assert values(MavlinkCodec(0, 0).parse(datagram)) == [1, 2, 3]


@pytest.mark.parametrize("stub", STUBS)
def test_a_stub_does_not_swallow_the_next_datagram(stub: bytes) -> None:
    ear = MavlinkCodec(0, 0)
    for _ in range(3):
        assert ear.parse(stub) == []
        assert values(ear.parse(frame(5))) == [5]


def test_a_damaged_frame_is_not_heard() -> None:
    good = frame(5)
    ear = MavlinkCodec(0, 0)
    for at in range(len(good)):
        spoilt = bytearray(good)
        spoilt[at] ^= 0x40
        assert ear.parse(bytes(spoilt)) == []
        assert ear.parse(good[:at]) == []


def test_an_unknown_message_is_not_heard() -> None:
    unknown = dialect.MAVLink_message(54321, "NEW")
    packed = bytes(unknown._pack(dialect.MAVLink(None, 1, 1), 0, b"payload"))
    assert MavlinkCodec(0, 0).parse(packed) == []
    assert values(MavlinkCodec(0, 0).parse(packed + frame(5))) == [5]


@given(st.lists(st.binary(max_size=300), max_size=5))
def test_no_bytes_raise_and_the_next_datagram_is_heard(junk: list[bytes]) -> None:
    ear = MavlinkCodec(0, 0)
    for datagram in junk:
        ear.parse(datagram)
    assert values(ear.parse(frame(5))) == [5]


@pytest.mark.parametrize("kind", FRAMES)
def test_a_frame_is_intact_if_no_byte_is_changed(kind: str) -> None:
    whole = FRAMES[kind](5)
    checked = 2 + whole[1] + (10 if kind == "MAVLink 1" else 14) - 4
    assert is_intact(whole) is True
    for at in range(2, checked):
        assert is_intact(whole[:at] + bytes([whole[at] ^ 0x81]) + whole[at + 1 :]) is False, at


def test_of_an_unknown_message_no_frame_is_intact() -> None:
    unknown = dialect.MAVLink_message(54321, "NEW")
    packed = bytes(unknown._pack(dialect.MAVLink(None, 1, 1), 0, b"payload"))
    assert is_intact(packed) is False


# -- incompatibility flags -------------------------------------------------------------------------


def flagged(flags: int, number: int = 5) -> bytes:
    """A frame with incompatibility flags and the checksum, and signature, that belong to them."""
    is_signed = flags & dialect.MAVLINK_IFLAG_SIGNED
    whole = bytearray(signed_frame(number) if is_signed else frame(number))
    end = 10 + whole[1]
    whole[2] = flags
    crc = dialect.mcrf4xx(bytes(whole[1:end]) + bytes([value(0).crc_extra]), 0xFFFF)
    whole[end : end + 2] = crc.to_bytes(2, "little")
    return bytes(whole)


def pymavlink_takes(datagram: bytes) -> bool:
    try:
        return bool(dialect.MAVLink(None).parse_buffer(datagram))
    except dialect.MAVError:
        return False


def test_a_frame_with_a_flag_that_is_not_understood_is_dropped_alone() -> None:
    """The specification says so of every flag but the one of signed frames, and pymavlink too."""
    ear, known = MavlinkCodec(0, 0), {dialect.MAVLINK_MSG_ID_NAMED_VALUE_INT}
    understood = [flags for flags in range(256) if pymavlink_takes(flagged(flags))]
    assert understood == [0, dialect.MAVLINK_IFLAG_SIGNED]
    for flags in range(256):
        heard, whole = [5] * (flags in understood), flagged(flags)
        assert values(ear.parse(whole)) == heard
        assert choose([whole], known, set()) == [whole] * len(heard)
        assert values(ear.parse(frame(1) + whole + frame(2))) == [1, *heard, 2]


# -- splitting -------------------------------------------------------------------------------------

MARKS = {0xFD, 0xFE}
BETWEEN = st.binary(max_size=20).map(lambda junk: bytes(b for b in junk if b not in MARKS))


@given(st.lists(st.tuples(BETWEEN, st.sampled_from(list(FRAMES)), st.integers(0, 999)), max_size=6))
def test_a_datagram_is_split_into_the_frames_that_it_was_made_of(
    parts: list[tuple[bytes, str, int]],
) -> None:
    frames = [FRAMES[kind](number) for _, kind, number in parts]
    datagram = b"".join(junk + f for (junk, _, _), f in zip(parts, frames, strict=True))
    assert split_frames(datagram) == frames


@pytest.mark.parametrize("kind", FRAMES)
def test_a_frame_ends_where_its_header_says(kind: str) -> None:
    whole = FRAMES[kind](5)
    for more in range(20):
        assert split_frames(whole + bytes(more)) == [whole]


def test_the_shortest_frame_is_one_of_mavlink_1_without_payload() -> None:
    shortest = b"\xfe\x00\x00\x01\x01\x00\x00\x00"
    assert split_frames(shortest) == [shortest]
    assert split_frames(frame(1) + shortest) == [frame(1), shortest]


@given(st.binary(max_size=600))
def test_the_frames_of_any_bytes_lie_in_them_in_order(datagram: bytes) -> None:
    at = 0
    for found in split_frames(datagram):
        at = datagram.index(found, at) + len(found)
        assert found[0] in MARKS and len(found) >= 8
    assert at <= len(datagram)


@pytest.mark.parametrize("kind", FRAMES)
def test_a_frame_that_is_cut_short_is_no_frame(kind: str) -> None:
    whole = FRAMES[kind](5)
    for length in range(len(whole)):
        assert split_frames(frame(1) + whole[:length]) == [frame(1)]


# -- what is worth decoding ------------------------------------------------------------------------


def test_of_what_comes_often_only_the_newest_of_each_sender_is_chosen() -> None:
    """Newest by sequence number, also where it wraps; other messages and other senders stay."""
    one, two = MavlinkCodec(1, 1), MavlinkCodec(2, 1)
    text = dialect.MAVLink_named_value_float_message(0, b"x", 1.0)
    often = {dialect.MAVLINK_MSG_ID_NAMED_VALUE_INT}
    both = {*often, dialect.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT}
    for number in range(300):
        first, second = one.pack(value(number)), one.pack(text)
        third, other = one.pack(value(number + 1)), two.pack(value(number + 7))
        frames = [third, first, second, other]
        assert choose(frames, both, often) == [third, second, other]
        assert choose([first, third], both, often) == [third]
        assert choose(frames, both, set()) == frames
        assert choose(frames, often, set()) == [third, first, other]
        assert choose([b"".join(frames)], both, often) == [third, second, other]
        spoilt = one.pack(value(number))
        spoilt = spoilt[:10] + bytes([spoilt[10] ^ 1]) + spoilt[11:]
        assert choose([third, spoilt], both, often) == [third]  # newest, but damaged
    assert choose([old_frame(1), old_frame(2)], both, often) == [old_frame(1), old_frame(2)]


@pytest.mark.parametrize("first", [0, 100, 200])
def test_newer_is_what_is_less_than_half_the_sequence_numbers_ahead(first: int) -> None:
    """Serial number arithmetic, RFC 1982."""
    known = {dialect.MAVLINK_MSG_ID_NAMED_VALUE_INT}
    one = MavlinkCodec(1, 26)
    sent = [one.pack(value(number)) for number in range(512)]
    for ahead in range(1, 256):
        pair = [sent[first], sent[first + ahead]]
        assert choose(pair, known, known) == [pair[ahead < 128]], ahead


def test_of_mavlink_1_all_frames_are_chosen() -> None:
    """Their messages' ids stand elsewhere, and two of one sender may begin alike."""
    known = {dialect.MAVLINK_MSG_ID_NAMED_VALUE_INT}
    frames = [old_frame(7), old_frame(7)]
    assert choose(frames, known, known) == frames
