"""A room with a vehicle in it, to tick single leaves of a tree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from rig import Rig
from synthetic import POSITIONS, command, event, mission, move

from companion.motion.grid import OccupancyGrid
from companion.tick import TICK_S


def a_rig(**fields: object) -> Rig:
    found = [event("found")]
    skills = [move(), command("do", "at(H)", "done")]
    return Rig(replace(mission("F done", skills=skills, events=found), **fields))  # type: ignore[arg-type]


def tick(rig: Rig, leaf: Behaviour) -> Status:
    rig.pass_time()
    rig.flight.guidance.brake()
    leaf.tick_once()
    return leaf.status


def later(rig: Rig) -> float:
    """Some time passes, so that no time counted from the start is counted from zero."""
    for _ in range(70):
        rig.pass_time()
    return rig.flight.now_s


def run(rig: Rig, leaf: Behaviour, limit_s: float = 60.0) -> Status:
    """Ticks a leaf until it has ended."""
    for _ in range(round(limit_s / TICK_S)):
        if tick(rig, leaf) is not Status.RUNNING:
            return leaf.status
    raise AssertionError(f"still running after {limit_s:.0f} s")


def walled_in(place: str) -> OccupancyGrid:
    """The room with walls around a place, which itself is free."""
    occupied = np.zeros((20, 20), dtype=np.bool_)
    north, east, _ = POSITIONS[place]
    row, col = round((north + 2) / 0.5), round((east + 2) / 0.5)
    occupied[max(row - 3, 0) : row + 4, max(col - 3, 0) : col + 4] = True
    occupied[max(row - 2, 0) : row + 3, max(col - 2, 0) : col + 3] = False
    return OccupancyGrid(occupied, 0.5, (-2.0, -2.0))
