"""One reading of a file, which reports several mistakes at once and knows what is unread.

A file is read in stages: keys and values, names, places, events, skills, the task. A mistake in one
stage does not end the reading. What it makes useless is remembered as unread, by its keys. Later
checks that need it are skipped, because they would report the same mistake in other words.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import ParamSpec, TypeVar

from companion.documents.diagnostics import NO_NAME
from companion.errors import FormulaError, Keys, Location, MissionError

MOST = 10
"""Most mistakes that are reported at once."""

P = ParamSpec("P")
T = TypeVar("T")


class DocumentReading:
    """Reads the parts of a file, and reports the mistakes of all.

    >>> reading = DocumentReading(unread=[("limits", "speed_mps")])
    >>> reading.read(("places",), int, "1"), reading.read(("limits",), int, "2")
    (1, None)
    >>> reading.knows("limits"), reading.is_whole("limits")
    (True, False)
    >>> reading.tell()

    Args:
        found: mistakes that are known already.
        unread: keys of what they have made useless.
    """

    def __init__(self, found: Iterable[MissionError] = (), unread: Iterable[Keys] = ()) -> None:
        self._found = list(found)
        self._unread = set(unread)

    def read(self, keys: Keys, part: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | None:
        """The result of reading a part; None if it has a mistake, or if something in it is unread.

        Args:
            keys: the keys of the part.
            part: reads it, from the arguments that follow.
        """
        if not self.is_whole(*keys):
            return None
        try:
            return part(*args, **kwargs)
        except MissionError as error:
            self._found += error.each
            self._unread.add(keys)
            return None

    def check(self, check: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | None:
        """The result of a check of which nothing else depends; None if it finds a mistake."""
        try:
            return check(*args, **kwargs)
        except MissionError as error:
            self._found += error.each
            return None

    def knows(self, *keys: str | int) -> bool:
        """Whether a part has all its keys; their values may be unread."""
        is_around = any(keys[: len(other)] == other for other in self._unread)
        return not is_around and (*keys, NO_NAME) not in self._unread

    def is_whole(self, *keys: str | int) -> bool:
        """Whether nothing of a part is unread."""
        inside = any(other[: len(keys)] == keys for other in self._unread)
        return self.knows(*keys) and not inside

    def tell(self) -> None:
        """Raises the mistakes in the order of the file; if there are many, the first ones."""
        found = sorted(self._found, key=_place)
        if len(found) > MOST:
            more = MissionError(f"and {len(found) - MOST} more mistakes")
            found = [*found[:MOST], more]
        if found:
            first, *others = _without_repeats(found)
            raise first.beside(others) if others else first


def _place(error: MissionError) -> tuple[int, int]:
    where = error.where
    return (where.line, where.column) if isinstance(where, Location) else (0, 0)


def _without_repeats(found: list[MissionError]) -> list[MissionError]:
    """The same mistakes, with each hint only once."""
    told: set[str] = set()
    kept = []
    for each in found:
        is_repeated = each.hint in told and not isinstance(each, FormulaError)
        kept.append(MissionError(each.what, each.where) if is_repeated else each)
        told.add(each.hint)
    return kept
