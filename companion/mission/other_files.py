"""Files that are taken for missions and are none: worlds, plans of ground stations, drawings.

The first characters tell what a file is; nothing is read.
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
"""How a file begins -> what it is; `companion import` reads these."""


def refuse_other_files(source: Source) -> None:
    """Refuses what is certainly no mission.

    Raises:
        MissionError: it is something else; with what to do with that.
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
