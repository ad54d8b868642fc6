"""Reads maps: which cells of the world are occupied, as far as the mission says.

The format is that of ROS map_server (wiki.ros.org/map_server, nav2_map_server): a YAML file that
names an image (PGM or PNG) and the meaning of its grey values, in mode `trinary`. In the map's
frame, x is east and y is north of home; the image's top row is the northmost.

A door: it opens the files of a path. Left out: rotated maps, the modes `scale` and `raw`, and
images with more than 8 bits. A pixel that is not opaque is unknown, and unknown cells count as
occupied. Like map_server, it ignores unknown keys.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from companion.errors import Location, MissionError
from companion.motion.grid import OccupancyGrid

MAX_EDGE_CELLS = 4000
MAX_CELLS = 4_000_000
MANY = 1e9
"""Number of cells above which the exact number is not computed."""
MAX_YAML_BYTES = 64 * 1024  # a map's YAML has seven lines; a larger file is none

_NO_MAP = (
    "name the YAML file beside the map's image; names are relative to the file that names it\n"
    "without a map file draw the walls, map: {east_m: [0, 9], north_m: [0, 9], walls: []}, or "
    "leave map: out"
)
_GREY_MODES = ("1", "L", "LA", "P", "RGB", "RGBA")  # Pillow's names of modes with at most 8 bits


def read_map(path: Path) -> OccupancyGrid:
    """The occupancy grid of a map file.

    Args:
        path: the YAML file, to which its image is relative.

    Raises:
        MissionError: a file is missing or unreadable, or map_server does not allow a value; names
            the line if it is known.
    """
    fields = _Fields(path)
    resolution_m = fields.number("resolution", 0.001, 100.0)
    east_m, north_m = fields.origin()
    if fields.value("negate") not in (0, 1):
        raise fields.error("negate", "negate is neither 0 nor 1")
    free_below = fields.number("free_thresh", 0.0, 1.0)
    occupied_above = fields.number("occupied_thresh", 0.0, 1.0)
    if free_below > occupied_above:
        raise fields.error("free_thresh", "free_thresh is greater than occupied_thresh")
    if fields.values.get("mode", "trinary") != "trinary":
        raise fields.error("mode", "the map's mode is not trinary", "Only `trinary` is supported.")
    grey, is_opaque = _pixels(fields)
    occupancy = grey / 255 if fields.value("negate") else (255 - grey) / 255
    is_free = (occupancy < free_below) & is_opaque
    return OccupancyGrid(np.ascontiguousarray(~is_free[::-1]), resolution_m, (north_m, east_m))


def check_cells(east: int, north: int, remedy: str = "use larger cells") -> None:
    """Refuses a map that would take too much memory."""
    if east * north > MAX_CELLS:
        what = f"the map has {east} x {north} cells, at most {MAX_CELLS:,} are allowed"
        raise MissionError(what, hint=remedy)


def image_of(path: Path) -> Path:
    """The image that a map file names; it need not exist.

    Raises:
        MissionError: the map file is missing or unreadable, or names none.
    """
    return _image(_Fields(path))


class _Fields:
    """The keys of a map's YAML file, with their lines."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.values = _yaml_mapping(path)

    def error(self, key: str, what: str, hint: str = "") -> MissionError:
        """The error for a key's value."""
        line, column = self.values.lc.value(key)
        return MissionError(what, Location(str(self.path), line + 1, column + 1), hint)

    def value(self, key: str) -> Any:
        """The value of a required key."""
        if key not in self.values:
            raise MissionError(
                f"the map has no `{key}`",
                Location(str(self.path), 1, 1),
                "A map has image, resolution, origin, negate, occupied_thresh and free_thresh.",
            )
        return self.values[key]

    def number(self, key: str, least: float, most: float) -> float:
        """A number between two bounds."""
        value = self.value(key)
        if not _is_number(value) or not least <= value <= most:
            raise self.error(key, f"{key} is {value!r}, not a number from {least:g} to {most:g}")
        return float(value)

    def origin(self) -> tuple[float, float]:
        """East and north of the map's south-west corner, metres."""
        value = self.value("origin")
        if not isinstance(value, list) or len(value) != 3 or not all(map(_is_number, value)):
            raise self.error("origin", "origin is not a list of three numbers: [x, y, yaw]")
        if value[2] != 0:
            raise self.error(
                "origin",
                f"the map is rotated by {value[2]:g} rad",
                "Only yaw 0 is supported: x is east and y is north.",
            )
        return float(value[0]), float(value[1])


def _is_number(value: object) -> bool:
    """Whether a value is a finite number of a size that a map can have."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9


def _yaml_mapping(path: Path) -> CommentedMap:
    """The top level of a YAML file.

    Raises:
        MissionError: the file cannot be read, is no YAML, or is not a mapping.
    """
    try:
        if path.stat().st_size > MAX_YAML_BYTES:
            raise MissionError(f"{path} is too large for a map's YAML file")
        values = YAML(typ="rt", pure=True).load(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        hint = "name the YAML file beside the image, which says how large its cells are"
        raise MissionError(f"the map {path} is not a text", hint=hint) from error
    except OSError as error:
        reason = error.strerror or error
        raise MissionError(f"the map {path} cannot be read: {reason}", hint=_NO_MAP) from error
    except MarkedYAMLError as error:
        mark = error.problem_mark
        where = Location(str(path), mark.line + 1, mark.column + 1) if mark else None
        raise MissionError(f"the map is no YAML: {error.problem}", where) from error
    except (YAMLError, RecursionError, ValueError) as error:
        raise MissionError(f"the map {path} is no YAML: {error}") from error
    if not isinstance(values, CommentedMap):
        raise MissionError("the map is not a YAML mapping", Location(str(path), 1, 1))
    return values


def _image(fields: _Fields) -> Path:
    name = fields.value("image")
    if not isinstance(name, str) or not name:
        raise fields.error("image", "image is not a file name")
    return fields.path.parent / name


def _pixels(fields: _Fields) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Grey values 0 to 255 and which pixels are opaque; (rows, cols), row 0 northmost.

    Raises:
        MissionError: the image is missing, too large, or of an unknown kind.
    """
    path = _image(fields)
    try:
        if not path.is_file():
            raise fields.error("image", f"there is no image {path}")
        with Image.open(path, formats=("PPM", "PNG")) as image:
            if max(image.size) > MAX_EDGE_CELLS or min(image.size) < 1:
                raise fields.error(
                    "image",
                    f"the image has {image.width} x {image.height} cells",
                    f"At most {MAX_EDGE_CELLS} cells along an edge; use a coarser resolution.",
                )
            try:
                check_cells(*image.size)
            except MissionError as error:
                raise fields.error("image", error.what, error.hint) from None
            if image.mode not in _GREY_MODES:
                raise fields.error("image", f"the image has pixels of kind {image.mode}, not 8 bit")
            rgba = np.asarray(image.convert("RGBA"))
    except (UnidentifiedImageError, Image.DecompressionBombError) as error:
        raise fields.error("image", f"{path} is not a usable PGM or PNG image") from error
    except (OSError, ValueError, SyntaxError) as error:  # Pillow raises these on broken images
        raise fields.error("image", f"the image {path} cannot be read: {error}") from error
    return rgba[..., :3].mean(axis=2), rgba[..., 3] == 255
