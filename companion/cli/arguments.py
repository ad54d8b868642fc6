"""Arguments that several commands have, and what they stand for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from companion.mission.model import Mission

MissionFile = Annotated[Path, typer.Argument(metavar="MISSION", help="The mission's YAML file.")]


def load(path: Path) -> Mission:
    """The mission of a file."""
    from companion.mission.loader import load_mission

    return load_mission(path)
