"""The lines of a file that is only appended to, each a JSON object; its end may be torn."""

from __future__ import annotations

import json


def whole_lines(data: bytes) -> tuple[list[bytes], bytes]:
    """The lines that have their end, with it; and the rest, which may be torn.

    >>> whole_lines(b'{"a": 1}\\n{"b"')
    ([b'{"a": 1}\\n'], b'{"b"')
    """
    *whole, rest = data.split(b"\n")
    return [line + b"\n" for line in whole], rest


def is_object(line: bytes) -> bool:
    """Whether a line is a JSON object.

    >>> is_object(b'{"a": 1}'), is_object(b'{"a": '), is_object(b"1")
    (True, False, False)
    """
    try:
        return isinstance(json.loads(line), dict)
    except (ValueError, RecursionError):
        return False
