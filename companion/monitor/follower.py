"""What happens in a run, in order: its folder read as it grows, or from beginning to end.

Everything shown comes out of what the run recorded. Four things are derived here and join the
run's own events under kinds of their own:

- `automata`: the task's automata, with the first plan
- `states`: where they may be, with each position of the word
- `path`: the way along which the plan leads, on the map as it was known then, with its tree
- `cells`: cells that have become occupied or free by what the lidar saw
"""

from __future__ import annotations

import base64
import math
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from companion.errors import CompanionError
from companion.geometry import Ned, enu_from_ned
from companion.ltl.parser import parse
from companion.monitor.automata import TaskReader
from companion.monitor.scene import Scene, read_scene
from companion.monitor.tailing import EventLines, TlogFrames
from companion.monitor.watching import Snapshot, Watcher
from companion.motion.grid import OccupancyGrid
from companion.motion.routes import RouteMap
from companion.record.events import EVENTS

PERIOD_S = 0.2
"""Between snapshots, in the flight's time."""
SHADE_LIMIT_M = 3.0
"""Distance to the next obstacle from which on a cell is white."""
_ROUNDING_S = 1e-3

Event = dict[str, Any]
"""A line of events.jsonl, or one of the same form that is derived here."""


class Follower:
    """One run.

    Attributes:
        mission: what does not change: names, map, places.
        events: what happened so far.
        snapshots: the vehicle so far, 5 for each second of its time.

    Args:
        folder: the run folder.
        is_live: whether the run still goes on.

    Raises:
        MissionError: it has no scene, or a damaged one.
    """

    def __init__(self, folder: Path, is_live: bool) -> None:
        scene = read_scene(folder)
        self.mission = _mission(scene, folder.name, is_live)
        self.events: list[Event] = []
        self.snapshots: list[Snapshot] = []
        self._scene = scene
        self._lines = EventLines(folder / EVENTS)
        self._frames = TlogFrames(folder / "flight.tlog")
        self._waiting: deque[Event] = deque()
        self._watcher = Watcher(scene.grid)
        self._grid = scene.grid
        self._routes = RouteMap(scene.grid, scene.sites, scene.fence, scene.clearance_m)
        self._task: TaskReader | None = None
        self._is_written = False  # the tree is the mission's own, and no way is planned
        self._next_s = 0.0
        self._is_live = is_live
        self._settled_s = -math.inf if is_live else math.inf

    def read(self) -> bool:
        """Takes what is new; whether more can be read at once.

        An event reaches the disk before the frames of its time. So while the run goes on, events
        that are ahead of the frames wait for them, until the next call at most.
        """
        self._waiting.extend(self._lines.news())
        batches, is_more = self._frames.news()
        for unix_s, frames in batches:
            now_s = unix_s - self._scene.start_unix_s
            self._happen(now_s - _ROUNDING_S)
            self._watcher.hear(now_s, frames)
            if now_s >= self._next_s - _ROUNDING_S:
                self._look(now_s)
        if not is_more:
            self._happen(self._settled_s)
            if self._is_live:
                self._settled_s = self._waiting[-1]["t_s"] + _ROUNDING_S if self._waiting else 0.0
        return is_more

    def _look(self, now_s: float) -> None:
        self._next_s = (now_s + _ROUNDING_S) // PERIOD_S * PERIOD_S + PERIOD_S
        snapshot = self._watcher.snapshot(now_s)
        if snapshot is not None:
            self.snapshots.append(snapshot)
        if self._watcher.grid is not self._grid:
            changed = self._watcher.grid.occupied != self._grid.occupied
            cells = [
                [int(row), int(col), bool(self._watcher.grid.occupied[row, col])]
                for row, col in np.argwhere(changed)
            ]
            self._grid = self._watcher.grid
            self._routes.see(self._grid)
            self.events.append({"t_s": round(now_s, 3), "kind": "cells", "cells": cells})

    def _happen(self, until_s: float) -> None:
        """Tells the events up to a time, each with what is derived from it."""
        while self._waiting and self._waiting[0]["t_s"] < until_s:
            event = self._waiting.popleft()
            self.events.append(event)
            try:
                derived = list(self._derived(event))
            except (CompanionError, KeyError, TypeError, ValueError, AttributeError):
                continue  # a line that is not as documented; `companion audit` says where
            self.events += [{"t_s": event["t_s"], **more} for more in derived]

    def _derived(self, event: Event) -> Iterator[Event]:
        match event["kind"]:
            case "plan":
                self._is_written = "loop" not in event
                self._task = TaskReader({n: parse(text) for n, text in event["task"].items()})
                drawings = [drawing.as_json() for drawing in self._task.drawings]
                yield {"kind": "automata", "automata": drawings}
                yield {"kind": "states", "states": self._task.states}
            case "position" if self._task is not None:
                self._task.read(frozenset(event["facts"]), event["restarted"])
                yield {"kind": "states", "states": self._task.states}
            case "symbol":
                north, east, down = map(float, event["position"])
                self._routes.aim(event["place"], (north, east, down))
            case "tree" if not self._is_written:
                yield {"kind": "path", "legs": self._legs(event["nodes"])}

    def _legs(self, nodes: list[dict[str, Any]]) -> list[list[list[float]]]:
        """The way of each action that flies somewhere: corners, east and north."""
        at: Ned | None = self._watcher.position
        legs = []
        for node in nodes:
            place = node.get("destination")
            if at is not None and place in self._scene.sites:
                route = self._routes.route(at, place)
                corners = route.waypoints if route else np.array([at])
                legs.append([[round(e, 2), round(n, 2)] for n, e, _ in corners.tolist()])
                at = tuple(corners[-1].tolist())
        return legs


def _mission(scene: Scene, run: str, is_live: bool) -> dict[str, Any]:
    grid = scene.grid
    rows, cols = grid.occupied.shape
    return {
        "run": run,
        "name": scene.name,
        "is_live": is_live,
        "period_s": PERIOD_S,
        "map": {
            "rows": rows,
            "cols": cols,
            "cell_m": grid.cell_m,
            "east_m": grid.origin[1],
            "north_m": grid.origin[0],
            "shade": base64.b64encode(_shade(grid).tobytes()).decode("ascii"),
        },
        "fence": [[east, north] for north, east in scene.fence],
        "places": [
            {"name": name, "enu": enu_from_ned(site.position), "radius_m": site.radius_m}
            for name, site in scene.sites.items()
        ],
    }


def _shade(grid: OccupancyGrid) -> npt.NDArray[np.uint8]:
    """(rows, cols) 0 on obstacles, 1 to 255 from near to far; the northmost row first."""
    far = np.clip(grid.distance_m / SHADE_LIMIT_M, 0.0, 1.0)
    return np.where(grid.occupied, 0, 1 + 254 * far).astype(np.uint8)[::-1]
