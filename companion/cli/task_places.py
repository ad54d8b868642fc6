"""Finds where in the mission file the lines of a task are that have no plan together."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from companion.errors import Location

if TYPE_CHECKING:
    from companion.planning.explain import NoPlan


def placed(reason: NoPlan, path: Path) -> NoPlan:
    """The reason why there is no plan, with the lines of the mission file that it names."""
    from companion.planning.explain import NoPlan

    return NoPlan(reason.explanation, _lines(path))


def _lines(path: Path) -> dict[str, int]:
    """The line of each part of the task, by its name."""
    from companion.documents import TextDocument, read_source

    text = read_source(path, "mission").content
    assert isinstance(text, str)
    document = TextDocument(text, str(path))
    data = document.data()
    task = data.get("task") if isinstance(data, dict) else None
    names = [*task] if isinstance(task, dict) else []
    places = {name: document.key_at("task", name) for name in names}
    return {name: at.line for name, at in places.items() if isinstance(at, Location)}
