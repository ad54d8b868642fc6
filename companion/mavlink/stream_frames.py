"""Finds the frames in a stream of bytes without datagrams, such as a serial line.

A frame counts only if its checksum is right. So reading resumes directly behind damaged bytes, and
can begin at any byte. Unknown messages are left out, as their checksum cannot be verified. No I/O.
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
