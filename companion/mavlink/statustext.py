"""Splits a text of any length into STATUSTEXT messages of 50 bytes.

The chunks of a text have a common id and are numbered from 0; a chunk of less than 50 bytes ends
the text. A text that fits into one message has id 0
(https://mavlink.io/en/messages/common.html#STATUSTEXT).
"""

from __future__ import annotations

from companion.mavlink.framing import Message, dialect

CHUNK_BYTES = 50


def chunks(severity: int, text: str, number: int) -> list[Message]:
    """Returns the messages of a text.

    Args:
        severity: MAV_SEVERITY.
        text: any; a character may be split between chunks, the receiver joins it.
        number: counts the texts of a component, from 1; only long texts carry it.

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
