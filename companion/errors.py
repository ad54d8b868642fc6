"""All errors, as a tree of exceptions with one exit code each.

    CompanionError            exit 1, anything of ours
    +- MissionError           exit 2, a file from outside is wrong: file:line:column
    |  +- FormulaError        with a caret under the offending token
    +- RequestError           exit 2, the request is impossible, whatever the files say
    +- LibraryMissing         exit 2, something is not installed; with the line that installs it
    +- NoPlanError            exit 3, the task has no plan, and why
    +- LinkError              exit 4, no vehicle to talk to
    |  +- LinkTimeout
    |  +- AddressError        exit 2, an invalid address
    +- Aborted                exit 5, the pilot or a failsafe ended the flight
    +- TaskViolated           exit 6, a judged flight does not satisfy its task
    +- SearchLimit            exit 7, a search was given up: there may be a plan or not

A message has three parts: what happened, where, what to do. Expected outcomes (a failed skill, a
blocked route) are values and never exceptions. Only `cli/` turns errors into exit codes.

A message quotes external text and is shown on terminals, so no error has control characters.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")


def printable(text: str) -> str:
    r"""A text with escaped control characters, which a terminal does not obey; tabs and newlines
    stay.

    >>> print(printable("a\x1b[2Jb"))
    a\x1b[2Jb
    """
    return _CONTROL.sub(lambda found: f"\\x{ord(found[0]):02x}", text)


class CompanionError(Exception):
    """Anything this program reports about itself or its input.

    Args:
        text: the message for people.
    """

    exit_code = 1

    def __init__(self, text: str) -> None:
        super().__init__(printable(text))


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a file; line and column count from 1."""

    path: str
    line: int
    column: int

    @property
    def inside(self) -> str:
        """The place for a reader who knows the file."""
        return f"line {self.line}"

    def __str__(self) -> str:
        return f"{self.path}:{self.line}:{self.column}"


Keys = tuple[str | int, ...]
"""The keys and indices that lead to a value in data."""


@dataclass(frozen=True, slots=True)
class KeyPath:
    """A place in data that was given as Python values: the keys and indices that lead there.

    >>> str(KeyPath(("places", "A", "east_m"))), str(KeyPath(("initially", 0)))
    ('places.A.east_m', 'initially[0]')
    """

    keys: Keys

    @property
    def inside(self) -> str:
        """The place for a reader who knows the data."""
        return str(self)

    def __str__(self) -> str:
        steps = (f"[{key}]" if isinstance(key, int) else f".{key}" for key in self.keys)
        return "".join(steps).removeprefix(".") or "top level"


class MissionError(CompanionError):
    """A mission, map or scenario cannot be used.

    Args:
        what: what is wrong, in one line.
        where: the place in the file, or in the data, if known.
        hint: what to do about it; may have several lines.
        others: further mistakes in the same file, reported after it.
    """

    exit_code = 2

    def __init__(
        self,
        what: str,
        where: Location | KeyPath | None = None,
        hint: str = "",
        others: Sequence[MissionError] = (),
    ) -> None:
        self.what = what
        self.where = where
        self.hint = hint
        self._others = tuple(others)
        head = f"{where}: {what}" if where else what
        advice = [f"    {line}" for line in printable(hint).splitlines()]
        super().__init__("\n".join([head, *advice, *map(str, others)]))

    @property
    def each(self) -> list[MissionError]:
        """This error alone, then the others."""
        return [self.beside(()) if self._others else self, *self._others]

    def beside(self, others: Sequence[MissionError]) -> MissionError:
        """The same error with further mistakes."""
        return MissionError(self.what, self.where, self.hint, others)


_SHOWN = 80  # characters of a long formula that are shown before and after the offending token


class FormulaError(MissionError):
    """A formula cannot be read; shows the text with a caret under the offending token.

    Args:
        what: what is wrong, in one line.
        text: the formula as it was given.
        offset: index into `text` of the offending token.
        length: characters to underline.
        hint: what was expected, or which name was probably meant.
        where: the place of the token in a file or in data, once the caller knows it.
        others: further mistakes, as in MissionError.
    """

    def __init__(
        self,
        what: str,
        text: str,
        offset: int,
        length: int = 1,
        hint: str = "",
        where: Location | KeyPath | None = None,
        others: Sequence[MissionError] = (),
    ) -> None:
        self.text = text
        self.offset = offset
        self.length = length
        self.advice = hint
        start = text.rfind("\n", 0, offset) + 1
        end = text.find("\n", offset)
        line = text[start:end] if end >= 0 else text[start:]
        at, width = offset - start, max(1, min(length, _SHOWN))
        if len(line) > 2 * _SHOWN:  # show an excerpt
            first = max(0, at - _SHOWN)
            before, after = "... " * (first > 0), " ..." * (at + _SHOWN < len(line))
            line = before + line[first : at + _SHOWN] + after
            at += len(before) - first
        shown, token = printable(line[:at]), line[at : at + width]
        at, line = len(shown), printable(line)
        width += len(printable(token)) - len(token)
        caret = " " * at + "^" * width
        shown = "\n".join(filter(None, [line, f"{caret}  {hint}".rstrip()]))
        super().__init__(what, where, shown, others)

    def beside(self, others: Sequence[MissionError]) -> FormulaError:
        """The same error with further mistakes."""
        return self._with(self.where, others)

    def located(self, where: Location | KeyPath) -> FormulaError:
        """The same error, placed in a file."""
        return self._with(where, ())

    def _with(
        self, where: Location | KeyPath | None, others: Sequence[MissionError]
    ) -> FormulaError:
        return FormulaError(
            self.what,
            self.text,
            offset=self.offset,
            length=self.length,
            hint=self.advice,
            where=where,
            others=others,
        )


class RequestError(CompanionError):
    """A command line or a call asks for something impossible: conflicting options, an invalid key,
    or the continuation of another mission.
    """

    exit_code = 2


class LibraryMissing(CompanionError):
    """A required library is not installed.

    Args:
        what: what was asked for, and what it needs.
        remedy: the line that installs it, or other advice.
    """

    exit_code = 2

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(f"{what}\n    {remedy}")


class NoPlanError(CompanionError):
    """The task has no plan from the present state; the message says why."""

    exit_code = 3


class LinkError(CompanionError):
    """The link to the vehicle cannot be opened, or was lost."""

    exit_code = 4


class LinkTimeout(LinkError):
    """Nothing usable was heard in time."""


class AddressError(LinkError):
    """An invalid address of a vehicle or of reports; the message shows the valid forms."""

    exit_code = 2


class Aborted(CompanionError):
    """The pilot took over, or a failsafe of the autopilot ended the mission."""

    exit_code = 5


class Collided(Aborted):
    """The simulated vehicle has hit something, whatever its companion reports.

    Args:
        ending: how the flight ended for its companion, unless it was a success.
    """

    def __init__(self, ending: str = "") -> None:
        hit = "the simulated vehicle has hit a wall, an obstacle or the ground"
        super().__init__(f"{hit}; its flight had ended: {ending}" if ending else hit)


class TaskViolated(CompanionError):
    """A recorded flight does not satisfy its task, or flights of a campaign fail."""

    exit_code = 6


class SearchLimit(CompanionError):
    """A search was given up at a limit of its effort; it is unknown whether there is a plan.

    Args:
        limit: the limit that was reached, with its number.
        advice: what to do.

    >>> print(SearchLimit("80,000 edges of the product"))
    the search was given up at its limit of 80,000 edges of the product; there may be a plan
        simplify the task, or ask another planner: companion plan --engine fast-downward
    """

    exit_code = 7

    def __init__(
        self,
        limit: str,
        advice: str = "simplify the task, or ask another planner: companion plan --engine "
        "fast-downward",
    ) -> None:
        self.limit = limit
        super().__init__(
            f"the search was given up at its limit of {limit}; there may be a plan\n    {advice}"
        )
