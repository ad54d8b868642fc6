"""What does a component without files answer to MAVLink FTP? That it has none.

Clients try FTP first for parameters and metadata, and wait for seconds where nobody answers. So
each request is refused at once with FileNotFound, and they go on without.

Source: https://mavlink.io/en/services/ftp.html.
"""

from __future__ import annotations

import struct

from companion.mavlink.framing import Message, dialect, source

_HEADER = struct.Struct("<HBBBBBxI")  # sequence, session, opcode, size, request, burst, offset
NAK, FILE_NOT_FOUND = 129, 10
PAYLOAD_BYTES = 251


def refusal(request: Message) -> Message:
    """The answer to a FILE_TRANSFER_PROTOCOL message."""
    raw = bytes(request.payload)[: _HEADER.size].ljust(_HEADER.size, b"\0")
    sequence, session, opcode, _, _, _, offset = _HEADER.unpack(raw)
    header = _HEADER.pack((sequence + 1) % 65536, session, NAK, 1, opcode, 0, offset)
    payload = (header + bytes([FILE_NOT_FOUND])).ljust(PAYLOAD_BYTES, b"\0")
    return dialect.MAVLink_file_transfer_protocol_message(0, *source(request), list(payload))
