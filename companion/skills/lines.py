"""Messages between the companion and a function's process: lines of JSON, of bounded length."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

MAX_LINE = 1 << 15


class Malformed(ValueError):
    """What came is no message."""


def line_of(message: Mapping[str, Any]) -> bytes:
    r"""A message as a line.

    >>> line_of({"is": "ready"})
    b'{"is": "ready"}\n'

    Raises:
        Malformed: it is too long.
    """
    line = json.dumps(message).encode() + b"\n"
    if len(line) > MAX_LINE:
        raise Malformed(f"a message of {len(line)} bytes")
    return line


class LineReader:
    r"""Messages from the parts in which they arrive.

    >>> reader = LineReader()
    >>> reader.take(b'{"is": "re'), reader.take(b'ady"}\n')
    ([], [{'is': 'ready'}])
    """

    def __init__(self) -> None:
        self._rest = b""

    def take(self, part: bytes) -> list[dict[str, Any]]:
        """The messages that end in a part.

        Raises:
            Malformed: one is too long, or no object of JSON.
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
