"""How a mission file and the file of its simulated world are called: NAME.yaml, NAME.sim.yaml.

Both may end with .yml as well. Nothing is read.
"""

from __future__ import annotations

from pathlib import Path

YAML = (".yaml", ".yml")
"""How a YAML file ends."""
WORLD = tuple(f".sim{ending}" for ending in YAML)
"""How the file of a world ends."""


def worlds_beside(mission: Path) -> list[Path]:
    """The files that may be a mission's world; first the one that ends as the mission does.

    >>> [path.name for path in worlds_beside(Path("hall.yml"))]
    ['hall.sim.yml', 'hall.sim.yaml']
    """
    endings = sorted(WORLD, key=lambda ending: not ending.endswith(mission.suffix))
    return [mission.with_suffix(ending) for ending in endings]


def mission_of(world: str) -> str:
    """The mission file whose world a file is; "" if it is called as none.

    >>> mission_of("hall.sim.yml"), mission_of("hall.yaml")
    ('hall.yml', '')
    """
    ending = next((ending for ending in WORLD if world.endswith(ending)), "")
    return world.removesuffix(ending) + ending.removeprefix(".sim") if ending else ""


def missions_in(folder: Path) -> list[Path]:
    """The YAML files in a folder that are no worlds, sorted."""
    found = (path for ending in YAML for path in folder.glob(f"*{ending}"))
    return sorted(path for path in found if not path.name.endswith(WORLD))
