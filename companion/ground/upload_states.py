"""The states of an uploaded mission as a table, and the verdict that ends its check.

Pure: `uploads.py` handles the files, and looks up each next state here. Rules:
1. A mission that has arrived is queued. It arrives like any file, in a session of MAVLink FTP
   (`ftp_sessions.py`), and is stored when its last byte is there.
2. One mission is checked at a time; the others wait in the order in which they were stored.
3. A check that takes too long is ended, and its answer awaited.
4. An accepted mission waits until nothing is flown; in flight, for the landing. Only the newest
   accepted mission waits.
5. MAV_CMD_MISSION_START flies the active mission.
6. A mission that was accepted but not started is found again after a restart, and queued as if it
   had just been stored.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from enum import Enum

from companion.flight_events.hosting import UploadChecked, UploadNews
from companion.transitions import StateTransition, TransitionTable

FORMAT_VERSION = 1
"""That of verdict.json."""


class UploadState(Enum):
    """The states of an uploaded mission; REFUSED, STARTED and REPLACED are final."""

    QUEUED = "queued"
    CHECKING = "checking"
    OVERDUE = "overdue"
    REFUSED = "refused"
    ACCEPTED = "accepted"
    ACTIVE = "active"
    STARTED = "started"
    REPLACED = "replaced"


class UploadTrigger(Enum):
    """What moves an uploaded mission from one state to the next."""

    STORED = "stored"
    FOUND = "found after a restart"
    BEGUN = "the checks before its own are done"
    UNUSABLE = "it is cut off, or cannot be checked"
    PASSED = "the check accepts it"
    FAILED = "the check refuses it"
    TIMED_OUT = "30 s of checking are over"
    TAKEN = "nothing is flown"
    STARTED = "MISSION_START"
    NEWER_ACCEPTED = "a newer one is accepted"
    NEWER_ACTIVE = "a newer one is active"


_S, _E = UploadState, UploadTrigger
_ACCEPT = "its copy is moved in one step to where sorties take it from; the verdict is sent"
_REFUSE = "its copy is deleted, and the verdict is sent; nothing else changes"
TRANSITIONS = TransitionTable(
    StateTransition(None, _E.STORED, _S.QUEUED, "it waits for the checks before its own"),
    StateTransition(None, _E.FOUND, _S.QUEUED, "it waits as if it had just been stored"),
    StateTransition(_S.QUEUED, _E.BEGUN, _S.CHECKING, "a child process checks a copy of all files"),
    StateTransition(_S.QUEUED, _E.UNUSABLE, _S.REFUSED, _REFUSE),
    StateTransition(_S.CHECKING, _E.PASSED, _S.ACCEPTED, _ACCEPT),
    StateTransition(_S.CHECKING, _E.FAILED, _S.REFUSED, _REFUSE),
    StateTransition(_S.CHECKING, _E.TIMED_OUT, _S.OVERDUE, "the child process is ended"),
    StateTransition(_S.OVERDUE, _E.PASSED, _S.ACCEPTED, _ACCEPT),
    StateTransition(_S.OVERDUE, _E.FAILED, _S.REFUSED, _REFUSE),
    StateTransition(
        _S.ACCEPTED, _E.TAKEN, _S.ACTIVE, "it is read; from now on MISSION_START flies it"
    ),
    StateTransition(_S.ACCEPTED, _E.NEWER_ACCEPTED, _S.REPLACED, "it will not be flown"),
    StateTransition(
        _S.ACTIVE, _E.STARTED, _S.STARTED, "it is flown; a restart will not find it again"
    ),
    StateTransition(_S.ACTIVE, _E.NEWER_ACTIVE, _S.REPLACED, "its files are deleted"),
)
"""The life of an uploaded mission."""

IN_CHECK = (UploadState.CHECKING, UploadState.OVERDUE)
"""The states with a check under way."""


@dataclass(frozen=True, slots=True)
class UploadVerdict:
    """The result of the check of an uploaded mission.

    Attributes:
        number: counts the verdicts.
        mission: its path, as it was uploaded.
        crc32: of its content, as CalcFileCRC32 gives it.
        text: one line for people: the mission is accepted, or what is wrong and where.
        details: the plan, or everything that was said about the error.
        notices: what is allowed, but probably not intended.
    """

    number: int
    mission: str
    crc32: int
    is_accepted: bool
    text: str
    details: str
    notices: tuple[str, ...] = ()

    @property
    def news(self) -> tuple[UploadNews, ...]:
        """The events for operators."""
        noticed = (f"notice: {each}" for each in self.notices)
        is_refused = not self.is_accepted
        return tuple(UploadChecked(text, is_refused) for text in (self.text, *noticed))

    def as_json(self) -> bytes:
        """Returns the content of verdict.json."""
        return json.dumps({"version": FORMAT_VERSION} | asdict(self), indent=2).encode()
