"""What an FTP server does for each opcode: with the files of a store, and with open files.

The files are written and read as a whole; an open file is a session (`ftp_sessions.py`).
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Protocol

from companion.ground.ftp_sessions import Client, Session, SessionEvent, Sessions, SessionState
from companion.mavlink.ftp_frames import (
    DATA_BYTES,
    FtpRefusal,
    FtpRequest,
    Nak,
    Opcode,
    ack,
    crc32,
)

BURST = 16

log = logging.getLogger(__name__)


class Store(Protocol):
    """Files and folders below one root. Every method may raise `FtpRefusal`."""

    def entries(self, path: str) -> list[str]:
        """Returns a folder's entries in the protocol's form: Dname; or Fname, a tab, the size."""

    def read(self, path: str) -> bytes:
        """Returns the content of a file."""

    def check_writable(self, path: str) -> None:
        """Raises unless a file can be written there."""

    def write(self, path: str, content: bytes) -> None:
        """Creates or replaces a file in one step; a partial file is never visible."""

    def remove(self, path: str) -> None:
        """Removes a file."""

    def make_folder(self, path: str) -> None:
        """Makes a folder in one that exists."""

    def remove_folder(self, path: str) -> None:
        """Removes an empty folder."""

    def rename(self, old: str, new: str) -> None:
        """Renames a file or folder; replaces nothing."""


@dataclass(frozen=True, slots=True)
class FtpCall:
    """A request, its client and its time."""

    now_s: float
    client: Client
    request: FtpRequest

    def path(self) -> str:
        """Returns the one path in the request."""
        texts = self.request.texts()
        if len(texts) != 1:
            raise FtpRefusal(Nak.FAIL)
        return texts[0]


class FtpServices:
    """The services of one server.

    Args:
        store: the files.
        sessions: the open files.
    """

    def __init__(self, store: Store, sessions: Sessions) -> None:
        self._stored: list[str] = []
        self._store, self._sessions = store, sessions

    def take_stored(self) -> list[str]:
        """Returns the paths of the files with new content since the last call, in order."""
        stored, self._stored = self._stored, []
        return stored

    def do(self, asked: FtpCall) -> list[bytes]:
        """Does what a client requests; returns the payloads of the replies.

        Raises:
            FtpRefusal: it cannot be done.
        """
        if asked.request.size > DATA_BYTES:
            raise FtpRefusal(Nak.INVALID_DATA_SIZE)
        match asked.request.opcode:
            case Opcode.NONE:
                return [ack(asked.request)]
            case Opcode.TERMINATE_SESSION:
                return self._terminate(asked)
            case Opcode.RESET_SESSIONS:
                return self._reset(asked)
            case Opcode.LIST_DIRECTORY:
                return self._list(asked)
            case Opcode.OPEN_FILE_RO:
                return self._open_to_read(asked)
            case Opcode.READ_FILE:
                return self._read(asked)
            case Opcode.CREATE_FILE:
                return self._create(asked)
            case Opcode.WRITE_FILE:
                return self._write(asked)
            case Opcode.REMOVE_FILE:
                return self._remove(asked)
            case Opcode.CREATE_DIRECTORY:
                return self._make_folder(asked)
            case Opcode.REMOVE_DIRECTORY:
                return self._remove_folder(asked)
            case Opcode.OPEN_FILE_WO:
                return self._open_to_write(asked)
            case Opcode.TRUNCATE_FILE:
                return self._truncate(asked)
            case Opcode.RENAME:
                return self._rename(asked)
            case Opcode.CALC_FILE_CRC32:
                return self._crc32(asked)
            case Opcode.BURST_READ_FILE:
                return self._burst(asked)
        raise FtpRefusal(Nak.UNKNOWN_COMMAND)

    def _session(self, asked: FtpCall) -> Session:
        return self._sessions.find(asked.now_s, asked.client, asked.request.session)

    def _terminate(self, asked: FtpCall) -> list[bytes]:
        session = self._session(asked)
        event = SessionEvent.TERMINATED if session.is_whole else SessionEvent.TERMINATED_WITH_GAPS
        state = self._sessions.advance(asked.client, session, event)
        if state is SessionState.DROPPED:
            raise FtpRefusal(Nak.FAIL)
        if state is SessionState.COMPLETE:
            self._store.write(session.path, bytes(session.content))
            log.debug("%d/%d wrote %s, %d bytes", *asked.client, session.path, len(session.content))
            self._stored.append(session.path)
        return [ack(asked.request)]

    def _reset(self, asked: FtpCall) -> list[bytes]:
        self._sessions.reset(asked.client)
        return [ack(asked.request)]

    def _list(self, asked: FtpCall) -> list[bytes]:
        entries = self._store.entries(asked.path())[asked.request.offset :]
        if not entries:
            raise FtpRefusal(Nak.EOF)
        listed = b""
        for entry in entries:
            line = entry.encode() + b"\0"
            if len(listed) + len(line) > DATA_BYTES:
                break
            listed += line
        return [ack(asked.request, listed)]

    def _open_to_read(self, asked: FtpCall) -> list[bytes]:
        content = self._store.read(asked.path())
        return self._open(asked, content, SessionEvent.OPENED_TO_READ)

    def _create(self, asked: FtpCall) -> list[bytes]:
        self._store.check_writable(asked.path())
        return self._open(asked, b"", SessionEvent.OPENED_TO_WRITE)

    def _open_to_write(self, asked: FtpCall) -> list[bytes]:
        self._store.check_writable(asked.path())
        content = self._content_if_any(asked.path())
        return self._open(asked, content, SessionEvent.OPENED_TO_WRITE)

    def _content_if_any(self, path: str) -> bytes:
        try:
            return self._store.read(path)
        except FtpRefusal as refusal:
            if refusal.nak is not Nak.FILE_NOT_FOUND:
                raise
            return b""

    def _open(self, asked: FtpCall, content: bytes, event: SessionEvent) -> list[bytes]:
        session = self._sessions.open(
            asked.now_s, asked.client, asked.request.session, asked.path(), content, event
        )
        size = len(content).to_bytes(4, "little")
        return [ack(asked.request, size, session=session.number)]

    def _read(self, asked: FtpCall) -> list[bytes]:
        session = self._session(asked)
        data = _part(session, asked.request.offset, asked.request.size)
        self._sessions.advance(asked.client, session, SessionEvent.READ)
        return [ack(asked.request, data)]

    def _burst(self, asked: FtpCall) -> list[bytes]:
        replies: list[bytes] = []
        request, session = asked.request, self._session(asked)
        offset, step = request.offset, request.size or DATA_BYTES
        for nth in range(BURST):
            data = _part(session, offset, request.size)
            is_last = nth == BURST - 1 or offset + step >= len(session.content)
            replies.append(ack(request, data, offset=offset, nth=nth, ends_burst=is_last))
            if is_last:
                break
            offset += step
        self._sessions.advance(asked.client, session, SessionEvent.READ)
        return replies

    def _write(self, asked: FtpCall) -> list[bytes]:
        session, request = self._session(asked), asked.request
        try:
            session.write(request.offset, request.data)
        except FtpRefusal:
            self._sessions.advance(asked.client, session, SessionEvent.WRITE_REFUSED)
            raise
        self._sessions.advance(asked.client, session, SessionEvent.WRITTEN)
        return [ack(request)]

    def _truncate(self, asked: FtpCall) -> list[bytes]:
        path = asked.path()
        content = self._store.read(path)
        if asked.request.offset > len(content):
            raise FtpRefusal(Nak.INVALID_DATA_SIZE)
        self._store.write(path, content[: asked.request.offset])
        self._stored.append(path)
        return [ack(asked.request)]

    def _remove(self, asked: FtpCall) -> list[bytes]:
        self._store.remove(asked.path())
        return [ack(asked.request)]

    def _make_folder(self, asked: FtpCall) -> list[bytes]:
        self._store.make_folder(asked.path())
        return [ack(asked.request)]

    def _remove_folder(self, asked: FtpCall) -> list[bytes]:
        self._store.remove_folder(asked.path())
        return [ack(asked.request)]

    def _rename(self, asked: FtpCall) -> list[bytes]:
        texts = asked.request.texts()
        if len(texts) != 2:
            raise FtpRefusal(Nak.FAIL)
        old, new = texts
        self._store.rename(old, new)
        self._stored.append(new)
        return [ack(asked.request)]

    def _crc32(self, asked: FtpCall) -> list[bytes]:
        return [ack(asked.request, crc32(self._store.read(asked.path())).to_bytes(4, "little"))]


def _part(session: Session, offset: int, size: int) -> bytes:
    """Returns `size` bytes of an open file, at most as many as fit into a reply.

    Raises:
        FtpRefusal: the file ends before the offset.
    """
    if offset >= len(session.content):
        raise FtpRefusal(Nak.EOF)
    return bytes(session.content[offset : offset + (size or DATA_BYTES)])
