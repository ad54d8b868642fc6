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


class Arrow(NamedTuple):
    """The transitions between two nodes, by their numbers, and what they are labelled with."""

    start: int
    end: int
    label: str


@dataclass(frozen=True, slots=True)
class AutomatonDrawing:
    """The automaton of one conjunct.

    Attributes:
        accepting: of each node.
    """

    conjunct: str
    formula: str
    accepting: tuple[bool, ...]
    arrows: tuple[Arrow, ...]


@dataclass(frozen=True, slots=True)
class AutomataDrawn(DerivedEvent):
    """The task has these automata."""

    kind = "automata"

    automata: tuple[AutomatonDrawing, ...]


@dataclass(frozen=True, slots=True)
class AutomataMoved(DerivedEvent):
    """The automata may be in these nodes, a list for each of them."""

    kind = "states"

    states: tuple[tuple[int, ...], ...]


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
