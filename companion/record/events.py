"""Reads events.jsonl of a run: as events, and as a record of the task.

The record has the task as it was flown (with the first plan), each position of the word, the
violations found in flight, and how the run ended. A run that was cut off, or still goes on, has no
end and perhaps an incomplete last line; both are tolerated. Any other deviation from
docs/run-folder.md is refused, with its line.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from companion.errors import FormulaError, KeyPath, Location, MissionError
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.plans import PlanMade, TaskRecalled, WrittenTreeAdopted
from companion.flight_events.reading import read_line
from companion.flight_events.sortie import Phase, PhaseEntered, RunEnded
from companion.flight_events.tree import TreeBuilt
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.ltl.parser import parse_line
from companion.ltl.timed_formula import Line
from companion.record.json_lines import is_object, whole_lines
from companion.record.timed_word import Step, TimedWord

ENDS_THE_TASK = (Phase.RETURNING, Phase.HOLDING, Phase.PARTING, Phase.LANDING)
"""Phases after which nothing counts for the task."""
EVENTS_FILE = "events.jsonl"
MISSION_FILE, SCENE_FILE = "mission.yaml", "scene.json"
TLOG_FILE = "flight.tlog"
JOURNAL_FILE = "journal.jsonl"
OTHERS = (SCENE_FILE, TLOG_FILE, JOURNAL_FILE)
"""Other files that a run folder has from the start; not all runs have a journal."""
_LOOKED_AT_BYTES = 4096


class EventsLost(MissionError):
    """A run's events are not on the disk; its other files may still show it."""


@dataclass(frozen=True, slots=True)
class RunRecord:
    """What a run has recorded of its task.

    Attributes:
        priorities: the priorities of the lines of the task that may be dropped.
        positions: the word; the vehicle may rest at the last one for ever.
        times_s: when each position was left, in seconds since the run began.
        violations: conjunct and position of each violation found in flight.
        tree: the last behaviour tree that was ticked; None if there was none.
        ending: how the run ended; None if it was cut off.
        is_torn: the last line is incomplete, and was left out.
        in_time: the word with its times, for lines with time bounds.
        is_headless: its beginning was lost, and the continued flight has repeated the word.
    """

    task: Mapping[str, Line]
    priorities: Mapping[str, int]
    positions: tuple[PositionLeft, ...]
    times_s: tuple[float, ...]
    violations: frozenset[tuple[str, int]]
    tree: TreeBuilt | None
    ending: RunEnded | None
    is_torn: bool
    in_time: TimedWord
    is_headless: bool = False


def read_events(folder: Path) -> RunRecord:
    """Reads the record of the task from a run folder.

    Raises:
        EventsLost: the run was cut off, and nothing of events.jsonl is left.
        MissionError: it is no run folder, a line is damaged, or the run has no plan.
    """
    path = folder / EVENTS_FILE
    try:
        whole, rest = whole_lines(path.read_bytes())
    except FileNotFoundError as error:
        if not has_a_run(folder):
            raise no_run_folder(folder, EVENTS_FILE, error) from error
        raise events_lost(folder, "is missing") from error
    except OSError as error:
        raise no_run_folder(folder, EVENTS_FILE, error) from error
    is_torn = bool(rest) and not is_object(rest)
    if rest and not is_torn:
        whole.append(rest)
    if not whole:
        if rest.strip(b"\0"):
            raise events_lost(folder, "has no whole line")
        raise events_lost(folder, "is empty", ", or has just begun")
    places = [Location(str(path), number, 1) for number in range(1, len(whole) + 1)]
    events = [read_line(line, where) for line, where in zip(whole, places, strict=True)]
    return _record(zip(events, places, strict=True), str(path), is_torn)


def has_a_run(folder: Path) -> bool:
    """Whether a run was recorded there, whatever is left of it."""
    return any((folder / file).is_file() for file in (EVENTS_FILE, *OTHERS))


def is_lost(path: Path) -> bool:
    """Whether a file is missing, empty, or begins with the zeros of a power failure."""
    try:
        with path.open("rb") as file:
            return not file.read(_LOOKED_AT_BYTES).strip(b"\0")
    except FileNotFoundError:
        return True


