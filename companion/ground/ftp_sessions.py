"""The sessions of MAVLink FTP: which file a client has open, and how much of it has arrived.

An open file is a copy in memory: a reader sees the file as it was when it was opened, a writer
changes nothing until it ends its session. Rules:
1. The state of a session is a `SessionState`; it changes only by the rows of `TRANSITIONS`. A
   session in a final state is freed at once, and its number may be used again.
2. A client gets the session number that it requests, unless it has that one open already.
   (pymavlink and MAVProxy ignore replies with another number; MAVSDK always requests 0 and takes
   what it gets.)
3. A client has at most 4 sessions, all clients together 8.
4. A session without activity for 30 s ends, and what was written is dropped: half a mission may be
   a valid mission, but not the intended one.
5. A session that ends with a missing byte is dropped, and so is one whose write is refused.

Source: https://mavlink.io/en/services/ftp.html.
"""

from __future__ import annotations

import errno
from dataclasses import dataclass, field
from enum import Enum

from companion.mavlink.ftp_frames import FtpRefusal, Nak
from companion.transitions import StateTransition, TransitionTable

MAX_SESSIONS = 8
MAX_SESSIONS_OF_CLIENT = 4
IDLE_S = 30.0
MAX_FILE_BYTES = 256 * 1024
MAX_RANGES = 64  # written out of order, with gaps between them; clients have five writes on the way

Client = tuple[int, int]
"""System and component id."""


class SessionState(Enum):
    """The states of a session; CLOSED, COMPLETE and DROPPED are final."""

    READING = "reading"
    WRITING = "writing"
    CLOSED = "closed"
    COMPLETE = "complete"
    DROPPED = "dropped"


class SessionEvent(Enum):
    """What happens to a session, named after the protocol's requests."""

    OPENED_TO_READ = "OPEN_FILE_RO"
    OPENED_TO_WRITE = "CREATE_FILE or OPEN_FILE_WO"
    READ = "READ_FILE or BURST_READ_FILE"
    WRITTEN = "WRITE_FILE"
    WRITE_REFUSED = "WRITE_FILE, refused"
    TERMINATED = "TERMINATE_SESSION"
    TERMINATED_WITH_GAPS = "TERMINATE_SESSION, a byte is missing"
    RESET = "RESET_SESSIONS"
    EXPIRED = "idle for 30 s"


_S, _E = SessionState, SessionEvent
_DROP = "the copy is dropped; the file stays as it was"
TRANSITIONS = TransitionTable(
    StateTransition(
        None, _E.OPENED_TO_READ, _S.READING, "a copy of the file is kept for the client"
    ),
    StateTransition(None, _E.OPENED_TO_WRITE, _S.WRITING, "a copy begins, empty or as the file is"),
    StateTransition(_S.READING, _E.READ, _S.READING, "a part of the copy is sent"),
    StateTransition(_S.READING, _E.WRITE_REFUSED, _S.CLOSED, "refused with FileProtected"),
    StateTransition(_S.READING, _E.TERMINATED, _S.CLOSED, "nothing"),
    StateTransition(_S.READING, _E.RESET, _S.CLOSED, "nothing"),
    StateTransition(_S.READING, _E.EXPIRED, _S.CLOSED, "nothing"),
    StateTransition(_S.WRITING, _E.READ, _S.WRITING, "a part of the copy is sent"),
    StateTransition(_S.WRITING, _E.WRITTEN, _S.WRITING, "the data is put into the copy"),
    StateTransition(
        _S.WRITING, _E.WRITE_REFUSED, _S.DROPPED, f"refused: too large, or gaps; {_DROP}"
    ),
    StateTransition(
        _S.WRITING, _E.TERMINATED, _S.COMPLETE, "the copy becomes the file, in one step"
    ),
    StateTransition(_S.WRITING, _E.TERMINATED_WITH_GAPS, _S.DROPPED, f"refused with Fail; {_DROP}"),
    StateTransition(_S.WRITING, _E.RESET, _S.DROPPED, _DROP),
    StateTransition(_S.WRITING, _E.EXPIRED, _S.DROPPED, _DROP),
)
"""Rule 1: the life of a session."""


@dataclass
class Session:
    """An open file.

    Attributes:
        arrived: which bytes were written, or existed before, as disjoint ranges in order.
        used_s: time of the last activity.
    """

    number: int
    path: str
    content: bytearray
    state: SessionState
    used_s: float
    arrived: list[tuple[int, int]] = field(default_factory=list)

    def write(self, offset: int, data: bytes) -> None:
        """Writes data at an offset; gaps are zero until something is written there.

        Raises:
            FtpRefusal: the file is open for reading, would become too large, or has too many gaps.
        """
        if self.state is not SessionState.WRITING:
            raise FtpRefusal(Nak.FILE_PROTECTED)
        end = offset + len(data)
        if end > MAX_FILE_BYTES:
            raise FtpRefusal(Nak.FAIL_ERRNO, errno.EFBIG)
        self.content.extend(bytes(max(0, end - len(self.content))))
        self.content[offset:end] = data
        self.arrived = _joined([*self.arrived, (offset, end)])
        if len(self.arrived) > MAX_RANGES:
            raise FtpRefusal(Nak.FAIL)

    @property
    def is_whole(self) -> bool:
        """Whether no byte is missing."""
        return self.arrived in ([], [(0, len(self.content))])


def _joined(ranges: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Merges ranges that may touch or overlap into disjoint ranges in order.

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
        self,
        now_s: float,
        client: Client,
        number: int,
        path: str,
        content: bytes,
        event: SessionEvent,
    ) -> Session:
        """Opens a file for a client.

        Args:
            number: the number that the client requests.
            content: of the file.
            event: how it is opened.

        Raises:
            FtpRefusal: there are too many sessions.
        """
        used = {n for c, n in self._sessions if c == client}
        if len(self._sessions) >= MAX_SESSIONS or len(used) >= MAX_SESSIONS_OF_CLIENT:
            raise FtpRefusal(Nak.NO_SESSIONS_AVAILABLE)
        if number in used:
            number = next(n for n in range(256) if n not in used)
        state = TRANSITIONS.next(None, event)
        session = Session(number, path, bytearray(content), state, now_s)
        session.arrived = _joined([(0, len(content))])
        self._sessions[client, number] = session
        return session

    def find(self, now_s: float, client: Client, number: int) -> Session:
        """Returns a client's session, and notes the activity.

        Raises:
            FtpRefusal: there is no such session.
        """
        session = self._sessions.get((client, number))
        if session is None:
            raise FtpRefusal(Nak.INVALID_SESSION)
        session.used_s = now_s
        return session

    def advance(self, client: Client, session: Session, event: SessionEvent) -> SessionState:
        """Moves a session to its next state, frees it if that is final, and returns the state."""
        session.state = TRANSITIONS.next(session.state, event)
        if TRANSITIONS.is_final(session.state):
            del self._sessions[client, session.number]
        return session.state

    def reset(self, client: Client) -> None:
        """Ends a client's sessions; others keep theirs."""
        for (owner, _), session in list(self._sessions.items()):
            if owner == client:
                self.advance(owner, session, SessionEvent.RESET)

    def expire(self, now_s: float) -> None:
        """Ends the sessions that have been idle for too long."""
        for (owner, _), session in list(self._sessions.items()):
            if now_s - session.used_s > IDLE_S:
                self.advance(owner, session, SessionEvent.EXPIRED)
