"""Tells whether two missions are the same, whatever files they come from."""

from __future__ import annotations

import hashlib

from companion.mission.model import Mission


def digest(mission: Mission) -> str:
    """A hash of everything in a mission: its text, its map, and the contents of its PDDL files.

    >>> from companion import load_mission
    >>> len(digest(load_mission("missions/surveillance.yaml")))
    64
    """
    grid = mission.grid
    parts = [
        mission.text,
        repr((grid.occupied.shape, grid.cell_m, grid.origin)),
        *(repr(skill) for skill in mission.skills.values()),
        *(f"{name}: {formula}" for name, formula in mission.task.items()),
        *sorted(mission.initially),
    ]
    hashed = hashlib.sha256("\n".join(parts).encode())
    hashed.update(grid.occupied.tobytes())
    return hashed.hexdigest()
