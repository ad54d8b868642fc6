"""A text of any length as STATUSTEXT messages of 50 bytes.

Its chunks have a common id and are numbered from 0; one of less than 50 bytes ends the text. A text
that fits into one message has id 0 (https://mavlink.io/en/messages/common.html#STATUSTEXT).
"""

from __future__ import annotations

from companion.mavlink.framing import Message, dialect

CHUNK_BYTES = 50


def chunks(severity: int, text: str, number: int) -> list[Message]:
    """Returns the messages of a text.

    Args:
        severity: MAV_SEVERITY.
        text: any; what ends in the middle of a character is put together by the receiver.
        number: counts the texts of a component, from 1; only long ones carry it.

    >>> [m.chunk_seq for m in chunks(6, "x" * 100, 7)]
    [0, 1, 2]
    """
    raw = text.encode()
    if len(raw) <= CHUNK_BYTES:
        return [dialect.MAVLink_statustext_message(severity, raw)]
    common = (number - 1) % 0xFFFF + 1
    return [
        dialect.MAVLink_statustext_message(
            severity, raw[start : start + CHUNK_BYTES], common, start // CHUNK_BYTES
        )
        for start in range(0, len(raw) + 1, CHUNK_BYTES)
    ]
