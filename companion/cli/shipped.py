"""The missions that come with the program, by name.

They are beside the packages in a checkout, and among the data files of an installed program.
"""

from __future__ import annotations

from difflib import get_close_matches
from glob import escape, glob
from pathlib import Path

import companion
from companion.errors import MissionError
from companion.mission.world_files import YAML, missions_in

DISTRIBUTION = "mav-companion"
"""The name in pyproject.toml, which is also the only place of the version."""
_FOLDER = "missions"
_ONE_OF_THEM = "surveillance.yaml"


def folder() -> Path | None:
    """The folder of the shipped missions; None if they were not installed."""
    beside = Path(companion.__file__).parents[1] / _FOLDER
    if (beside / _ONE_OF_THEM).is_file():
        return beside
    from importlib import metadata

    try:
        files = metadata.files(DISTRIBUTION) or ()
    except metadata.PackageNotFoundError:
        return None
    found = (file for file in files if file.name == _ONE_OF_THEM and file.parent.name == _FOLDER)
    return next((Path(str(file.locate())).resolve().parent for file in found), None)


def names() -> list[str]:
    """The shipped missions, sorted."""
    lies_in = folder()
    return [path.stem for path in missions_in(lies_in)] if lies_in is not None else []


def completions(begun: str) -> list[str]:
    """What a shell may complete a MISSION to: names, YAML files, and folders."""
    paths = [f"{path}/" if Path(path).is_dir() else path for path in glob(f"{escape(begun)}*")]
    files = [path for path in paths if path.endswith(("/", *YAML))]
    return [name for name in names() if name.startswith(begun)] + sorted(files)


def mission_file(text: str) -> Path:
    """The file of a MISSION argument: a path, or the name of a shipped mission.

    Raises:
        MissionError: it is neither; the text lists the names.
    """
    path, lies_in = Path(text), folder()
    if path.exists() or lies_in is None:
        return path
    shipped = names()
    if text in shipped:
        return lies_in / f"{text}.yaml"
    files = [str(file) for file in missions_in(path.parent)]
    unended = [file for file in files if Path(file).stem == path.name]
    near = unended or get_close_matches(text, files, n=1)
    near = near or get_close_matches(path.stem, shipped, n=1)
    meant = f"did you mean {near[0]}? " if near else ""
    advice = f"{meant}companion new NAME writes one; these are shipped: {', '.join(shipped)}"
    raise MissionError(f"there is no file {text}", hint=advice)
