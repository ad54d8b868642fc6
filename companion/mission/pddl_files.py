"""Reads a mission's PDDL files with unified-planning.

Its reader checks little and can fail in any way. Here each failure becomes an error that says what
is wrong, where it is, and what PDDL may be used.
"""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from companion.documents import Document
from companion.errors import Location, MissionError
from companion.mission.schema import MissionFile

if TYPE_CHECKING:
    from unified_planning.model import Problem

MAX_BYTES = 65_536  # as for a mission file
_KEYS = ("domain", "problem")

_FEATURES = (
    "it needs :strips, :typing, :negative-preconditions, :equality, :conditional-effects, "
    ":universal-preconditions or :action-costs, and its sections in the order :requirements, "
    ":types, :constants, :predicates, :functions, :action"
)
_FOREIGN = {
    "TIMED_EFFECTS": "facts that change at a time",
    "CONTINUOUS_TIME": "actions with durations",
    "PROCESSES": "processes",
    "EVENTS": "events (they stand in the mission file)",
    "TRAJECTORY_CONSTRAINTS": "constraints (write them as lines of the task)",
    "STATE_INVARIANTS": "constraints (write them as lines of the task)",
    "HIERARCHICAL": "tasks and methods",
    "CONTINGENT": "unknown facts and observations",
}
"""Features of unified-planning that a mission cannot express."""

_PLACE = re.compile(
    r"[.,]? *(?:\(at char \d+\), \(|(?:error )?(?:in expression )?(?:found )?(?:from|at)? *)"
    r"line: ?(\d+), col:? ?(\d+)",
    re.IGNORECASE,
)
_QUOTED = re.compile(r"^UP\w+\((['\"])(.*?)\1?\)?$")  # an error of the reader inside another


def parsed(folder: Path, file: MissionFile, document: Document) -> Problem:
    """Returns the PDDL files of a mission as unified-planning reads them.

    Args:
        folder: where the files are.
        file: names the domain, and perhaps a problem.
        document: the mission file, for the places of its keys.

    Raises:
        MissionError: a file cannot be read, or contains what a mission cannot express; with the
            file's own line and column if they are known.
    """
    from unified_planning.environment import get_environment

    names = [name for name in (file.domain, file.problem) if name is not None]
    texts = [_text(folder / name, document, key) for name, key in zip(names, _KEYS, strict=False)]
    # A type and an object may share a name. The reader needs its global environment for forall.
    get_environment().error_used_name = False
    read = [  # the domain is read alone first, so that each error can be attributed to one file
        _parsed(texts[: last + 1], folder / name, document, key)
        for last, (name, key) in enumerate(zip(names, _KEYS, strict=False))
    ]
    return read[-1]


def _parsed(texts: list[str], path: Path, document: Document, key: str) -> Problem:
    """Reads the texts together; the last one is the text of the file."""
    from unified_planning.io import PDDLReader

    try:
        with warnings.catch_warnings(action="ignore"):
            problem = PDDLReader().parse_problem_string(*texts)
        features = problem.kind.features
    except Exception as error:  # the reader fails in any way on bad input
        reason, place = _reason(error)
        where = Location(str(path), *place) if place else document.where(key)
        what = f"{path.name} cannot be read as PDDL: {reason[:300]}"
        raise MissionError(what, where, _FEATURES) from error
    for feature, words in _FOREIGN.items():
        if feature in features:
            what = f"{path.name} has {words}, which are not supported"
            raise MissionError(what, document.where(key), _FEATURES)
    return problem


def _reason(error: Exception) -> tuple[str, tuple[int, int] | None]:
    """Returns the reader's error in one line, with line and column if it gives them."""
    if isinstance(error, RecursionError):
        return "it is nested too deeply", None
    if isinstance(error, KeyError):
        return f"there is no type {error.args[0]}", None
    if isinstance(error, TypeError | IndexError | AttributeError | AssertionError):
        return "an expression has too few parts, or brackets in the wrong place", None
    text = " ".join(str(error).split()) or type(error).__name__
    place = _PLACE.search(text)
    reason = _QUOTED.sub(r"\2", text[: place.start()] if place else text)
    return reason, (int(place[1]), int(place[2])) if place else None


def _text(path: Path, document: Document, key: str) -> str:
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise MissionError(f"{path.name} has more than {MAX_BYTES} bytes", document.where(key))
        return data.decode("utf-8")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise MissionError(f"{path} cannot be read: {reason}", document.where(key)) from error
