"""Reads one file over MAVLink FTP. No I/O: time and payloads in, payloads out.

Rules:
1. The file is opened, read in parts of 239 bytes, and closed. The server reports its size when it
   is opened; a file larger than the limit is not read.
2. At most AT_ONCE parts are under way, so the answers determine the pace.
3. A part that is not answered within ANSWER_S is requested again. An open or a close is repeated
   with the same number, so that a server that has already done it answers as before.
4. A refusal, or TRIES without anything new, ends the reading. A server with a single session
   refuses while the session is in use, and closes it after a while without requests.

Left out: bursts (BURST_READ_FILE), in which the server determines the pace. Source:
https://mavlink.io/en/services/ftp.html.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

from companion.mavlink.ftp_frames import (
    DATA_BYTES,
    FtpReply,
    FtpRequest,
    Nak,
    Opcode,
    ask,
    read_reply,
)

AT_ONCE = 4
ANSWER_S = 0.4
TRIES = 20
_SIZE_BYTES = 4
_START = 0


class ReadingState(Enum):
    """The states of reading a file."""

    OPENING = "opening"
    READING = "reading"
    CLOSING = "closing"
    ENDED = "ended"


class FileReading:
    """Reads one file of a server.

    Args:
        path: the server's name of it.
        most_bytes: a larger file is not read.
        sequence: number of its first request; a server may take an old one for a repetition.

    Attributes:
        state: the present state.
        content: of the file, once it was read completely.
        why_not: why it could not be read.
        sequence: number of the newest request.
    """

    def __init__(self, path: str, most_bytes: int, sequence: int) -> None:
        self.state = ReadingState.OPENING
        self.content: bytes | None = None
        self.why_not = ""
        self.sequence = sequence
        self._path = path.encode()
        self._most_bytes = most_bytes
        self._session = 0
        self._size = 0
        self._parts: dict[int, bytes] = {}
        self._asked_s: dict[int, float] = {}  # when, by offset
        self._tries = 0

    def due(self, now_s: float) -> list[bytes]:
        """The payloads to send now."""
        self._look_for_late(now_s)
        match self.state:
            case ReadingState.OPENING:
                return self._once(now_s, Opcode.OPEN_FILE_RO, self._path)
            case ReadingState.READING:
                return [self._read(now_s, at) for at in self._missing()]
            case ReadingState.CLOSING:
                return self._once(now_s, Opcode.TERMINATE_SESSION, b"")
        return []

    def take(self, payload: bytes) -> None:
        """Takes a payload from the server."""
        reply = read_reply(payload)
        if reply is None:
            return
        match self.state, reply.opcode:
            case ReadingState.OPENING, Opcode.OPEN_FILE_RO if self._is_answer(reply):
                self._take_open(reply)
            case ReadingState.READING, Opcode.READ_FILE if reply.session == self._session:
                self._take_part(reply)
            case ReadingState.CLOSING, Opcode.TERMINATE_SESSION if self._is_answer(reply):
                self._enter(ReadingState.ENDED)

    def _is_answer(self, reply: FtpReply) -> bool:
        return reply.sequence == (self.sequence + 1) % 65536

    def _take_open(self, reply: FtpReply) -> None:
        if not reply.is_ack:
            self._end(_reason(reply))
            return
        self._session = reply.session
        self._size = int.from_bytes(reply.data[:_SIZE_BYTES], "little")
        self._enter(ReadingState.READING)
        if self._size > self._most_bytes:
            self._close(f"it has {self._size} bytes, more than {self._most_bytes}")
        elif self._size == 0:
            self.content = b""
            self._close()

    def _take_part(self, reply: FtpReply) -> None:
        at = reply.offset
        if at not in self._asked_s:
            return
        if not reply.is_ack:
            self._close(_reason(reply))
        elif len(reply.data) == min(DATA_BYTES, self._size - at):
            del self._asked_s[at]
            self._parts[at], self._tries = reply.data, 0
            if len(self._parts) * DATA_BYTES >= self._size:
                self.content = b"".join(self._parts[each] for each in sorted(self._parts))
                self._close()

    def _missing(self) -> Iterator[int]:
        """Offsets of the parts to request now."""
        for at in range(_START, self._size, DATA_BYTES):
            if len(self._asked_s) >= AT_ONCE:
                return
            if at not in self._parts and at not in self._asked_s:
                yield at

    def _read(self, now_s: float, at: int) -> bytes:
        self._asked_s[at] = now_s
        self.sequence += 1
        return self._request(Opcode.READ_FILE, DATA_BYTES, at, b"")

    def _once(self, now_s: float, opcode: Opcode, data: bytes) -> list[bytes]:
        """A request that is not combined with others."""
        if self._asked_s:
            return []
        self._asked_s[_START] = now_s
        return [self._request(opcode, len(data), 0, data)]

    def _request(self, opcode: Opcode, size: int, offset: int, data: bytes) -> bytes:
        number = self.sequence % 65536
        return ask(FtpRequest(number, self._session, opcode, size, offset, data))

    def _look_for_late(self, now_s: float) -> None:
        """Lets what was not answered in time be requested again."""
        late = [at for at, asked_s in self._asked_s.items() if now_s - asked_s >= ANSWER_S]
        for at in late:
            del self._asked_s[at]
        self._tries += bool(late)
        if self._tries > TRIES:
            self._end("no answer")

    def _close(self, why_not: str = "") -> None:
        self.why_not = why_not
        self.sequence += 1
        self._enter(ReadingState.CLOSING)

    def _end(self, why_not: str) -> None:
        if self.content is None:
            self.why_not = self.why_not or why_not
        self._enter(ReadingState.ENDED)

    def _enter(self, state: ReadingState) -> None:
        self.state, self._tries = state, 0
        self._asked_s.clear()


def _reason(reply: FtpReply) -> str:
    code = reply.data[0] if reply.data else 0
    return Nak(code).name.replace("_", " ").lower() if code in set(Nak) else f"error {code}"
