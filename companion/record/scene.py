"""What the mission says about the world, as stored in the run folder: scene.json.

It allows to show a run without the map and PDDL files that its mission.yaml names. Lengths are
metres, east, north and up from home; the map's rows run from south to north.
"""

from __future__ import annotations

import base64
import zlib
from dataclasses import asdict

import numpy as np

from companion.geometry import enu_from_ned
from companion.mission.facts import at
from companion.mission.model import Mission
from companion.motion.region import Region


def scene(mission: Mission, start_unix_s: float) -> dict[str, object]:
    """The scene, in values that JSON can hold.

    Args:
        start_unix_s: when the run began, by the clock that stamps flight.tlog.
    """
    mentioned = mission.task_facts
    grid, anchor = mission.grid, mission.anchor
    cells = np.packbits(grid.occupied).tobytes()
    return {
        "name": mission.name,
        "start_unix_s": start_unix_s,
        "map": {
            "rows": grid.occupied.shape[0],
            "cols": grid.occupied.shape[1],
            "cell_m": grid.cell_m,
            "east_m": grid.origin[1],
            "north_m": grid.origin[0],
            "open": grid.is_open,
            "occupied": base64.b64encode(zlib.compress(cells)).decode("ascii"),
        },
        "anchor": anchor and [anchor.latitude_deg, anchor.longitude_deg],
        "low_walls": [wall.as_entry() for wall in mission.walls if wall.up_m is not None],
        "speed_limits": asdict(mission.speed_limits),
        "clearance_m": mission.vehicle.clearance_m,
        "up_m": list(mission.limits.up_m),
        "fence": [[east, north] for north, east in mission.limits.fence],
        "keep_out": {
            name: [[east, north] for north, east in zone]
            for name, zone in mission.limits.keep_out.items()
        },
        "places": [
            {
                "name": place.name,
                "enu": enu_from_ned(place.position),
                **_outline(place.region),
                "in_task": at(place.name) in mentioned and not place.found_by,
            }
            for place in mission.places.values()
        ],
    }


def _outline(region: Region) -> dict[str, object]:
    """The region of a place: its radius or its corners."""
    if (corners := region.outline()) is None:
        return {"radius_m": region.inner_m((0.0, 0.0, 0.0))}
    return {"corners": [[east, north] for north, east in corners]}
