"""Reads and checks the events of a mission file."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import MissionError
from companion.mission.conditions import parse_condition
from companion.mission.events import Event
from companion.mission.schema import EventEntry, MissionFile
from companion.mission.signals import AnyCondition, Silence
from companion.mission.skills import Skill
from companion.mission.task_lines import line_names


def read_events(
    file: MissionFile, document: Document, reading: DocumentReading
) -> dict[str, Event]:
    """The events of a mission, by name.

    Events with an unreadable condition or contradictory keys are left out.
    """
    lines = line_names(file) if reading.knows("task") else None
    events = {}
    for name, entry in file.events.items():
        when, until = (
            reading.read(keys, _condition, text, keys, document)
            for text, keys in (
                (entry.when, ("events", name, "when")),
                (entry.until, ("events", name, "until")),
            )
        )
        if when is None:
            continue
        conditions = (when, until)
        keys = ("events", name)
        if event := reading.read(keys, _event, name, entry, conditions, lines, document):
            events[name] = event
    return events


def _condition(text: str | None, keys: tuple[str, ...], document: Document) -> AnyCondition | None:
    with document.locating(*keys):
        return parse_condition(text) if text is not None else None


def _event(
    name: str,
    entry: EventEntry,
    conditions: tuple[AnyCondition, AnyCondition | None],
    lines: Collection[str] | None,
    document: Document,
) -> Event:
    """One event; `lines` are the names of the task's lines, None if they are not known."""
    when, until = conditions
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
        if lines is not None and conjunct not in lines:
            raise MissionError(
                f"{name} restarts {conjunct}, which the task does not have",
                document.where("events", name, "restarts", index),
                f"the task has {', '.join(lines)}. {did_you_mean(conjunct, lines)}".rstrip(),
            )
    return Event(
        name,
        when=when,
        until=until,
        latch=entry.latch,
        for_s=entry.for_s,
        restarts=frozenset(entry.restarts),
        restores=frozenset(entry.restores),
        stale_s=entry.stale_s,
    )


def _check_silence(
    name: str,
    entry: EventEntry,
    conditions: tuple[AnyCondition, AnyCondition | None],
    document: Document,
) -> None:
    """Refuses a test for silence without a time for it, and a time without a test."""
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
    """Refuses an event that restores a belief which no skill assumes.

    Raises:
        MissionError: with the beliefs that skills assume.
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
