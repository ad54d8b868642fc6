"""What other programs show of a mission or a run: places, fence, plan and flown track.

All positions are in degrees. The route of a plan consists of the places to which its actions fly;
other actions are left out: a drawing shows the mission, and does not replace it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from companion.flight_events.plans import PlannedAction, PlannedLasso
from companion.geometry import GlobalOrigin, NorthEast, enu_from_ned
from companion.mission.facts import AT
from companion.mission.model import Mission
from companion.mission.places import Place
from companion.mission.skills import Skill
from companion.mission.steps import Do, Fly, Wait
from companion.plans.route_plan import Height, LatLon


@dataclass(frozen=True, slots=True)
class DrawnPlace:
    """A place.

    Attributes:
        radius_m: the radius of the disc about it that lies in its region.
    """

    name: str
    position: LatLon
    height: Height
    radius_m: float


@dataclass(frozen=True, slots=True)
class DrawnVisit:
    """A flight to a place, and how long the vehicle then waits."""

    place: str
    hold_s: float = 0.0


@dataclass(frozen=True)
class Drawing:
    """The content of a drawing.

    Attributes:
        start: the name of the place where it begins.
        home_amsl_m: height of home above sea level, if known.
        is_planned: whether there is a plan; one that only takes off has no route.
        prefix: the route that is flown once.
        loop: the route that is then flown again and again.
        safe: places where to land without a plan, except the start.
        flown: the vehicle's track.
    """

    name: str
    places: Mapping[str, DrawnPlace]
    start: str
    fence: tuple[LatLon, ...]
    keep_out: Mapping[str, tuple[LatLon, ...]]
    speed_mps: float | None = None
    home_amsl_m: float | None = None
    is_planned: bool = False
    prefix: tuple[DrawnVisit, ...] = ()
    loop: tuple[DrawnVisit, ...] = ()
    safe: tuple[str, ...] = ()
    flown: tuple[LatLon, ...] = ()
    notes: list[str] = field(default_factory=list)


def drawing_of(mission: Mission, plan: PlannedLasso | None, zero: GlobalOrigin) -> Drawing:
    """The drawing of a mission.

    Args:
        mission: in its own metres.
        plan: the plan of the mission, if there is one.
        zero: where north 0, east 0 lies on the earth.
    """
    start = start_of(mission)
    prefix = list(route(mission, plan.prefix if plan else ()))
    return Drawing(
        name=mission.name,
        places={name: _place(place, zero) for name, place in mission.places.items()},
        start=start,
        fence=on_earth(mission.limits.fence, zero),
        keep_out={name: on_earth(zone, zero) for name, zone in mission.limits.keep_out.items()},
        speed_mps=mission.limits.speed_mps,
        is_planned=plan is not None,
        prefix=tuple(prefix),
        loop=tuple(route(mission, plan.loop if plan else ())),
        safe=safe_places_of(mission),
    )


def start_of(mission: Mission) -> str:
    """The place where a mission begins."""
    return next(fact.arguments[0] for fact in mission.initially if fact.predicate == AT)


def safe_places_of(mission: Mission) -> tuple[str, ...]:
    """The places where a mission says to land, except its start."""
    return tuple(name for name in mission.safe_places if name != start_of(mission))


def on_earth(corners: Sequence[NorthEast], zero: GlobalOrigin) -> tuple[LatLon, ...]:
    """The corners of a polygon in degrees."""
    return tuple(zero.to_global((*corner, 0.0))[:2] for corner in corners)


def _place(place: Place, zero: GlobalOrigin) -> DrawnPlace:
    up_m = enu_from_ned(place.position)[2]
    height = Height(up_m) if place.amsl_m is None else Height(place.amsl_m, is_amsl=True)
    position = zero.to_global((*place.position[:2], 0.0))[:2]
    return DrawnPlace(place.name, position, height, place.inner_m)


def route(mission: Mission, actions: Sequence[PlannedAction]) -> Iterator[DrawnVisit]:
    """The places to which some actions fly, in order, and how long they wait there."""
    visit: DrawnVisit | None = None
    for action in actions:
        skill = mission.skills.get(action.skill)
        if skill is None:  # the vehicle rests
            continue
        for step in _steps(mission, skill, action.arguments):
            if isinstance(step, float) and visit is not None:
                visit = DrawnVisit(visit.place, visit.hold_s + step)
            elif isinstance(step, str):
                if visit is not None:
                    yield visit
                visit = DrawnVisit(step)
    if visit is not None:
        yield visit


def _steps(mission: Mission, skill: Skill, arguments: Sequence[str]) -> Iterator[str | float]:
    """The places to which a skill flies, and the seconds that it waits."""
    names = (name for name, _ in skill.parameters)
    bound = dict(zip(names, arguments, strict=True))
    for step in skill.execute:
        match step:
            case Fly(place=place):
                yield bound.get(place, place)
            case Wait(duration_s=seconds):
                yield seconds
            case Do(skill=name, arguments=given):
                inner = [bound.get(argument, argument) for argument in given]
                yield from _steps(mission, mission.skills[name], inner)
