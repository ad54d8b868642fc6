"""A small mission as data, with its own map: fly to A, past a wall."""

from __future__ import annotations

from typing import Any

THERE: dict[str, Any] = {
    "version": 1,
    "name": "there",
    "map": {
        "east_m": [-2, 8],
        "north_m": [-2, 8],
        "walls": [{"east_m": [4, 5], "north_m": [-2, 1]}],
    },
    "limits": {"speed_mps": 3, "up_m": [0.5, 4], "fence": [[-2, -2], [8, -2], [8, 8], [-2, 8]]},
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
        "A": {"east_m": 6, "north_m": 5, "up_m": 2},
    },
    "sets": {"Place": ["Home", "A"]},
    "skills": {
        "move": {
            "parameters": {"from": "Place", "to": "Place"},
            "precondition": "at(from)",
            "assumes": "ok(to)",
            "effect": "at(to) & !at(from)",
            "execute": "fly(to)",
        }
    },
    "initially": ["at(Home)"],
    "goal": "at(A)",
}
