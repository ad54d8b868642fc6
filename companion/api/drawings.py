"""Drawings of missions and runs, for other programs: what `companion export` writes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import NoneType
from typing import Any

from companion.arguments import check_kind
from companion.errors import MissionError, NoPlanError, RequestError
from companion.flight_events.plans import PlanMade, PlannedLasso, PlanReplaced
from companion.geometry import GlobalOrigin, enu_from_ned, horizontal_distance
from companion.mavlink.framing import MavlinkCodec, dialect, message_id, source
from companion.mavlink.payload_commands import AUTOPILOT
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.monitor.scene import Scene, read_scene
from companion.monitor.tailing import EventLines, TlogFrames
from companion.planning.planner import Planner
from companion.plans.drawing import (
    Drawing,
    DrawnPlace,
    drawing_of,
    on_earth,
    route,
    safe_places_of,
    start_of,
)
from companion.plans.route_plan import SAME_M, Height, LatLon, metres_between

STEP_M = 0.5
"""A point of the flown track that is nearer than this to the last one is left out."""
WHERE = frozenset(
    {dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, dialect.MAVLINK_MSG_ID_HOME_POSITION}
)


def mission_drawing(mission: Mission, home: GlobalOrigin | None) -> Drawing:
    """The drawing of a mission and of its first plan.

    Args:
        mission: what to draw.
        home: where north 0, east 0 lies on the earth, for a mission in metres. For a mission in
            degrees, which has its own origin, only the altitude is used.

    Raises:
        CompanionError: it is no mission; or a mission in metres without `home`; or a mission in
            degrees with its origin elsewhere.
    """
    check_kind(mission, Mission, "a mission, as of load_mission")
    check_kind(home, (GlobalOrigin, NoneType), "where home lies, as GlobalOrigin has it")
    zero = mission.anchor or home
    if zero is None:
        raise RequestError(
            f"{mission.name} is in metres from home, and a map needs to know where that is\n"
            "    say it: --home LAT,LON"
        )
    if home is not None and mission.anchor is not None:
        _check_home(mission, home, zero)
    told, plan = [], None
    try:
        plan = None if mission.tree else Planner(mission).plan().lasso.planned
    except NoPlanError as error:
        told.append(f"no plan is drawn: {str(error).splitlines()[0]}")
    if mission.tree:
        told.append("no plan is drawn: the mission has a tree of its own")
    drawing = drawing_of(mission, plan, zero)
    drawing.notes.extend(told)
    return replace(drawing, home_amsl_m=(home.altitude_m or None) if home else None)


def _check_home(mission: Mission, home: GlobalOrigin, zero: GlobalOrigin) -> None:
    """Raises an error if a mission in degrees has another origin than its user says."""
    start = zero.to_global((*mission.places[start_of(mission)].position[:2], 0.0))[:2]
    away_m = metres_between(start, (home.latitude_deg, home.longitude_deg))
    if away_m > SAME_M:
        raise RequestError(
            f"{mission.name} is in degrees, and begins {away_m:.0f} m from the --home that it is "
            "given\n"
            f"    leave --home out, or say {start[0]:.7f},{start[1]:.7f}"
        )


def run_drawing(folder: Path) -> Drawing:
    """The drawing of a run: its last plan, and where the vehicle flew.

    Raises:
        MissionError: it is no run folder, or the autopilot never reported a global position.
    """
    scene = read_scene(folder)
    home, flown = _where(folder)
    if home is None and scene.anchor is None:
        what = f"{folder}: the autopilot has not said where it is on the earth"
        raise MissionError(what, hint="its flight.tlog has no HOME_POSITION")
    zero = scene.anchor or home
    assert zero is not None
    drawing = _of_scene(scene, zero)
    mission = _mission(folder)
    if mission is None:
        drawing.notes.append("no plan is drawn: the mission needs files that are not in the run")
    else:
        plan = _last_plan(folder)
        start = start_of(mission)
        prefix, loop = plan.prefix if plan else (), plan.loop if plan else ()
        drawing = replace(
            drawing,
            start=start,
            is_planned=plan is not None,
            prefix=tuple(route(mission, prefix)),
            loop=tuple(route(mission, loop)),
            safe=safe_places_of(mission),
            speed_mps=mission.limits.speed_mps,
            keep_out={n: on_earth(z, zero) for n, z in mission.limits.keep_out.items()},
        )
    return replace(drawing, home_amsl_m=home.altitude_m if home else None, flown=flown)


def home_of_run(folder: Path) -> GlobalOrigin | None:
    """Where the origin of a run's frame lies on the earth; None if the autopilot never said so."""
    anchor, (home, _) = read_scene(folder).anchor, _where(folder)
    if anchor is not None and home is not None:
        return replace(anchor, altitude_m=home.altitude_m)
    return anchor or home


def _of_scene(scene: Scene, zero: GlobalOrigin) -> Drawing:
    """What the scene of a run shows; it begins at the place nearest to home."""
    places = {}
    for name, site in scene.sites.items():
        up_m = enu_from_ned(site.position)[2]
        position = zero.to_global((*site.position[:2], 0.0))[:2]
        radius_m = site.region.inner_m(site.position)
        places[name] = DrawnPlace(name, position, Height(up_m), radius_m)
    home = min(scene.sites.items(), key=lambda s: horizontal_distance(s[1].position, (0.0, 0.0)))
    zones = {name: on_earth(zone, zero) for name, zone in scene.keep_out.items()}
    return Drawing(scene.name, places, home[0], on_earth(scene.fence, zero), zones)


def _mission(folder: Path) -> Mission | None:
    """The mission that was flown, if it can be read from its file in the run folder."""
    try:
        return load_mission(folder / "mission.yaml", installed=None)
    except MissionError:
        return None


def _last_plan(folder: Path) -> PlannedLasso | None:
    plans = [
        stamped.event.plan
        for stamped in EventLines(folder / "events.jsonl").news()
        if isinstance(stamped.event, PlanMade | PlanReplaced)
    ]
    return plans[-1] if plans else None


def _where(folder: Path) -> tuple[GlobalOrigin | None, tuple[LatLon, ...]]:
    """The first home that the autopilot reported, and its track."""
    home: GlobalOrigin | None = None
    flown: list[LatLon] = []
    for message in _positions(folder):
        if message.get_type() == "HOME_POSITION":
            latitude, longitude = message.latitude / 1e7, message.longitude / 1e7
            home = home or GlobalOrigin(latitude, longitude, message.altitude / 1000)
            continue
        position = (message.lat / 1e7, message.lon / 1e7)
        if not flown or metres_between(flown[-1], position) >= STEP_M:
            flown.append(position)
    return home, tuple(flown)


def _positions(folder: Path) -> Iterator[Any]:
    """The autopilot's messages about home and its position."""
    frames, codec, is_more = TlogFrames(folder / "flight.tlog"), MavlinkCodec(0, 0), True
    while is_more:
        batches, is_more = frames.news()
        for _, together in batches:
            for frame in together:
                if message_id(frame) in WHERE:
                    yield from (m for m in codec.parse(frame) if source(m)[1] == AUTOPILOT)
