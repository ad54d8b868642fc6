"""Events for the page alone, which the monitor derives from those of the run.

They join the run's own events under their own kinds, in the same form.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from companion.flight_events.event import FlightEvent

EastNorth = tuple[float, float]
"""Metres east and north of home."""
Leg = tuple[EastNorth, ...]
"""The corners of the route of one action."""


class DerivedEvent(FlightEvent):
    """An event that no run has recorded."""

    __slots__ = ()
    template = ""
    is_told = False
    is_recorded = False


Edge = tuple[int, int]
"""From one node to another, by their indices."""


class Arrow(NamedTuple):
    """The transitions between two nodes, given by index, with their labels."""

    start: int
    end: int
    label: str


@dataclass(frozen=True, slots=True)
class AutomatonDrawing:
    """The automaton of one conjunct.

    Attributes:
        initial: the nodes in which it begins.
        accepting: for each node.
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
    """The automata may be in these nodes, with a list for each automaton.

    Attributes:
        taken: the edges by which they came there, from node to node.
        due: what is still to be done, in words: the name of a line of the task, and its demand.
    """

    kind = "states"

    states: tuple[tuple[int, ...], ...]
    taken: tuple[tuple[Edge, ...], ...]
    due: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class RoutePlanned(DerivedEvent):
    """The plan has this route on the map as known now."""

    kind = "path"

    legs: tuple[Leg, ...]


class SeenCell(NamedTuple):
    """A cell of the map."""

    row: int
    col: int
    is_occupied: bool


@dataclass(frozen=True, slots=True)
class CellsChanged(DerivedEvent):
    """Cells became occupied or free by what the lidar saw."""

    kind = "cells"

    cells: tuple[SeenCell, ...]


DERIVED: tuple[type[DerivedEvent], ...] = (AutomataDrawn, AutomataMoved, RoutePlanned, CellsChanged)
