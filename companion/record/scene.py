"""What the mission says of the world, as the run folder keeps it: scene.json.

With it a run can be shown without the map and PDDL files that its mission.yaml refers to. Lengths
are metres, east, north and up of the home position; the map's rows run from south to north.
"""

from __future__ import annotations

import base64
import zlib

import numpy as np

from companion.geometry import enu_from_ned
from companion.mission.facts import at
from companion.mission.model import Mission


def scene(mission: Mission, start_unix_s: float) -> dict[str, object]:
    """Values that JSON can hold.

    Args:
        start_unix_s: when the run began; flight.tlog has the same clock.
    """
    mentioned = mission.task_facts
    grid = mission.grid
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
            "occupied": base64.b64encode(zlib.compress(cells)).decode("ascii"),
        },
        "clearance_m": mission.vehicle.clearance_m,
        "fence": [[east, north] for north, east in mission.limits.fence],
        "places": [
            {
                "name": place.name,
                "enu": enu_from_ned(place.position),
                "radius_m": place.radius_m,
                "in_task": at(place.name) in mentioned,
            }
            for place in mission.places.values()
        ],
    }
