"""MAVLink FTP for a component without files: refuses each request at once with FileNotFound.

Clients try FTP first for parameters and metadata, and wait for seconds if nobody answers.

Source: https://mavlink.io/en/services/ftp.html.
"""

from __future__ import annotations

from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.ftp_frames import FtpRefusal, Nak, nak, read_request


def refusal(message: Message) -> Message | None:
    """Returns the answer to a FILE_TRANSFER_PROTOCOL message; None if it is not a request."""
    request = read_request(bytes(message.payload))
    if request is None:
        return None
    payload = nak(request, FtpRefusal(Nak.FILE_NOT_FOUND))
    return dialect.MAVLink_file_transfer_protocol_message(0, *source(message), list(payload))
