"""Figures of recorded runs: what `companion figure` draws."""

from __future__ import annotations

from heapq import merge
from pathlib import Path

from companion.flight_events.event import Stamped
from companion.flight_events.plans import PlanMade, WrittenTreeAdopted
from companion.monitor.follower import Follower
from companion.monitor.scene import read_scene
from companion.monitor.tailing import EventLines
from companion.monitor.watching import Snapshot
from companion.record.backdrop import Backdrop
from companion.record.events import EVENTS_FILE
from companion.record.trail import Trail


def backdrop_of_run(folder: Path) -> Backdrop:
    """The world of a run, as its mission knew it at the start.

    Raises:
        MissionError: it is no run folder.
    """
    scene = read_scene(folder)
    return Backdrop(
        scene.grid,
        scene.fence,
        tuple(scene.keep_out.values()),
        tuple(wall.corners for wall in scene.walls),
        {name: (site.position, site.region) for name, site in scene.sites.items()},
    )


def trail_of_run(folder: Path) -> Trail:
    """The vehicle's positions, five a second, and its charge.

    Raises:
        MissionError: it is no run folder.
    """
    follower = Follower(folder, is_live=False)
    while follower.read():
        pass
    trail = Trail()
    events = EventLines(folder / EVENTS_FILE).news()
    if not any(isinstance(each.event, PlanMade | WrittenTreeAdopted) for each in events):
        trail.begin("before any plan that is recorded")
    happened: list[Stamped | Snapshot] = [*events]
    for each in merge(happened, follower.snapshots, key=lambda each: each.time_s):
        if isinstance(each, Stamped):
            trail.take(each)
        else:
            trail.add(each.position)
    return trail
