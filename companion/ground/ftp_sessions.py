"""Which files does a client of MAVLink FTP have open, and how much of them has arrived?

An open file is a copy in memory: a reader sees the file as it was when it was opened, a writer
changes nothing until it ends its session. Rules:
1. A client gets the session number that it asks for (pymavlink and MAVProxy ignore replies with
   another; MAVSDK always asks for 0 and takes what it gets), unless it has that one open already.
2. A client has at most 4 sessions, all clients together 8.
3. A session in which nothing has happened for 30 s is freed, and what was written is dropped:
   half a mission may be a mission, but not the one that was meant.
"""

from __future__ import annotations

import errno
from dataclasses import dataclass, field

from companion.mavlink.ftp_frames import Nak, Refusal

MAX_SESSIONS = 8
MAX_SESSIONS_OF_CLIENT = 4
IDLE_S = 30.0
MAX_FILE_BYTES = 256 * 1024
MAX_RANGES = 64  # written out of order, with gaps between them; clients have five writes on the way

Client = tuple[int, int]
"""System and component id."""


@dataclass
class Session:
    """An open file.

    Attributes:
        arrived: which bytes have been written or were there, as disjoint ranges in order.
        used_s: when something happened last.
    """

    number: int
    path: str
    content: bytearray
    is_writing: bool
    used_s: float
    arrived: list[tuple[int, int]] = field(default_factory=list)

    def write(self, offset: int, data: bytes) -> None:
        """Puts data at an offset; gaps are zero until something is written there.

        Raises:
            Refusal: the file would become too large, or has too many gaps.
        """
        end = offset + len(data)
        if end > MAX_FILE_BYTES:
            raise Refusal(Nak.FAIL_ERRNO, errno.EFBIG)
        self.content.extend(bytes(max(0, end - len(self.content))))
        self.content[offset:end] = data
        self.arrived = _joined([*self.arrived, (offset, end)])
        if len(self.arrived) > MAX_RANGES:
            raise Refusal(Nak.FAIL)

    @property
    def is_whole(self) -> bool:
        """Whether no byte is missing between the first and the last."""
        return self.arrived in ([], [(0, len(self.content))])


def _joined(ranges: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Disjoint ranges in order, of ranges that may touch or overlap.

    >>> _joined([(0, 4), (8, 9), (4, 6)])
    [(0, 6), (8, 9)]
    """
    joined: list[tuple[int, int]] = []
    for start, end in sorted(ranges):
        if joined and start <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(end, joined[-1][1]))
        elif start < end:
            joined.append((start, end))
    return joined


class Sessions:
    """The sessions of all clients."""

    def __init__(self) -> None:
        self._sessions: dict[tuple[Client, int], Session] = {}

    def open(
        self, now_s: float, client: Client, number: int, path: str, content: bytes, is_writing: bool
    ) -> Session:
        """Opens a file for a client.

        Args:
            number: the one the client would like.
            content: what is in the file.

        Raises:
            Refusal: there are too many sessions.
        """
        used = {n for c, n in self._sessions if c == client}
        if len(self._sessions) >= MAX_SESSIONS or len(used) >= MAX_SESSIONS_OF_CLIENT:
            raise Refusal(Nak.NO_SESSIONS_AVAILABLE)
        if number in used:
            number = next(n for n in range(256) if n not in used)
        session = Session(number, path, bytearray(content), is_writing, now_s)
        session.arrived = _joined([(0, len(content))])
        self._sessions[client, number] = session
        return session

    def find(self, now_s: float, client: Client, number: int) -> Session:
        """A client's session, which is in use again.

        Raises:
            Refusal: there is none.
        """
        session = self._sessions.get((client, number))
        if session is None:
            raise Refusal(Nak.INVALID_SESSION)
        session.used_s = now_s
        return session

    def end(self, client: Client, number: int) -> None:
        """Frees a session; what was written is dropped."""
        self._sessions.pop((client, number), None)

    def end_all(self, client: Client) -> None:
        """Frees a client's sessions; others keep theirs."""
        self._sessions = {k: s for k, s in self._sessions.items() if k[0] != client}

    def expire(self, now_s: float) -> None:
        """Frees what has been idle for too long."""
        self._sessions = {k: s for k, s in self._sessions.items() if now_s - s.used_s <= IDLE_S}
