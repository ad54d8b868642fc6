"""Finds the frames in a stream of bytes, as of a serial line, which knows no datagrams.

A frame counts if its checksum is right, so that the stream is followed again right behind damaged
bytes, and at any byte from which it is heard. Messages that are not known have no checksum that
could be told; they are left out. No I/O.
"""

from __future__ import annotations

from companion.mavlink.framing import frame_size, is_intact, split_frames

LONGEST_FRAME = 280


class StreamFrames:
    """The frames of one stream, in order.

    >>> from companion.mavlink.framing import MavlinkCodec, dialect
    >>> ping = MavlinkCodec(1, 191).pack(dialect.MAVLink_ping_message(0, 7, 0, 0))
    >>> frames = StreamFrames()
    >>> [frames.take(part) == [ping] for part in (b"noise" + ping[:9], ping[9:], ping * 2)]
    [False, True, False]
    """

    def __init__(self) -> None:
        self._rest = b""

    def take(self, data: bytes) -> list[bytes]:
        """The frames that are complete with these bytes."""
        data = self._rest + data
        frames: list[bytes] = []
        at, size = 0, len(data)
        while at + 3 <= size:
            length = frame_size(data, at)
            if length is None:
                at += 1
                continue
            if at + length > size:
                break
            frame = data[at : at + length]
            if not is_intact(frame):
                at += 1
                continue
            frames += split_frames(frame)
            at += length
        self._rest = data[at:]
        return frames
