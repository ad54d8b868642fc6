"""Events of a mission file, read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from companion.documents import Document, MistakeGathering, did_you_mean
from companion.errors import MissionError
from companion.mission.conditions import parse_condition
from companion.mission.model import Event, Skill
from companion.mission.schema import EventEntry, MissionFile
from companion.mission.signals import AnyCondition, Silence
from companion.mission.task_lines import line_names


def read_events(file: MissionFile, document: Document) -> dict[str, Event]:
    """The events of a mission, by their names.

    Raises:
        MissionError: a condition cannot be read, or keys of an event contradict each other.
    """
    mistakes, events = MistakeGathering(), {}
    for name, entry in file.events.items():
        if event := mistakes.read(partial(_event, name, entry, file, document)):
            events[name] = event
    mistakes.tell()
    return events


def _event(name: str, entry: EventEntry, file: MissionFile, document: Document) -> Event:
    with document.locating("events", name, "when"):
        when = parse_condition(entry.when)
    with document.locating("events", name, "until"):
        until = parse_condition(entry.until) if entry.until is not None else None
    if until is not None and entry.latch:
        raise MissionError(
            f"{name} has both latch and until",
            document.key_at("events", name, "until"),
            "a latched fact stays true for ever: remove one of the two",
        )
    lasting = [each for each in (when, until) if each and not each.signal.is_pulse]
    if not lasting and entry.for_s > 0:
        raise MissionError(
            f"{name} waits for a command to hold for {entry.for_s:g} s",
            document.where("events", name, "for_s"),
            "a command is there at the moment when it comes: remove for_s",
        )
    _check_silence(name, entry, (when, until), document)
    for index, conjunct in enumerate(entry.restarts):
        lines = line_names(file)
        if conjunct not in lines:
            raise MissionError(
                f"{name} restarts {conjunct}, which the task does not have",
                document.where("events", name, "restarts", index),
                f"the task has {', '.join(lines)}. {did_you_mean(conjunct, lines)}".rstrip(),
            )
    restarts, restores = frozenset(entry.restarts), frozenset(entry.restores)
    behaviour = (when, until, entry.latch, entry.for_s, restarts, restores, entry.stale_s)
    return Event(name, *behaviour)


def _check_silence(
    name: str,
    entry: EventEntry,
    conditions: tuple[AnyCondition, AnyCondition | None],
    document: Document,
) -> None:
    """What is asked for silence needs a time for it, and the other way round."""
    is_asked = any(isinstance(condition, Silence) for condition in conditions)
    if is_asked and entry.stale_s is None:
        raise MissionError(
            f"{name} does not say after how many seconds it is silent",
            document.where("events", name, "when"),
            "add stale_s, e.g. stale_s: 2",
        )
    if entry.stale_s is not None and all(c.signal.is_pulse for c in conditions if c):
        raise MissionError(
            f"{name} waits for a command, which is not known for a time",
            document.where("events", name, "stale_s"),
            "a command is there at the moment when it comes: remove stale_s",
        )


def check_restored(file: MissionFile, skills: Mapping[str, Skill], document: Document) -> None:
    """Refuses an event that restores what no skill assumes.

    Raises:
        MissionError: with what skills assume.
    """
    beliefs = sorted({atom.predicate for skill in skills.values() for atom in skill.assumes})
    for name, entry in file.events.items():
        for index, belief in enumerate(entry.restores):
            if belief not in beliefs:
                raise MissionError(
                    f"{name} restores {belief}, which no skill assumes",
                    document.where("events", name, "restores", index),
                    f"beliefs are {', '.join(beliefs) or 'none yet'}. "
                    f"{did_you_mean(belief, beliefs)}".rstrip(),
                )
