"""Follows a run in order: its folder read as it grows, or from beginning to end.

Everything that is shown follows from what the run recorded. Some events are derived here and join
the run's own (page_events.py): the task's automata with the first plan, their present nodes with
each position of the word, the route of a plan with its tree, and the cells that the lidar saw, at
their times.
"""

from __future__ import annotations

import base64
import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from companion.errors import CompanionError
from companion.flight_events.catalogue import FOR_PROGRAMS
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.fence import FenceKept
from companion.flight_events.plans import (
    LineDropped,
    LineTakenUp,
    PlanMade,
    TaskRecalled,
    WrittenTreeAdopted,
)
from companion.flight_events.skills import ClearanceChanged, SymbolMoved
from companion.flight_events.tree import ActionTreeNode, TreeBuilt
from companion.flight_events.word import PositionLeft
from companion.geometry import Ned, NorthEast, enu_from_ned
from companion.ltl.parser import parse_line
from companion.monitor.automata import TaskReader
from companion.monitor.page_events import (
    DERIVED,
    AutomataDrawn,
    CellsChanged,
    Leg,
    RoutePlanned,
    SeenCell,
)
from companion.monitor.scene import Scene, read_scene
from companion.monitor.tailing import EventLines, TlogFrames
from companion.monitor.watching import Snapshot, Watcher
from companion.motion.grid import OccupancyGrid
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.routes import PlaceRegion
from companion.record.events import EVENTS_FILE

PERIOD_S = 0.2
"""Time between snapshots, by the flight's clock."""
SHADE_LIMIT_M = 3.0
"""A cell farther than this from the next obstacle is white."""
_ROUNDING_S = 1e-3