def events_lost(folder: Path, what: str, or_else: str = "") -> EventsLost:
    """Says what is missing of a run that was cut off, and how it can still be looked at."""
    left = []
    if not is_lost(folder / TLOG_FILE):
        shown = f"companion replay {folder} shows it, companion figure {folder} draws it"
        if is_lost(folder / SCENE_FILE):
            shown = f"MAVProxy and QGroundControl show it; {SCENE_FILE} is lost, too"
        left.append(f"where the vehicle was is in {TLOG_FILE}: {shown}")
    plans = [path.name for path in folder.glob("plan-*.json") if not is_lost(path)]
    if plans:
        plans.sort(key=lambda name: (len(name), name))
        listed = f"{plans[0]} to {plans[-1]}" if len(plans) > 1 else plans[0]
        left.append(f"what was planned is in {listed}")
    if not is_lost(folder / JOURNAL_FILE):
        how = "companion run --resume writes it again when it resumes the flight"
        left.append(f"what of the task was done is in {JOURNAL_FILE}: {how}")
    return EventsLost(
        f"{folder / EVENTS_FILE} {what}, so the run cannot be audited: it was cut off before what "
        f"happened was on the disk{or_else}",
        hint="\n".join(left) or "nothing else is left of it",
    )


def no_run_folder(folder: Path, file: str, error: OSError) -> MissionError:
    """What is wrong with a run folder that was given, and what to give instead."""
    holds = f"a run folder holds {EVENTS_FILE} and what else was recorded of a flight"
    lists = "companion runs lists them; companion sim and companion run print theirs"
    if (folder.parent / EVENTS_FILE).is_file():
        return MissionError(
            f"{folder} is a file of a run", hint=f"give its folder: {folder.parent}"
        )
    if folder.is_file():
        return MissionError(f"{folder} is a file, and no run folder", hint=f"{holds}\n{lists}")
    if not folder.exists():
        return MissionError(f"there is no run folder {folder}", hint=lists)
    if inner := sorted(path.parent for path in folder.glob(f"*/{EVENTS_FILE}")):
        hint = f"give one of them, e.g. {inner[-1]}"
        return MissionError(f"{folder} holds {len(inner)} run folders", hint=hint)
    what = f"{folder} is not a run folder: {file} cannot be read: {error.strerror}"
    return MissionError(what, hint=f"{holds}\n{lists}")


def record_of(events: Iterable[Stamped]) -> RunRecord:
    """The record of the task from the events of a run.

    Raises:
        MissionError: there is no plan.
    """
    placed = ((event, KeyPath(("events", number))) for number, event in enumerate(events))
    return _record(placed, "the run", is_torn=False)


def _record(
    events: Iterable[tuple[Stamped, Location | KeyPath]], name: str, is_torn: bool
) -> RunRecord:
    task: dict[str, Line] | None = None
    priorities: Mapping[str, int] = {}
    positions: list[PositionLeft] = []
    times_s: list[float] = []
    violations: set[tuple[str, int]] = set()
    tree: TreeBuilt | None = None
    ending: RunEnded | None = None
    steps: list[tuple[float, Step]] = []
    until_s, is_counted, is_headless = 0.0, True, False
    for stamped, where in events:
        if is_counted:
            until_s, is_counted = stamped.time_s, not _ends_the_task(stamped.event)
        if isinstance(stamped.event, Step):
            steps.append((stamped.time_s, stamped.event))
        match stamped.event:
            case PlanMade() | WrittenTreeAdopted() | TaskRecalled() as first:
                is_headless |= task is None and isinstance(first, TaskRecalled)
                task, priorities = _formulas(first.task, where), first.priorities
            case PositionLeft() as position:
                _demand_next(position.number, len(positions), where)
                positions.append(position)
                times_s.append(stamped.time_s)
            case ConjunctViolated() as violation:
                violations.add((violation.conjunct, violation.position))
            case TreeBuilt() as built:
                tree = built
            case RunEnded() as end:
                ending = end
    if task is None and ending is None:
        raise MissionError(f"{name}: the run was cut off, and no plan is in what is left of it")
    if task is None:
        why = f": {ending.text}" if ending else ""
        raise MissionError(f"{name}: no plan was made in this run, so nothing was flown{why}")
    violated = frozenset(violations)
    return RunRecord(
        task=task,
        priorities=priorities,
        positions=tuple(positions),
        times_s=tuple(times_s),
        violations=violated,
        tree=tree,
        ending=ending,
        is_torn=is_torn,
        in_time=TimedWord(tuple(steps), until_s, violated),
        is_headless=is_headless,
    )


def _ends_the_task(event: FlightEvent) -> bool:
    """Whether time no longer counts for the task."""
    match event:
        case PhaseEntered(phase):
            return phase in ENDS_THE_TASK
        case PositionLeft(for_ever=True) | RunEnded():
            return True
    return False


def _formulas(task: Mapping[str, str], where: Location | KeyPath) -> dict[str, Line]:
    try:
        return {name: parse_line(text) for name, text in task.items()}
    except FormulaError as error:
        raise error.located(where) from error


def _demand_next(number: int, due: int, where: Location | KeyPath) -> None:
    if number != due:
        raise MissionError(f"position {number} stands where {due} is due", where)
