"""Lists the files of a mission: itself, its map with the image, vehicle profile, PDDL files.

A door: it reads the mission and its map's YAML to find the names of the other files. A caller that
accepts missions from strangers passes the folder in which all files have to be; no other file is
opened.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from companion.documents import Document, read_source, validate
from companion.errors import MissionError
from companion.maps import image_of
from companion.mission.other_files import refuse_other_files
from companion.mission.schema import MissionFile
from companion.vehicle_files import profile_path


def files_of(path: Path, within: Path) -> tuple[Path, ...]:
    """Returns the files that a mission needs, itself last.

    path: the mission file.
    within: the folder in which all files have to be.

    Raises:
        MissionError: the mission or its map cannot be read, or a file lies outside the folder.
    """
    source = read_source(path, "mission")
    refuse_other_files(source)
    file, document = validate(source.content, source.name, MissionFile)
    others: list[Path] = []
    if isinstance(file.map, str):
        others += _map_files(path.parent, file.map, within, document)
    profile = profile_path(file.vehicle.profile, path.parent)
    if profile.is_file():
        others.append(profile)
        _check_within(profile, within, f"the vehicle {profile.stem}", document, ["vehicle"])
    for key, name in (("domain", file.domain), ("problem", file.problem)):
        if name is not None:
            others.append(path.parent / name)
            _check_within(others[-1], within, name, document, [key])
    return (*others, path)


def _map_files(folder: Path, name: str, within: Path, document: Document) -> tuple[Path, Path]:
    """Returns the image of a map file, and the map file itself."""
    path = folder / name
    _check_within(path, within, name, document, ["map"])
    try:
        image = image_of(path)
    except MissionError as error:
        if error.where is not None:
            raise
        raise MissionError(error.what, document.where("map"), error.hint) from error
    _check_within(image, within, f"the image of {name}", document, ["map"])
    return image, path


def _check_within(
    path: Path, within: Path, name: str, document: Document, keys: Sequence[str]
) -> None:
    if not path.resolve().is_relative_to(within.resolve()):
        raise MissionError(
            f"{name} lies outside the mission's folder",
            document.where(*keys),
            "what a mission needs has to be beside it or in folders there",
        )
