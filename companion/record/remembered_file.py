"""A small file beside the run folders that stores something for later programs.

It is JSON, replaced atomically, and written only on the ground. An unreadable file counts as
missing; a file that cannot be written is reported and stops nothing.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

MOST_BYTES = 1 << 20

Value = TypeVar("Value")

log = logging.getLogger(__name__)


def remember(path: Path, value: Any) -> None:
    """Writes a value that JSON can represent."""
    new = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        new.write_text(json.dumps(value), encoding="utf-8")
        new.replace(path)
    except OSError as error:
        log.warning("%s is not written: %s", path, error)


def remembered(path: Path, read: Callable[[Any], list[Value]]) -> list[Value]:
    """The values in the file; empty if it cannot be read.

    Args:
        path: the path of the file.
        read: converts a JSON value; raises ValueError, TypeError or OverflowError if it cannot.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            return []
        return read(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError, OverflowError, RecursionError) as error:
        log.warning("%s is not read: %s", path, error)
        return []
