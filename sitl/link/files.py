"""The autopilot's files over MAVLink FTP, read-only: open, read, burst, close.

As in PX4, one file can be open at a time on a link, and one that nobody reads for RESTING_S is
closed. All other requests are refused with FileNotFound.

Source: https://mavlink.io/en/services/ftp.html.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.ftp_frames import (
    DATA_BYTES,
    FtpRefusal,
    FtpRequest,
    Nak,
    Opcode,
    ack,
    nak,
    read_request,
)

RESTING_S = 10.0
SESSION = 0


class FileServer:
    """The files on one link.

    Args:
        files: by path.
    """

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self._files = files
        self._open: bytes | None = None
        self._asked_s = -math.inf

    def answers(self, now_s: float, message: Message) -> list[Message]:
        """The answers to a FILE_TRANSFER_PROTOCOL message; none if it is no request."""
        request = read_request(bytes(message.payload))
        if request is None:
            return []
        if now_s - self._asked_s > RESTING_S:
            self._open = None
        self._asked_s = now_s
        try:
            payloads = self._do(request)
        except FtpRefusal as refusal:
            payloads = [nak(request, refusal)]
        reply = dialect.MAVLink_file_transfer_protocol_message
        return [reply(0, *source(message), list(payload)) for payload in payloads]

    def _do(self, request: FtpRequest) -> list[bytes]:
        match request.opcode:
            case Opcode.OPEN_FILE_RO:
                return [self._open_file(request)]
            case Opcode.READ_FILE:
                data = self._part(request, request.offset)
                return [ack(request, data[: request.size])]
            case Opcode.BURST_READ_FILE:
                return self._burst(request)
            case Opcode.TERMINATE_SESSION | Opcode.RESET_SESSIONS:
                self._open = None
                return [ack(request)]
        raise FtpRefusal(Nak.FILE_NOT_FOUND)

    def _open_file(self, request: FtpRequest) -> bytes:
        path = request.texts()[0]
        if path.lstrip("/") not in self._files:
            raise FtpRefusal(Nak.FILE_NOT_FOUND)
        content = self._files[path.lstrip("/")]
        if self._open not in (None, content):
            raise FtpRefusal(Nak.NO_SESSIONS_AVAILABLE)
        self._open = content
        return ack(request, len(content).to_bytes(4, "little"), session=SESSION)

    def _part(self, request: FtpRequest, offset: int) -> bytes:
        if self._open is None or request.session != SESSION:
            raise FtpRefusal(Nak.INVALID_SESSION)
        if offset >= len(self._open):
            raise FtpRefusal(Nak.EOF)
        return self._open[offset : offset + DATA_BYTES]

    def _burst(self, request: FtpRequest) -> list[bytes]:
        """All parts that follow; the last one marks the end of the burst."""
        self._part(request, request.offset)
        offsets = range(request.offset, len(self._open or b""), DATA_BYTES)
        return [
            ack(
                request,
                self._part(request, at),
                offset=at,
                nth=nth,
                ends_burst=nth == len(offsets) - 1,
            )
            for nth, at in enumerate(offsets)
        ]
