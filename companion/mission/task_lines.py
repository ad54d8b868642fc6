"""Reads the lines of a mission's task: formulas by name, and which of them may be dropped.

A plain goal is a line with the name `goal`. A line with a priority may be dropped if no plan keeps
it. At least one line has no priority: it decides when the mission is done, and when it has failed.
"""

from __future__ import annotations

from collections.abc import Mapping

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import KeyPath, Location, MissionError
from companion.ltl.formula import eventually
from companion.ltl.parser import parse, parse_line
from companion.ltl.time_bounds import Response
from companion.ltl.timed_formula import Line, parts
from companion.mission.facts import AT, Fact
from companion.mission.literals import parse_literals
from companion.mission.schema import MissionFile
from companion.mission.vocabulary import Vocabulary

GOAL = "goal"  # the name of a plain goal
_TASK_HINT = "add task: {NAME: FORMULA}, what must hold, or goal: FACTS, what must hold once"


def line_names(file: MissionFile) -> list[str]:
    """The names of all lines, in the order of the file."""
    return [*file.task, *([GOAL] if file.goal is not None else [])]


def lines_at(file: MissionFile, document: Document) -> dict[str, Location | KeyPath]:
    """Where each line stands in the document: its formula, or the goal."""
    at = {name: document.where("task", name, "formula") for name in file.task}
    return {**at, GOAL: document.where(GOAL)} if file.goal is not None else at


def read_task(
    file: MissionFile, document: Document, vocabulary: Vocabulary, reading: DocumentReading
) -> dict[str, Line]:
    """The formulas of all lines; lines that are no formula are left out."""

    def read(name: str, text: str) -> Line:
        with document.locating("task", name, "formula"):
            line = parse_line(text)
            vocabulary.check(text)
        return line

    def read_goal(text: str) -> Line:
        with document.locating(GOAL):
            parse_literals(text)
            vocabulary.check(text)
        return eventually(parse(text))

    task: dict[str, Line] = {}
    for name, entry in file.task.items():
        line = reading.read(("task", name, "formula"), read, name, entry.formula)
        if line is not None:
            task[name] = line
    if file.goal is not None:
        line = reading.read((GOAL,), read_goal, file.goal)
        if line is not None:
            task[GOAL] = line
    if all(map(reading.knows, ("task", GOAL, "tree"))):
        reading.check(_check_lines, file, document)
    return task


def _check_lines(file: MissionFile, document: Document) -> None:
    """Refuses a task without lines, and two lines with the same name."""
    if file.goal is None and not file.task and not file.tree:
        raise MissionError(
            "the mission has neither a task nor a goal nor a tree", document.where(), _TASK_HINT
        )
    if file.goal is not None and GOAL in file.task:
        raise MissionError(
            "a line of the task is called goal, and there is a goal",
            document.key_at("task", GOAL),
            "choose another name for the line",
        )


def read_ready(file: MissionFile, document: Document, task: Mapping[str, Line]) -> tuple[str, ...]:
    """The lines that have to be keepable whenever their event comes.

    Raises:
        MissionError: a name is no line, the line demands no place in time, or plans cannot keep it.
    """
    for index, name in enumerate(file.ready):
        where = document.where("ready", index)
        if name not in task:
            hint = f"lines are {', '.join(task)}. {did_you_mean(name, task)}".rstrip()
            raise MissionError(f"no line of the task is called {name}", where, hint)
        bounds = [bound for _, bound in parts(task[name])]
        if not all(isinstance(bound, Response) for bound in bounds):
            what = f"{name} is not a line that can be ready: {task[name]}"
            raise MissionError(what, where, "write it as G (alarm -> F[<=90s] at(A))")
        for goal in [bound.goal for bound in bounds if bound is not None]:
            fact = Fact.parse(goal.atom)
            if fact.predicate != AT:
                what = f"{name} can only be ready for a place, and asks for {goal}"
                raise MissionError(what, where, "write it as G (alarm -> F[<=90s] at(A))")
            (place,) = fact.arguments
            if place in file.places and file.places[place].found_by:
                what = f"{name} cannot be ready: nobody knows where {place} is before it is found"
                raise MissionError(what, where, "leave it out of ready:")
        if name in file.ready[:index]:
            raise MissionError(f"{name} is twice in ready", where, "remove one of the two")
        for is_wrong, what, hint in (
            (file.task[name].priority is not None, "may be dropped", "leave its priority out"),
            (bool(file.tree), "stands beside a tree by hand", "leave ready: out, or tree:"),
        ):
            if is_wrong:
                raise MissionError(f"{name} {what}, so no plan keeps it ready", where, hint)
    return tuple(file.ready)


def priorities_of(file: MissionFile, document: Document) -> dict[str, int]:
    """The priorities of the lines that may be dropped.

    Raises:
        MissionError: all lines may be dropped.
    """
    given = {name: line.priority for name, line in file.task.items() if line.priority is not None}
    if given and len(given) == len(line_names(file)) and not file.tree:
        raise MissionError(
            "every line of the task may be dropped, so nothing must hold",
            document.where("task"),
            "write the line without which the mission has failed as NAME: FORMULA, without "
            "a priority",
        )
    return given
