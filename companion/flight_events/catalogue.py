"""All classes of events, in the order in which docs/run-folder.md lists them.

A class is declared in a module of this package, and needs no other entry.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

from companion.flight_events import (
    charge,
    energy,
    facts,
    fence,
    frames,
    hosting,
    landing,
    plans,
    rally,
    reports,
    skills,
    sortie,
    tree,
    word,
)
from companion.flight_events.event import FlightEvent

MODULES: tuple[ModuleType, ...] = (
    *(plans, skills, facts, word, sortie, fence, rally, frames, landing),
    *(charge, energy, hosting, reports, tree),
)


def _declared(module: ModuleType) -> Iterator[type[FlightEvent]]:
    """The classes of events that a module declares, without those that others derive from."""
    for each in vars(module).values():
        if isinstance(each, type) and issubclass(each, FlightEvent):
            is_concrete = hasattr(each, "kind") and hasattr(each, "template")
            if is_concrete and each.__module__ == module.__name__:
                yield each


EVENTS = tuple(event for module in MODULES for event in _declared(module))
RECORDED = tuple(event for event in EVENTS if event.is_recorded)
"""Those that events.jsonl keeps."""
FOR_PROGRAMS = frozenset(event.kind for event in EVENTS if not event.is_told)
"""Kinds that are no news for people."""
