"""Reads files of ground stations and mapping tools, and writes missions from them.

A door: it opens the file of a path. The file's ending determines its reader; if the ending is
ambiguous, its first characters do.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from companion.arguments import check_kind, path_of
from companion.errors import KeyPath, MissionError
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.planning.low_places import low_among, too_low
from companion.plans.commands import PAYLOADS
from companion.plans.draft import Draft, draft
from companion.plans.draft_places import OTHER_HOME, Given
from companion.plans.geojson import read_geojson
from companion.plans.kml import read_kml, read_kmz
from companion.plans.mission_text import mission_text
from companion.plans.qgc_plan import read_plan
from companion.plans.route_plan import ItemRefused, ItemsRefused, RoutePlan, refusal_of
from companion.plans.wpl import is_fence, read_fence, read_wpl

MAX_BYTES = 4_000_000
"""A plan of 800 waypoints has 0.4 MB."""
KNOWN = ".plan, .mission, .waypoints, .txt (QGC WPL 110, or a fence), .geojson, .json, .kml, .kmz"
FOREIGN = {
    ".shp": "a shapefile; save it as GeoJSON",
    ".gpx": "a GPS track; save it as GeoJSON, as a line of few points",
    ".yaml": "no plan; a mission is flown as it is: companion run",
    ".yml": "no plan; a mission is flown as it is: companion run",
}

Reader = Callable[[bytes, frozenset[str]], RoutePlan]


def import_plan(
    path: Path | str, given: Given, leave_out: frozenset[str] = frozenset(), name: str = ""
) -> tuple[str, Draft]:
    """The YAML text of the mission that a file describes, which can be flown, and its draft.

    Args:
        path: the path of the file.
        given: what the file does not say.
        leave_out: numbers of items that are not imported.
        name: the name of the mission; by default the name of the file.

    Raises:
        MissionError: it cannot be read, or a mission cannot express it; names the item.
        CompanionError: an argument has a wrong type or value.
    """
    check_kind(given, Given, "what the file does not say, as Given has it")
    path = path_of(path, "the path of a plan")
    try:
        plan = _reader(path)(_bytes(path), leave_out)
        drafted = draft(plan, given, name or _name(path))
    except ItemRefused as refused:
        raise refusal_of(str(path), [refused]) from None
    except ItemsRefused as refused:
        raise refusal_of(str(path), refused.refused) from None
    mission = _check(drafted, path)
    if low := low_among(mission, mission.sets["Place"]):
        drafted.notes.append(f"{', '.join(map(str, low))}: {too_low(mission.vehicle)}")
    text = mission_text(drafted, f"{path.name}, {plan.kind}")
    load_mission(text)
    return text, drafted


def _name(path: Path) -> str:
    spelt = re.sub(r"[^A-Za-z0-9_-]+", "_", path.name.partition(".")[0]).strip("_-")[:40]
    return spelt or "imported"


def _check(drafted: Draft, path: Path) -> Mission:
    """The mission, if it can be flown as it is; problems are named by the items of the plan."""
    try:
        return load_mission(drafted.data)
    except MissionError as error:
        keys = error.where.keys if isinstance(error.where, KeyPath) else ()
        starts = (tuple(map(str, keys[:length])) for length in (2, 3))
        item = next((drafted.items[start] for start in starts if start in drafted.items), "")
        where = item or (str(error.where) if error.where else "")
        hint = f"{error.hint},\nor {OTHER_HOME}" if item == "home" else error.hint
        raise refusal_of(str(path), [ItemRefused(where, error.what, hint)]) from None


def _bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise MissionError(f"the plan {path} cannot be read: {reason}") from error
    if len(data) > MAX_BYTES:
        raise ItemRefused("", f"is larger than {MAX_BYTES} bytes", "is this the right file?")
    return data


def _reader(path: Path) -> Reader:
    ending = path.suffix.lower()
    if ending in FOREIGN:
        raise ItemRefused("", f"is {FOREIGN[ending]}")
    if ending not in READERS:
        raise ItemRefused("", f"is of an unknown kind {ending!r}", f"known are {KNOWN}")
    return READERS[ending]


def _text(data: bytes) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ItemRefused("", f"is not UTF-8 text at byte {error.start}", "save it anew") from None


def _plan(data: bytes, leave_out: frozenset[str]) -> RoutePlan:
    """Reads a .plan or .mission file."""
    text = _text(data)
    if text.lstrip().startswith("<"):
        raise ItemRefused("", "is XML, and no mission of QGroundControl", "save it in QGC again")
    if text.startswith("QGC WPL"):
        return read_wpl(text, leave_out)
    return read_plan(text, leave_out)


def _lines(data: bytes, leave_out: frozenset[str]) -> RoutePlan:
    """Reads a file of lines."""
    text = _text(data)
    if is_fence(text):
        return _drawn(lambda _: read_fence(text))(data, leave_out)
    return read_wpl(text, leave_out)


def _drawn(read: Callable[[bytes], RoutePlan]) -> Reader:
    """The reader of a file without items."""

    def reader(data: bytes, leave_out: frozenset[str]) -> RoutePlan:
        if leave_out - {PAYLOADS}:
            what = f"has no items with numbers, so that {min(leave_out)[:20]!r} cannot be left out"
            raise ItemRefused("", what, "remove the shape in the program that has drawn it")
        return read(data)

    return reader


READERS: dict[str, Reader] = {
    ".plan": _plan,
    ".mission": _plan,
    ".waypoints": _lines,
    ".txt": _lines,
    ".geojson": _drawn(lambda data: read_geojson(_text(data))),
    ".json": _drawn(lambda data: read_geojson(_text(data))),
    ".kml": _drawn(read_kml),
    ".kmz": _drawn(read_kmz),
}