class Follower:
    """One run.

    Attributes:
        mission: what does not change: names, map, places.
        events: what happened so far.
        snapshots: the vehicle so far, 5 per second of flight time.
        ways: the routes of the plans, each with the time at which it begins.

    Args:
        folder: the run folder.
        is_live: whether the run still goes on.

    Raises:
        MissionError: it has no scene, or a damaged one.
    """

    def __init__(self, folder: Path, is_live: bool) -> None:
        scene = read_scene(folder)
        self.mission = _mission(scene, folder.name, is_live)
        self.events: list[Stamped] = []
        self.snapshots: list[Snapshot] = []
        self.planned_routes: list[tuple[float, tuple[Ned, ...]]] = []
        self._scene = scene
        self._lines = EventLines(folder / EVENTS_FILE)
        self._frames = TlogFrames(folder / "flight.tlog")
        self._waiting: deque[Stamped] = deque()
        self._watcher = Watcher(scene.grid, scene.anchor)
        self._grid = scene.grid
        self._routes = LayeredRoutes(
            scene.grid,
            scene.sites,
            scene.fence,
            scene.clearance_m,
            scene.speed_limits,
            keep_out=tuple(scene.keep_out.values()),
            up_m=scene.up_m,
        )
        self._task: TaskReader | None = None
        self._is_written = False  # the tree is the mission's own, without a planned route
        self._next_s = 0.0
        self._is_live = is_live
        self._settled_s = -math.inf if is_live else math.inf

    def read(self) -> bool:
        """Reads what is new; returns whether more can be read at once.

        An event reaches the disk before the frames of the same time. So during the run, events that
        are ahead of the frames wait for them, until the next call at most.
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
                self._settled_s = self._waiting[-1].time_s + _ROUNDING_S if self._waiting else 0.0
        return is_more

    def _look(self, now_s: float) -> None:
        self._next_s = (now_s + _ROUNDING_S) // PERIOD_S * PERIOD_S + PERIOD_S
        snapshot = self._watcher.snapshot(now_s)
        if snapshot is not None:
            self.snapshots.append(snapshot)
        if self._watcher.grid is not self._grid:
            changed = self._watcher.grid.occupied != self._grid.occupied
            cells = tuple(
                SeenCell(int(row), int(col), bool(self._watcher.grid.occupied[row, col]))
                for row, col in np.argwhere(changed)
            )
            self._grid = self._watcher.grid
            self._routes.see(self._grid)
            self.events.append(Stamped(round(now_s, 3), CellsChanged(cells)))

    def _happen(self, until_s: float) -> None:
        """Passes on the events up to a time, each with those derived from it."""
        while self._waiting and self._waiting[0].time_s < until_s:
            stamped = self._waiting.popleft()
            self.events.append(stamped)
            try:
                derived = list(self._derived(stamped.event, stamped.time_s))
            except (CompanionError, KeyError):
                continue  # an invalid formula or place; `companion audit` locates it
            self.events += [Stamped(stamped.time_s, event) for event in derived]

    def _derived(self, event: FlightEvent, time_s: float) -> Iterator[FlightEvent]:
        match event:
            case PlanMade(task=task) | WrittenTreeAdopted(task=task) | TaskRecalled(task=task):
                self._is_written = isinstance(event, WrittenTreeAdopted)
                self._task = TaskReader({name: parse_line(text) for name, text in task.items()})
                yield AutomataDrawn(tuple(each.drawing for each in self._task.automata))
                yield self._task.moved
            case PositionLeft() if self._task is not None:
                self._task.read(frozenset(event.facts), event.restarted)
                yield self._task.moved
            case LineDropped(line=line) | LineTakenUp(line=line) if self._task is not None:
                self._task.obligations.drop(line, isinstance(event, LineDropped))
                yield self._task.moved
            case ClearanceChanged():
                self._routes.add_clearance(event.clearance_m - self._scene.clearance_m)
            case FenceKept():
                fences, keep_out = filter(_is_area, event.within), filter(_is_area, event.keep_out)
                self._routes.keep_within(list(fences), list(keep_out))
            case SymbolMoved():
                self._routes.aim(event.place, event.position)
            case TreeBuilt() if not self._is_written:
                legs = list(self._legs(event))
                self.planned_routes.append(
                    (time_s, tuple(corner for leg in legs for corner in leg))
                )
                yield RoutePlanned(tuple(map(_on_the_page, legs)))

    def _legs(self, tree: TreeBuilt) -> Iterator[list[Ned]]:
        """The route of each action that flies somewhere."""
        at: Ned | None = self._watcher.position
        for node in tree.nodes:
            place = node.destination if isinstance(node, ActionTreeNode) else None
            if at is not None and place in self._scene.sites:
                route = self._routes.route(at, place)
                corners = route.waypoints if route else np.array([at])
                yield [(north, east, down) for north, east, down in corners.tolist()]
                at = tuple(corners[-1].tolist())


def _is_area(corners: Sequence[NorthEast]) -> bool:
    return len(corners) > 2


def _on_the_page(corners: Iterable[Ned]) -> Leg:
    return tuple((round(east, 2), round(north, 2)) for north, east, _ in corners)


def _mission(scene: Scene, run: str, is_live: bool) -> dict[str, Any]:
    grid = scene.grid
    rows, cols = grid.occupied.shape
    return {
        "run": run,
        "name": scene.name,
        "is_live": is_live,
        "period_s": PERIOD_S,
        "for_programs": sorted(FOR_PROGRAMS | {event.kind for event in DERIVED}),
        "map": {
            "rows": rows,
            "cols": cols,
            "cell_m": grid.cell_m,
            "east_m": grid.origin[1],
            "north_m": grid.origin[0],
            "shade": base64.b64encode(_shade(grid).tobytes()).decode("ascii"),
        },
        "fence": _corners(scene.fence),
        "keep_out": [
            {"name": name, "corners": _corners(zone)} for name, zone in scene.keep_out.items()
        ],
        "low_walls": [_corners(wall.corners) for wall in scene.walls],
        "places": [
            {"name": name, "enu": enu_from_ned(site.position), **_outline(site)}
            for name, site in scene.sites.items()
        ],
    }


def _corners(polygon: Iterable[NorthEast]) -> list[list[float]]:
    return [[east, north] for north, east in polygon]


def _outline(site: PlaceRegion) -> dict[str, Any]:
    if (corners := site.region.outline()) is None:
        return {"radius_m": site.region.inner_m(site.position)}
    return {"corners": _corners(corners)}


def _shade(grid: OccupancyGrid) -> npt.NDArray[np.uint8]:
    """(rows, cols) 0 on obstacles, 1 to 255 with growing distance; the northmost row first."""
    far = np.clip(grid.distance_m / SHADE_LIMIT_M, 0.0, 1.0)
    return np.where(grid.occupied, 0, 1 + 254 * far).astype(np.uint8)[::-1]
