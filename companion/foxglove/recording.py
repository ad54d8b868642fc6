"""A recorded run as messages of Foxglove, in the order of their times.

    /vehicle/pose, /vehicle/location, /tf    the vehicle's position, five times a second
    /setpoint    the last setpoint
    /plan    the route of the present plan, whenever there is a new one
    /scene    walls, fence, zones and places; the autopilot's own fence if it is kept;
           what else the lidar saw
    /map    the same on the earth, as GeoJSON, with the whole flight
    /log    events, in words

The content is that of the monitor page, read by the same code (`monitor/follower.py`).
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from companion.flight_events.event import FlightEvent
from companion.flight_events.fence import FenceKept
from companion.foxglove.messages import (
    LogMessage,
    location,
    pose_in_map,
    poses_in_map,
    vehicle_in_map,
)
from companion.foxglove.scenery import ABOVE_M, kept, seen, world
from companion.geometry import GlobalOrigin
from companion.ground.texts import CRITICAL, DEBUG, ERROR, WARNING, severity
from companion.monitor.follower import Follower
from companion.monitor.page_events import CellsChanged, DerivedEvent
from companion.monitor.scene import Scene, read_scene
from companion.monitor.tailing import CHUNK_BYTES

EVENTS_FILE = "events.jsonl"
SEEN_EVERY_S = 1.0
LEVELS = {DEBUG: 1, WARNING: 3, ERROR: 4, CRITICAL: 5}
"""MAV_SEVERITY -> level of Log; 2, INFO, for all others."""
OnProgress = Callable[[int], None]
"""Called with the number of bytes of the flight that have been read."""


class RecordedRun:
    """A finished run, read from its folder.

    Args:
        folder: the folder of the run.
        zero: where the frame `map` lies on the earth, if known.
        geojson: the content on the earth, if known.
        progress: called with the number of bytes read.

    Attributes:
        start_unix_ns: when the run began.

    Raises:
        MissionError: it cannot be shown.
    """

    def __init__(
        self, folder: Path, zero: GlobalOrigin | None, geojson: str | None, progress: OnProgress
    ) -> None:
        self._scene: Scene = read_scene(folder)
        self.start_unix_ns = round(self._scene.start_unix_s * 1e9)
        self._zero, self._geojson = zero, geojson
        self._follower = Follower(folder, is_live=False)
        while self._follower.read():
            progress(CHUNK_BYTES)

    def messages(self) -> Iterator[LogMessage]:
        """All messages, in order."""
        yield LogMessage(0.0, "/scene", "foxglove.SceneUpdate", world(self._scene))
        if self._geojson is not None:
            yield LogMessage(0.0, "/map", "foxglove.GeoJSON", {"geojson": self._geojson})
        parts = (self._flight(), self._plans(), self._logs(), self._kept(), self._seen())
        yield from heapq.merge(*parts, key=lambda message: message.time_s)

    def _flight(self) -> Iterator[LogMessage]:
        for snapshot in self._follower.snapshots:
            now_s, here, yaw = snapshot.time_s, snapshot.position, snapshot.yaw_rad
            yield LogMessage(now_s, "/vehicle/pose", "foxglove.PoseInFrame", pose_in_map(here, yaw))
            yield LogMessage(now_s, "/tf", "foxglove.FrameTransform", vehicle_in_map(here, yaw))
            if self._zero is not None:
                fix = location(*self._zero.to_global(here))
                yield LogMessage(now_s, "/vehicle/location", "foxglove.LocationFix", fix)
            if snapshot.setpoint is not None:
                asked = pose_in_map(snapshot.setpoint)
                yield LogMessage(now_s, "/setpoint", "foxglove.PoseInFrame", asked)

    def _plans(self) -> Iterator[LogMessage]:
        for time_s, route in self._follower.planned_routes:
            yield LogMessage(time_s, "/plan", "foxglove.PosesInFrame", poses_in_map(route))

    def _logs(self) -> Iterator[LogMessage]:
        line = 0
        for stamped in self._follower.events:
            if isinstance(stamped.event, DerivedEvent):
                continue
            line += 1
            if stamped.event.is_told:
                content = _log(stamped.event, line)
                yield LogMessage(stamped.time_s, "/log", "foxglove.Log", content)

    def _kept(self) -> Iterator[LogMessage]:
        """The fence that the autopilot keeps, but that is not the mission's, once it is known."""
        for stamped in self._follower.events:
            if isinstance(stamped.event, FenceKept):
                areas = kept(self._scene, stamped.event)
                yield LogMessage(stamped.time_s, "/scene", "foxglove.SceneUpdate", areas)

    def _seen(self) -> Iterator[LogMessage]:
        """What the lidar saw, at most once in SEEN_EVERY_S, and at the end."""
        grid, due_s, time_s, is_told = self._scene.grid, 0.0, 0.0, True
        occupied = np.zeros_like(grid.occupied)
        top_m = ABOVE_M + max((-s.position[2] for s in self._scene.sites.values()), default=0.0)
        for stamped in self._follower.events:
            if not isinstance(stamped.event, CellsChanged):
                continue
            time_s, is_told = stamped.time_s, False
            for row, col, is_occupied in stamped.event.cells:
                occupied[row, col] = is_occupied
            if time_s >= due_s:
                due_s, is_told = time_s + SEEN_EVERY_S, True
                yield LogMessage(
                    time_s, "/scene", "foxglove.SceneUpdate", seen(grid, occupied, top_m)
                )
        if not is_told:
            yield LogMessage(time_s, "/scene", "foxglove.SceneUpdate", seen(grid, occupied, top_m))


def _log(event: FlightEvent, line: int) -> dict[str, object]:
    return {
        "level": LEVELS.get(severity(event), 2),
        "message": event.text,
        "name": event.kind,
        "file": EVENTS_FILE,
        "line": line,
    }
