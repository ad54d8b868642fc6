"""What does the events.jsonl of a run say of the task? Reads it back, for an audit.

Out come the task as it was flown (with the first plan), each position of the word, what was told
of violations, and how the run ended. docs/run-folder.md describes the lines. A run that was cut
off, by a crash or while it still goes on, has no end, and perhaps half a last line; both are
tolerated. Anything else that is not as documented is refused with its line.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from companion.errors import FormulaError, KeyPath, Location, MissionError
from companion.ltl.formula import Formula
from companion.ltl.parser import parse

EVENTS = "events.jsonl"
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class LeftPosition:
    """A position of the word, as it was recorded.

    Attributes:
        time_s: seconds since the run began, when it was left.
        restarted: names of conjuncts that begin anew with this position.
        is_for_ever: the vehicle rests there, and every position to come is the same.
    """

    number: int
    time_s: float
    facts: frozenset[str]
    withdrawn: frozenset[str]
    restarted: frozenset[str]
    is_for_ever: bool


@dataclass(frozen=True, slots=True)
class RunRecord:
    """What a run left behind of its task.

    Attributes:
        violations: conjunct and position of each violation that was told in flight.
        ending: the last words of the run; None if it was cut off.
        is_torn: the last line is not whole, and was left out.
    """

    task: Mapping[str, Formula]
    positions: tuple[LeftPosition, ...]
    violations: frozenset[tuple[str, int]]
    ending: str | None
    is_torn: bool


def read_events(folder: Path) -> RunRecord:
    """Reads what a run folder says of the task.

    Raises:
        MissionError: there is no such file, it is not as documented, or no plan was made.
    """
    path = folder / EVENTS
    try:
        *whole, rest = path.read_bytes().split(b"\n")
    except OSError as error:
        raise MissionError(
            f"{folder} is no run folder: {EVENTS} cannot be read: {error.strerror}",
            hint="companion sim and companion run print the folder of each run",
        ) from error
    is_torn = bool(rest) and not _is_json(rest)
    if rest and not is_torn:
        whole.append(rest)
    lines = [_Line.read(text, Location(str(path), i, 1)) for i, text in enumerate(whole, 1)]
    return _record(lines, str(path), is_torn)


def record_of(events: Iterable[Mapping[str, object]]) -> RunRecord:
    """What the events of a run, each as its line has it, say of the task.

    Raises:
        MissionError: no plan was made.
    """
    texts = (json.dumps(event).encode() for event in events)
    lines = [_Line.read(text, KeyPath(("events", i))) for i, text in enumerate(texts)]
    return _record(lines, "the run", is_torn=False)


def _record(lines: Iterable[_Line], name: str, is_torn: bool) -> RunRecord:
    task: dict[str, Formula] | None = None
    positions: list[LeftPosition] = []
    violations: set[tuple[str, int]] = set()
    ending = None
    for line in lines:
        match line.kind:
            case "plan":
                task = line.task()
            case "position":
                positions.append(line.position(len(positions)))
            case "violation":
                violations.add((line.value("conjunct", str), line.value("position", int)))
            case "end":
                ending = line.value("text", str)
    if task is None:
        why = f": {ending}" if ending else ""
        raise MissionError(f"{name}: no plan was made in this run, so nothing was flown{why}")
    return RunRecord(task, tuple(positions), frozenset(violations), ending, is_torn)


def _is_json(text: bytes) -> bool:
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return False
    return True


@dataclass(frozen=True, slots=True)
class _Line:
    """One line, checked as far as it is read."""

    data: dict[str, Any]
    where: Location | KeyPath

    @classmethod
    def read(cls, text: bytes, where: Location | KeyPath) -> _Line:
        try:
            data = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise MissionError("this line is not JSON", where) from error
        if not isinstance(data, dict):
            raise MissionError("this line is not a JSON object", where)
        return cls(data, where)

    @property
    def kind(self) -> str:
        return self.value("kind", str)

    def value(self, key: str, kind: type[T]) -> T:
        found = self.data.get(key)
        if type(found) is not kind:
            raise MissionError(f"{key} is missing here, or not of its kind", self.where)
        return found

    def seconds(self) -> float:
        found = self.data.get("t_s")
        if isinstance(found, bool) or not isinstance(found, int | float) or not 0 <= found < 1e9:
            raise MissionError("t_s is missing here, or no time in seconds", self.where)
        return float(found)

    def names(self, key: str) -> frozenset[str]:
        found = self.value(key, list)
        if not all(isinstance(name, str) for name in found):
            raise MissionError(f"{key} is not a list of names", self.where)
        return frozenset(found)

    def task(self) -> dict[str, Formula]:
        formulas = {}
        for name, text in self.value("task", dict).items():
            try:
                formulas[name] = parse(text if isinstance(text, str) else "")
            except FormulaError as error:
                raise error.located(self.where) from error
        return formulas

    def position(self, number: int) -> LeftPosition:
        """Raises MissionError if it is not the position that comes next."""
        if self.value("number", int) != number:
            found = self.data["number"]
            raise MissionError(f"position {found} stands where {number} is due", self.where)
        return LeftPosition(
            number,
            self.seconds(),
            self.names("facts"),
            self.names("withdrawn"),
            self.names("restarted"),
            self.value("for_ever", bool),
        )
