"""Several mistakes of one file, told at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from companion.documents.diagnostics import MOST
from companion.errors import Location, MissionError

T = TypeVar("T")


class MistakeGathering:
    """Reads parts of a file that do not need each other, and tells what is wrong with all of them.

    >>> gathering = MistakeGathering()
    >>> gathering.read(lambda: 1)
    1
    >>> gathering.tell()
    """

    def __init__(self) -> None:
        self._found: list[MissionError] = []

    def read(self, part: Callable[[], T]) -> T | None:
        """What reading a part gives; None where it cannot be used."""
        try:
            return part()
        except MissionError as error:
            self._found += error.each
            return None

    def tell(self) -> None:
        """Raises what was found, in the order of the file; the first mistakes of many."""
        if self._found:
            first, *others = sorted(self._found, key=_line)[:MOST]
            raise first.beside(others) if others else first


def _line(error: MissionError) -> int:
    return error.where.line if isinstance(error.where, Location) else 0
