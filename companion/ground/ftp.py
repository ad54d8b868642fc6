"""What does the companion answer to MAVLink FTP? A server without I/O: payloads in, payloads out.

The files are behind the `Store`. Rules:
1. A reply has the request's sequence number + 1. What is no request gets no reply; any request
   gets one, and never an exception.
2. A repeated request is answered by the reply that was lost, if it changes something and is the
   newest with its session number (for number 0, which MAVSDK always begins with, the client's
   newest). Others are done again, which gives the same or newer. More is not remembered, because
   a client that starts anew counts from 0 again.
3. What is written becomes the file when its session ends (`ftp_sessions.py`), if no byte is
   missing; until then the old file is there. A write that is refused ends the session.
4. A burst is at most sixteen replies, of which the last says so; the client asks for the next
   one. So an answer has at most 4 KiB.

MAVSDK 4.1 asks with ListDirectoryWithTime (16) first and takes the refusal for "ask with 3".
Source: https://mavlink.io/en/services/ftp.html; clients' differences: MAVSDK 4.1, pymavlink.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from companion.ground.ftp_sessions import Client, Session, Sessions
from companion.mavlink.ftp_frames import (
    DATA_BYTES,
    Nak,
    Opcode,
    Refusal,
    Request,
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
    """Files and folders below one root. Every method may raise `Refusal`."""

    def entries(self, path: str) -> list[str]:
        """What is in a folder, as the protocol lists it: Dname, or Fname, a tab and the size."""

    def read(self, path: str) -> bytes:
        """What is in a file."""

    def check_writable(self, path: str) -> None:
        """Raises if no file can be written there."""

    def write(self, path: str, content: bytes) -> None:
        """Makes or replaces a file at once; it is never seen half."""

    def remove(self, path: str) -> None:
        """Removes a file."""

    def make_folder(self, path: str) -> None:
        """Makes a folder in one that exists."""

    def remove_folder(self, path: str) -> None:
        """Removes an empty folder."""

    def rename(self, old: str, new: str) -> None:
        """Gives a file or folder another name; replaces nothing."""


@dataclass(frozen=True, slots=True)
class _Asked:
    """Who asks what, and when."""

    now_s: float
    client: Client
    request: Request

    def path(self) -> str:
        """The one path in the request."""
        texts = self.request.texts()
        if len(texts) != 1:
            raise Refusal(Nak.FAIL)
        return texts[0]


class FtpServer:
    """Answers requests of any number of clients.

    Args:
        store: the files.

    Attributes:
        stored: paths of the files that have got new content, in order; for the caller to clear.
    """

    def __init__(self, store: Store) -> None:
        self.stored: list[str] = []
        self._store = store
        self._sessions = Sessions()
        self._newest: dict[tuple[Client, int], tuple[float, bytes, list[bytes]]] = {}

    def receive(self, now_s: float, client: Client, payload: bytes) -> list[bytes]:
        """Does what a client asks.

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
        except Refusal as refusal:
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
            raise Refusal(Nak.INVALID_DATA_SIZE)
        service = _SERVICES.get(asked.request.opcode)
        if service is None:
            raise Refusal(Nak.UNKNOWN_COMMAND)
        return service(self, asked)

    def _session(self, asked: _Asked) -> Session:
        return self._sessions.find(asked.now_s, asked.client, asked.request.session)

    # -- services ------------------------------------------------------------------------------

    def _none(self, asked: _Asked) -> list[bytes]:
        return [ack(asked.request)]

    def _terminate(self, asked: _Asked) -> list[bytes]:
        session = self._session(asked)
        self._sessions.end(asked.client, session.number)
        if session.is_writing:
            if not session.is_whole:
                raise Refusal(Nak.FAIL)
            self._store.write(session.path, bytes(session.content))
            log.debug("%d/%d wrote %s, %d bytes", *asked.client, session.path, len(session.content))
            self.stored.append(session.path)
        return [ack(asked.request)]

    def _reset(self, asked: _Asked) -> list[bytes]:
        self._sessions.end_all(asked.client)
        return [ack(asked.request)]

    def _list(self, asked: _Asked) -> list[bytes]:
        entries = self._store.entries(asked.path())[asked.request.offset :]
        if not entries:
            raise Refusal(Nak.EOF)
        listed = b""
        for entry in entries:
            line = entry.encode() + b"\0"
            if len(listed) + len(line) > DATA_BYTES:
                break
            listed += line
        return [ack(asked.request, listed)]

    def _open_to_read(self, asked: _Asked) -> list[bytes]:
        content = self._store.read(asked.path())
        return self._open(asked, content, is_writing=False)

    def _create(self, asked: _Asked) -> list[bytes]:
        self._store.check_writable(asked.path())
        return self._open(asked, b"", is_writing=True)

    def _open_to_write(self, asked: _Asked) -> list[bytes]:
        self._store.check_writable(asked.path())
        return self._open(asked, self._content_if_any(asked.path()), is_writing=True)

    def _content_if_any(self, path: str) -> bytes:
        try:
            return self._store.read(path)
        except Refusal as refusal:
            if refusal.nak is not Nak.FILE_NOT_FOUND:
                raise
            return b""

    def _open(self, asked: _Asked, content: bytes, is_writing: bool) -> list[bytes]:
        session = self._sessions.open(
            asked.now_s, asked.client, asked.request.session, asked.path(), content, is_writing
        )
        size = len(content).to_bytes(4, "little")
        return [ack(asked.request, size, session=session.number)]

    def _read(self, asked: _Asked) -> list[bytes]:
        data = self._part(asked, asked.request.offset)
        return [ack(asked.request, data)]

    def _burst(self, asked: _Asked) -> list[bytes]:
        replies: list[bytes] = []
        request, size = asked.request, len(self._session(asked).content)
        offset, step = request.offset, request.size or DATA_BYTES
        data = self._part(asked, offset)
        for nth in range(BURST):
            is_last = nth == BURST - 1 or offset + step >= size
            replies.append(ack(request, data, offset=offset, nth=nth, ends_burst=is_last))
            if is_last:
                break
            offset += step
            data = self._part(asked, offset)
        return replies

    def _part(self, asked: _Asked, offset: int) -> bytes:
        content = self._session(asked).content
        if offset >= len(content):
            raise Refusal(Nak.EOF)
        return bytes(content[offset : offset + (asked.request.size or DATA_BYTES)])

    def _write(self, asked: _Asked) -> list[bytes]:
        session, request = self._session(asked), asked.request
        try:
            if not session.is_writing:
                raise Refusal(Nak.FILE_PROTECTED)
            session.write(request.offset, request.data)
        except Refusal:
            self._sessions.end(asked.client, session.number)
            raise
        return [ack(request)]

    def _truncate(self, asked: _Asked) -> list[bytes]:
        path = asked.path()
        content = self._store.read(path)
        if asked.request.offset > len(content):
            raise Refusal(Nak.INVALID_DATA_SIZE)
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
            raise Refusal(Nak.FAIL)
        old, new = texts
        self._store.rename(old, new)
        self.stored.append(new)
        return [ack(asked.request)]

    def _crc32(self, asked: _Asked) -> list[bytes]:
        return [ack(asked.request, crc32(self._store.read(asked.path())).to_bytes(4, "little"))]


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
