"""Recognizes files that look like missions but are not: worlds, ground station plans, drawings.

The first characters are enough to tell what a file is; nothing is parsed.
"""

from __future__ import annotations

import re

from companion.documents import Source
from companion.errors import Location, MissionError
from companion.mission.world_files import mission_of

_BEGIN = 2000  # characters
_PLANS = {
    r"\s*QGC WPL \d": "a list of waypoints (QGC WPL)",
    r'\s*\{[\s\S]*"fileType"\s*:\s*"Plan"': "a plan of QGroundControl",
    r'\s*\{[\s\S]*"type"\s*:\s*"(FeatureCollection|Feature)"': "GeoJSON",
    r"\s*<(\?xml|kml)": "KML, or another XML",
}
"""How a file begins -> what it is; `companion import` reads these files."""


def refuse_other_files(source: Source) -> None:
    """Refuses a source that is certainly not a mission.

    Raises:
        MissionError: it is something else; the hint says what to do with it.
    """
    if not isinstance(source.content, str):
        return
    where, begin = Location(source.name, 1, 1), source.content[:_BEGIN]
    for pattern, kind in _PLANS.items():
        if re.match(pattern, begin):
            hint = f"companion import {source.name} -o NAME.yaml makes a mission of it"
            raise MissionError(f"the file is {kind}, and no mission", where, hint)
    if all(re.search(rf"^{key}:", begin, re.M) for key in ("image", "resolution", "origin")):
        hint = f"name it in a mission: map: {source.name}"
        raise MissionError("the file is a map, and no mission", where, hint)
    is_mission = re.search(r"^(task|skills|places):", begin, re.M)
    if (mission := mission_of(source.name)) and not is_mission:
        hint = f"companion sim {mission} flies the mission in it"
        raise MissionError("the file is the world of a mission", where, hint)
