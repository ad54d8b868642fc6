"""The skill by which most missions of the tests fly from place to place, as in a mission file."""

from __future__ import annotations

from typing import Any

MOVE: dict[str, Any] = {
    "parameters": {"from": "Place", "to": "Place"},
    "precondition": "at(from)",
    "effect": "at(to) & !at(from)",
    "execute": "fly(to)",
}
