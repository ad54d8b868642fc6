"""The MAVLink FTP server, without I/O: payloads of requests in, payloads of replies out.

A `Store` holds the files; open files are sessions (`ftp_sessions.py`). Rules:
1. A reply has the request's sequence number + 1. Every request gets a reply and never raises an
   exception; anything else gets none.
2. A repeated request is answered with the earlier reply if it changes something and is the newest
   with its session number (for number 0, with which MAVSDK always begins: the client's newest).
   Other requests are done again, which gives the same or a newer result. More is not remembered,
   because a client that starts anew counts from 0 again.
3. A written file replaces the old one when its session is complete; until then the old one stays.
4. A burst has at most sixteen replies, and the last one is marked; the client requests the next
   burst. So an answer has at most 4 KiB.

MAVSDK 4.1 first sends ListDirectoryWithTime (16); when that is refused it uses ListDirectory (3).
Source: https://mavlink.io/en/services/ftp.html; clients' differences: MAVSDK 4.1, pymavlink.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
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
    nak,
    read_request,
)

BURST = 16
REPEAT_S = 10.0
MAX_REMEMBERED = 64  # replies

log = logging.getLogger(__name__)

_CHANGING = frozenset(
    {
        Opcode.TERMINATE_SESSION,
        Opcode.OPEN_FILE_RO,
        Opcode.CREATE_FILE,
        Opcode.REMOVE_FILE,
        Opcode.CREATE_DIRECTORY,
        Opcode.REMOVE_DIRECTORY,
        Opcode.OPEN_FILE_WO,
        Opcode.TRUNCATE_FILE,
        Opcode.RENAME,
    }
)


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
class _Asked:
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


class FtpServer:
    """Answers the requests of any number of clients.

    Args:
        store: the files.

    Attributes:
        stored: paths of the files with new content, in order; the caller clears it.
    """

    def __init__(self, store: Store) -> None:
        self.stored: list[str] = []
        self._store = store
        self._sessions = Sessions()
        self._newest: dict[tuple[Client, int], tuple[float, bytes, list[bytes]]] = {}

    def receive(self, now_s: float, client: Client, payload: bytes) -> list[bytes]:
        """Does what a client requests and returns the replies.

        Args:
            client: its system and component id.
            payload: of its FILE_TRANSFER_PROTOCOL message.

        Returns:
            Payloads for the client, 251 bytes each.
        """
        request = read_request(payload)
        if request is None:
            return []
        self._sessions.expire(now_s)
        session = (client, request.session)
        asked_s, asked, replies = self._newest.get(session, (0.0, b"", []))
        if asked == payload and now_s - asked_s <= REPEAT_S:
            return replies
        try:
            replies = self._do(_Asked(now_s, client, request))
        except FtpRefusal as refusal:
            log.debug("refused request %d of %d/%d: %s", request.opcode, *client, refusal.nak.name)
            replies = [nak(request, refusal)]
        self._newest.pop(session, None)
        self._newest.pop((client, 0), None)
        if request.opcode in _CHANGING:
            self._newest[session] = (now_s, payload, replies)
            if len(self._newest) > MAX_REMEMBERED:
                del self._newest[next(iter(self._newest))]
        return replies

    def _do(self, asked: _Asked) -> list[bytes]:
        if asked.request.size > DATA_BYTES:
            raise FtpRefusal(Nak.INVALID_DATA_SIZE)
        service = _SERVICES.get(asked.request.opcode)
        if service is None:
            raise FtpRefusal(Nak.UNKNOWN_COMMAND)
        return service(self, asked)

    def _session(self, asked: _Asked) -> Session:
        return self._sessions.find(asked.now_s, asked.client, asked.request.session)

    # -- services ------------------------------------------------------------------------------

    def _none(self, asked: _Asked) -> list[bytes]:
        return [ack(asked.request)]

    def _terminate(self, asked: _Asked) -> list[bytes]:
        session = self._session(asked)
        event = SessionEvent.TERMINATED if session.is_whole else SessionEvent.TERMINATED_WITH_GAPS
        state = self._sessions.advance(asked.client, session, event)
        if state is SessionState.DROPPED:
            raise FtpRefusal(Nak.FAIL)
        if state is SessionState.COMPLETE:
            self._store.write(session.path, bytes(session.content))
            log.debug("%d/%d wrote %s, %d bytes", *asked.client, session.path, len(session.content))
            self.stored.append(session.path)
        return [ack(asked.request)]

    def _reset(self, asked: _Asked) -> list[bytes]:
        self._sessions.reset(asked.client)
        return [ack(asked.request)]

    def _list(self, asked: _Asked) -> list[bytes]:
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

    def _open_to_read(self, asked: _Asked) -> list[bytes]:
        content = self._store.read(asked.path())
        return self._open(asked, content, SessionEvent.OPENED_TO_READ)

    def _create(self, asked: _Asked) -> list[bytes]:
        self._store.check_writable(asked.path())
        return self._open(asked, b"", SessionEvent.OPENED_TO_WRITE)

    def _open_to_write(self, asked: _Asked) -> list[bytes]:
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

    def _open(self, asked: _Asked, content: bytes, event: SessionEvent) -> list[bytes]:
        session = self._sessions.open(
            asked.now_s, asked.client, asked.request.session, asked.path(), content, event
        )
        size = len(content).to_bytes(4, "little")
        return [ack(asked.request, size, session=session.number)]

    def _read(self, asked: _Asked) -> list[bytes]:
        session = self._session(asked)
        data = _part(session, asked.request.offset, asked.request.size)
        self._sessions.advance(asked.client, session, SessionEvent.READ)
        return [ack(asked.request, data)]

    def _burst(self, asked: _Asked) -> list[bytes]:
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

    def _write(self, asked: _Asked) -> list[bytes]:
        session, request = self._session(asked), asked.request
        try:
            session.write(request.offset, request.data)
        except FtpRefusal:
            self._sessions.advance(asked.client, session, SessionEvent.WRITE_REFUSED)
            raise
        self._sessions.advance(asked.client, session, SessionEvent.WRITTEN)
        return [ack(request)]

    def _truncate(self, asked: _Asked) -> list[bytes]:
        path = asked.path()
        content = self._store.read(path)
        if asked.request.offset > len(content):
            raise FtpRefusal(Nak.INVALID_DATA_SIZE)
        self._store.write(path, content[: asked.request.offset])
        self.stored.append(path)
        return [ack(asked.request)]

    def _remove(self, asked: _Asked) -> list[bytes]:
        self._store.remove(asked.path())
        return [ack(asked.request)]

    def _make_folder(self, asked: _Asked) -> list[bytes]:
        self._store.make_folder(asked.path())
        return [ack(asked.request)]

    def _remove_folder(self, asked: _Asked) -> list[bytes]:
        self._store.remove_folder(asked.path())
        return [ack(asked.request)]

    def _rename(self, asked: _Asked) -> list[bytes]:
        texts = asked.request.texts()
        if len(texts) != 2:
            raise FtpRefusal(Nak.FAIL)
        old, new = texts
        self._store.rename(old, new)
        self.stored.append(new)
        return [ack(asked.request)]

    def _crc32(self, asked: _Asked) -> list[bytes]:
        return [ack(asked.request, crc32(self._store.read(asked.path())).to_bytes(4, "little"))]


def _part(session: Session, offset: int, size: int) -> bytes:
    """Returns `size` bytes of an open file, at most as many as fit into a reply.

    Raises:
        FtpRefusal: the file ends before the offset.
    """
    if offset >= len(session.content):
        raise FtpRefusal(Nak.EOF)
    return bytes(session.content[offset : offset + (size or DATA_BYTES)])


_SERVICES: dict[int, Callable[[FtpServer, _Asked], list[bytes]]] = {
    Opcode.NONE: FtpServer._none,
    Opcode.TERMINATE_SESSION: FtpServer._terminate,
    Opcode.RESET_SESSIONS: FtpServer._reset,
    Opcode.LIST_DIRECTORY: FtpServer._list,
    Opcode.OPEN_FILE_RO: FtpServer._open_to_read,
    Opcode.READ_FILE: FtpServer._read,
    Opcode.CREATE_FILE: FtpServer._create,
    Opcode.WRITE_FILE: FtpServer._write,
    Opcode.REMOVE_FILE: FtpServer._remove,
    Opcode.CREATE_DIRECTORY: FtpServer._make_folder,
    Opcode.REMOVE_DIRECTORY: FtpServer._remove_folder,
    Opcode.OPEN_FILE_WO: FtpServer._open_to_write,
    Opcode.TRUNCATE_FILE: FtpServer._truncate,
    Opcode.RENAME: FtpServer._rename,
    Opcode.CALC_FILE_CRC32: FtpServer._crc32,
    Opcode.BURST_READ_FILE: FtpServer._burst,
}
