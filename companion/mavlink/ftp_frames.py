"""Packs and reads requests and replies of MAVLink FTP, the payload of FILE_TRANSFER_PROTOCOL.

A payload is a header of twelve bytes and up to 239 bytes of data, padded with zeros to 251. Nothing
here keeps state. Source: https://mavlink.io/en/services/ftp.html.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum

_HEADER = struct.Struct("<HBBBBBxI")  # sequence, session, opcode, size, request, burst, offset
PAYLOAD_BYTES = 251
DATA_BYTES = PAYLOAD_BYTES - _HEADER.size
ACK, NAK = 128, 129


class Opcode(IntEnum):
    """MAV_FTP_OPCODE of a request; those above 127 are replies."""

    NONE = 0
    TERMINATE_SESSION = 1
    RESET_SESSIONS = 2
    LIST_DIRECTORY = 3
    OPEN_FILE_RO = 4
    READ_FILE = 5
    CREATE_FILE = 6
    WRITE_FILE = 7
    REMOVE_FILE = 8
    CREATE_DIRECTORY = 9
    REMOVE_DIRECTORY = 10
    OPEN_FILE_WO = 11
    TRUNCATE_FILE = 12
    RENAME = 13
    CALC_FILE_CRC32 = 14
    BURST_READ_FILE = 15


class Nak(IntEnum):
    """MAV_FTP_ERR: why a request is refused."""

    FAIL = 1
    FAIL_ERRNO = 2
    INVALID_DATA_SIZE = 3
    INVALID_SESSION = 4
    NO_SESSIONS_AVAILABLE = 5
    EOF = 6
    UNKNOWN_COMMAND = 7
    FILE_EXISTS = 8
    FILE_PROTECTED = 9
    FILE_NOT_FOUND = 10


class FtpRefusal(Exception):
    """A request is refused.

    Args:
        nak: the protocol's reason.
        errno: the system's reason; only with FAIL_ERRNO.
    """

    def __init__(self, nak: Nak, errno: int = 0) -> None:
        super().__init__(nak.name)
        self.nak = nak
        self.errno = errno


@dataclass(frozen=True, slots=True)
class FtpRequest:
    """A client's request.

    Attributes:
        size: of the data; for reads and bursts, the number of bytes requested.
        data: as many bytes as `size` says, at most 239.
    """

    sequence: int
    session: int
    opcode: int
    size: int
    offset: int
    data: bytes

    def texts(self) -> tuple[str, ...]:
        """Returns the data as texts, separated by NUL; a final NUL is optional.

        Raises:
            FtpRefusal: it is not UTF-8.
        """
        raw = self.data.removesuffix(b"\0")
        try:
            return tuple(part.decode() for part in raw.split(b"\0"))
        except UnicodeDecodeError:
            raise FtpRefusal(Nak.FAIL) from None


def read_request(payload: bytes) -> FtpRequest | None:
    """Returns the request in a payload; None for a reply, or for less than a header."""
    if len(payload) < _HEADER.size:
        return None
    sequence, session, opcode, size, _, _, offset = _HEADER.unpack_from(payload)
    if opcode >= ACK:
        return None
    data = payload[_HEADER.size : _HEADER.size + size].ljust(min(size, DATA_BYTES), b"\0")
    return FtpRequest(sequence, session, opcode, size, offset, data)


@dataclass(frozen=True, slots=True)
class FtpReply:
    """A server's reply.

    Attributes:
        sequence: that of the request + 1.
        opcode: that of the request.
        is_ack: whether the request was done.
        data: the answer; for a NAK, its reason.
    """

    sequence: int
    session: int
    opcode: int
    is_ack: bool
    offset: int
    data: bytes


def read_reply(payload: bytes) -> FtpReply | None:
    """Returns the reply in a payload; None for a request, or for less than a header."""
    if len(payload) < _HEADER.size:
        return None
    sequence, session, opcode, size, asked, _, offset = _HEADER.unpack_from(payload)
    if opcode not in (ACK, NAK) or size > DATA_BYTES:
        return None
    data = payload[_HEADER.size : _HEADER.size + size].ljust(size, b"\0")
    return FtpReply(sequence, session, asked, opcode == ACK, offset, data)


def ask(request: FtpRequest) -> bytes:
    """Returns the payload of a request."""
    header = _HEADER.pack(
        request.sequence, request.session, request.opcode, request.size, 0, 0, request.offset
    )
    return (header + request.data).ljust(PAYLOAD_BYTES, b"\0")


def ack(
    request: FtpRequest,
    data: bytes = b"",
    *,
    session: int | None = None,
    offset: int | None = None,
    nth: int = 0,
    ends_burst: bool = False,
) -> bytes:
    """Returns the payload of a positive reply (ACK).

    Args:
        request: the request that it answers.
        data: at most 239 bytes.
        session: if it differs from the request's.
        offset: of the data in the file, if it differs from the request's.
        nth: number of the reply in a burst, from 0.
        ends_burst: no further replies follow without a request.
    """
    header = _HEADER.pack(
        (request.sequence + 1 + nth) % 65536,
        request.session if session is None else session,
        ACK,
        len(data),
        request.opcode,
        ends_burst,
        request.offset if offset is None else offset,
    )
    return (header + data).ljust(PAYLOAD_BYTES, b"\0")


def nak(request: FtpRequest, refusal: FtpRefusal) -> bytes:
    """Returns the payload of a negative reply (NAK)."""
    reason = bytes([refusal.nak])
    if refusal.nak is Nak.FAIL_ERRNO:
        reason += bytes([refusal.errno])
    header = _HEADER.pack(
        (request.sequence + 1) % 65536,
        request.session,
        NAK,
        len(reason),
        request.opcode,
        False,
        request.offset,
    )
    return (header + reason).ljust(PAYLOAD_BYTES, b"\0")


def crc32(content: bytes) -> int:
    """Returns the protocol's checksum: the usual polynomial, from 0, without the final inversion.

    >>> hex(crc32(b"123456789"))
    '0x2dfd2d88'
    """
    return zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF
