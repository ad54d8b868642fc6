"""Messages between the companion and a function's process: lines of JSON of limited length."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

MAX_LINE = 1 << 15


class Malformed(ValueError):
    """What was received is no message."""


def line_of(message: Mapping[str, Any]) -> bytes:
    r"""A message as a line.

    >>> line_of({"is": "ready"})
    b'{"is": "ready"}\n'

    Raises:
        Malformed: the message is too long.
    """
    line = json.dumps(message).encode() + b"\n"
    if len(line) > MAX_LINE:
        raise Malformed(f"a message of {len(line)} bytes")
    return line


class LineReader:
    r"""Assembles messages from the parts in which they arrive.

    >>> reader = LineReader()
    >>> reader.take(b'{"is": "re'), reader.take(b'ady"}\n')
    ([], [{'is': 'ready'}])
    """

    def __init__(self) -> None:
        self._rest = b""

    def take(self, part: bytes) -> list[dict[str, Any]]:
        """The messages that are completed by a part.

        Raises:
            Malformed: a message is too long, or no JSON object.
        """
        *lines, self._rest = (self._rest + part).split(b"\n")
        if any(len(line) > MAX_LINE for line in (*lines, self._rest)):
            raise Malformed
        return [_message(line) for line in lines]


def _message(line: bytes) -> dict[str, Any]:
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise Malformed from error
    if not isinstance(message, dict):
        raise Malformed
    return message
