"""The names of a mission file and of its simulated world's file: NAME.yaml, NAME.sim.yaml.

Both may end with .yml as well. No file is read.
"""

from __future__ import annotations

from pathlib import Path

YAML = (".yaml", ".yml")
"""The endings of a YAML file."""
WORLD = tuple(f".sim{ending}" for ending in YAML)
"""The endings of the file of a world."""


def worlds_beside(mission: Path) -> list[Path]:
    """The possible world files of a mission; the one with the mission's own ending comes first.

    >>> [path.name for path in worlds_beside(Path("hall.yml"))]
    ['hall.sim.yml', 'hall.sim.yaml']
    """
    endings = sorted(WORLD, key=lambda ending: not ending.endswith(mission.suffix))
    return [mission.with_suffix(ending) for ending in endings]


def mission_of(world: str) -> str:
    """The mission file that belongs to a world file; "" if the name is not that of a world.

    >>> mission_of("hall.sim.yml"), mission_of("hall.yaml")
    ('hall.yml', '')
    """
    ending = next((ending for ending in WORLD if world.endswith(ending)), "")
    return world.removesuffix(ending) + ending.removeprefix(".sim") if ending else ""


def missions_in(folder: Path) -> list[Path]:
    """The YAML files in a folder that are not worlds, sorted."""
    found = (path for ending in YAML for path in folder.glob(f"*{ending}"))
    return sorted(path for path in found if not path.name.endswith(WORLD))
