"""The MAVLink FTP server, without I/O: payloads of requests in, payloads of replies out.

`ftp_services.py` does what is requested; this module sees to it that it is done once. Rules:
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

from companion.ground.ftp_services import FtpCall, FtpServices, Store
from companion.ground.ftp_sessions import Client, Sessions
from companion.mavlink.ftp_frames import FtpRefusal, Opcode, nak, read_request

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


class FtpServer:
    """Answers the requests of any number of clients.

    Args:
        store: the files.
    """

    def __init__(self, store: Store) -> None:
        self._sessions = Sessions()
        self._services = FtpServices(store, self._sessions)
        self._newest: dict[tuple[Client, int], tuple[float, bytes, list[bytes]]] = {}

    def take_stored(self) -> list[str]:
        """Returns the paths of the files with new content since the last call, in order."""
        return self._services.take_stored()

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
            replies = self._services.do(FtpCall(now_s, client, request))
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
