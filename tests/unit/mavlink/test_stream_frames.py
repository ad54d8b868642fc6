"""Frames in a stream of bytes: whatever it is cut into, and whatever lies between them."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.stream_frames import LONGEST_FRAME, StreamFrames

NOISE = st.binary(max_size=40)


def frames(count: int) -> list[bytes]:
    """Pings that differ, of several lengths."""
    codec = MavlinkCodec(1, 1)
    return [
        codec.pack(dialect.MAVLink_ping_message(7 << 8 * i % 64, i, 0, 0)) for i in range(count)
    ]


@given(st.lists(st.integers(1, 60), min_size=1), st.integers(1, 20))
def test_it_does_not_matter_how_a_stream_is_cut(cuts: list[int], count: int) -> None:
    sent, stream, taken = b"".join(frames(count)), StreamFrames(), []
    while sent:
        for cut in cuts:
            taken += stream.take(sent[:cut])
            sent = sent[cut:]
    assert taken == frames(count)


@given(st.lists(NOISE, min_size=4, max_size=4))
def test_noise_hides_no_frame(noise: list[bytes]) -> None:
    """What follows shows that a mark in the noise began no frame."""
    sent = [part for pair in zip(noise, frames(4), strict=True) for part in pair]
    taken = StreamFrames().take(b"".join(sent) + bytes(LONGEST_FRAME))
    assert taken == frames(4)


def test_a_damaged_frame_costs_itself_alone() -> None:
    first, damaged, last = frames(3)
    assert StreamFrames().take(first + damaged[:12] + b"\x55" + damaged[13:] + last) == [
        first,
        last,
    ]


def test_nothing_inside_a_frame_with_unknown_flags_is_a_frame() -> None:
    codec = MavlinkCodec(1, 1)
    (inner,) = frames(1)
    text = codec.pack(
        dialect.MAVLink_encapsulated_data_message(0, [*inner, *bytes(253 - len(inner))])
    )
    raw = bytearray(text)
    raw[2] = 0x02  # not understood; the checksum is made right
    end = 10 + raw[1]
    crc = dialect.mcrf4xx(bytes(raw[1:end]) + bytes([223]), 0xFFFF)
    raw[end:] = crc.to_bytes(2, "little")
    assert StreamFrames().take(bytes(raw)) == []


@given(st.binary(max_size=2000))
def test_any_bytes_are_read_and_little_is_kept(data: bytes) -> None:
    stream = StreamFrames()
    stream.take(data)
    assert len(stream._rest) < LONGEST_FRAME
