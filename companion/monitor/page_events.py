"""Events that the monitor derives from those of the run, for the page alone.

They join the run's own events under kinds of their own, and are written in the same form.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from companion.flight_events.event import FlightEvent

EastNorth = tuple[float, float]
"""Metres east and north of home."""
Leg = tuple[EastNorth, ...]
"""The corners of the way of one action."""


class DerivedEvent(FlightEvent):
    """An event that no run has recorded."""

    __slots__ = ()
    template = ""
    is_told = False
    is_recorded = False


Edge = tuple[int, int]
"""From one node to another, by their numbers."""


class Arrow(NamedTuple):
    """The transitions between two nodes, by their numbers, and what they are labelled with."""

    start: int
    end: int
    label: str


@dataclass(frozen=True, slots=True)
class AutomatonDrawing:
    """The automaton of one conjunct.

    Attributes:
        initial: nodes in which it begins.
        accepting: of each node.
    """

    conjunct: str
    formula: str
    initial: tuple[int, ...]
    accepting: tuple[bool, ...]
    arrows: tuple[Arrow, ...]


@dataclass(frozen=True, slots=True)
class AutomataDrawn(DerivedEvent):
    """The task has these automata."""

    kind = "automata"

    automata: tuple[AutomatonDrawing, ...]


@dataclass(frozen=True, slots=True)
class AutomataMoved(DerivedEvent):
    """The automata may be in these nodes, a list for each of them.

    Attributes:
        taken: the edges by which they have come there, from node to node.
        due: what is still to be done, in words: the name of a line of the task, and of it.
    """

    kind = "states"

    states: tuple[tuple[int, ...], ...]
    taken: tuple[tuple[Edge, ...], ...]
    due: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class WayPlanned(DerivedEvent):
    """The plan leads along this way on the map as it is known now."""

    kind = "path"

    legs: tuple[Leg, ...]


class SeenCell(NamedTuple):
    """A cell of the map."""

    row: int
    col: int
    is_occupied: bool


@dataclass(frozen=True, slots=True)
class CellsChanged(DerivedEvent):
    """Cells have become occupied or free by what the lidar saw."""

    kind = "cells"

    cells: tuple[SeenCell, ...]


DERIVED: tuple[type[DerivedEvent], ...] = (AutomataDrawn, AutomataMoved, WayPlanned, CellsChanged)
