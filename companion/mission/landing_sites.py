"""Checks where a mission lands: markers of places, and the ground below `land()` and `land_on()`.

A marker lies on level ground: at the height of home, or on a wall with `up_m`, which then is a
roof. On a roof only a marker tells the vehicle where the edge is, so `land()` above one is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from companion.mavlink.payload_commands import AUTOPILOT
from companion.mission.facts import AT
from companion.mission.markers import LandingMarker
from companion.mission.places import Place
from companion.mission.schema import MissionFile
from companion.mission.skills import Skill
from companion.mission.steps import Do, Fly, Land, LandOn
from companion.motion.grid import OccupancyGrid
from companion.vehicle_profile import VehicleProfile

LEAST_ABOVE_M = 1.0
"""The least height of a place above its marker."""
LEVEL_M = 0.05
MANY = 60
"""Number of points of a region that are checked."""


def with_markers(
    places: Mapping[str, Place],
    file: MissionFile,
    grid: OccupancyGrid,
    vehicle: VehicleProfile,
    document: Document,
) -> dict[str, Place]:
    """The places of a mission with their markers.

    Raises:
        MissionError: at the first marker that no component sees, or that has no room to land on it.
    """
    found = {}
    for name, place in places.items():
        entry = file.places[name].marker
        if entry is None:
            found[name] = place
            continue
        keys = ("places", name, "marker")
        if entry.component not in file.components:
            listing = ", ".join(file.components) or "none yet"
            hint = f"components are {listing}. {did_you_mean(entry.component, file.components)}"
            where = document.where(*keys, "component")
            raise MissionError(f"unknown component {entry.component}", where, hint.rstrip())
        component = file.components[entry.component]
        if component == AUTOPILOT:
            what = f"{entry.component} is the autopilot, which sees no markers"
            hint = "write the component of the program that sends LANDING_TARGET"
            raise MissionError(what, document.where(*keys, "component"), hint)
        if problem := _no_room(place, grid, vehicle):
            what, hint = problem
            raise MissionError(f"the marker of {name} {what}", document.key_at(*keys), hint)
        up_m = grid.ground_m(place.position[:2], 0.0)[1]
        found[name] = replace(place, marker=LandingMarker(component, entry.number, up_m))
    return found


def _no_room(place: Place, grid: OccupancyGrid, vehicle: VehicleProfile) -> tuple[str, str] | None:
    """Why the vehicle cannot land below a place, and the remedy; None if it can."""
    needed_m = vehicle.clearance_m
    up_m = grid.ground_m(place.position[:2], 0.0)[1]
    hint = "move the place, or make its region smaller: the marker may be anywhere in it"
    for north, east, _ in (place.position, *place.region.waypoints(place.position, MANY, 0.0)):
        lowest_m, highest_m = grid.ground_m((north, east), needed_m)
        if max(up_m - lowest_m, highest_m - up_m) > LEVEL_M:
            return f"may lie within {needed_m:g} m of the edge of a wall with up_m", hint
        if grid.at(up_m).clearance_m((north, east)) < needed_m:
            return f"may lie within {needed_m:g} m of a wall that is higher than it", hint
    above_m = -place.position[2] - up_m
    if above_m < LEAST_ABOVE_M:
        what = f"lies {up_m:g} m high, and the place only {above_m:.1f} m above it"
        return what, f"the vehicle looks for it from {LEAST_ABOVE_M:g} m at least: raise up_m"
    return None


def check_landings(
    skills: Mapping[str, Skill],
    places: Mapping[str, Place],
    sets: Mapping[str, Sequence[str]],
    grid: OccupancyGrid,
    vehicle: VehicleProfile,
    document: Document,
) -> None:
    """Refuses landings on walls without a marker, and landings on markers that do not exist.

    Raises:
        MissionError: at the skill that lands.
    """
    for skill in skills.values():
        where = document.where("skills", skill.name, "execute")
        members = {name: sets[set_name] for name, set_name in skill.parameters}
        for landing in _landings(skill, skills):
            of = landing.marker_of
            if of is None:
                for name in members.get(landing.here or "", [landing.here or ""]):
                    _check_ground(skill.name, places.get(name), grid, vehicle, document)
                continue
            for name in members.get(of, [of]):
                if name not in places or places[name].marker is None:
                    raise MissionError(
                        f"{skill.name} lands on the marker of {name}, which has none",
                        where,
                        f"write marker: {{component: NAME}} in the place {name}",
                    )
            if landing.here != of and (skill.is_planned or landing.here is not None):
                at = f"is at {landing.here}" if landing.here else "may be anywhere then"
                raise MissionError(
                    f"{skill.name} lands on the marker of {of}, and {at}",
                    where,
                    f"write at({of}) in its precondition, or fly({of}) before",
                )


def _check_ground(
    skill: str,
    place: Place | None,
    grid: OccupancyGrid,
    vehicle: VehicleProfile,
    document: Document,
) -> None:
    if place is None:
        return
    _, highest_m = grid.ground_m(place.position[:2], vehicle.clearance_m)
    if highest_m > 0:
        raise MissionError(
            f"{skill} lands at {place.name}, above a wall of {highest_m:g} m",
            document.where("skills", skill, "execute"),
            "land() does not know where the wall ends: give the place a marker and write "
            "land_on(PLACE), or land elsewhere",
        )


@dataclass(frozen=True, slots=True)
class _Landing:
    """One landing of a skill.

    Attributes:
        here: the parameter or place where the vehicle is; None if it is unknown.
        marker_of: the place whose marker it lands on; None for `land()`.
    """

    here: str | None
    marker_of: str | None


def _landings(skill: Skill, skills: Mapping[str, Skill]) -> Iterator[_Landing]:
    """All landings of a skill and of the skills that refine it, in the names of the skill."""
    atoms = (literal.atom for literal in skill.precondition if literal.is_positive)
    here = next((atom.arguments[0] for atom in atoms if atom.predicate == AT), None)
    names = {name: name for name, _ in skill.parameters}
    yield from _walk(skill, skills, names, [here])


def _walk(
    skill: Skill, skills: Mapping[str, Skill], names: Mapping[str, str], here: list[str | None]
) -> Iterator[_Landing]:
    """The landings in some steps.

    Args:
        names: the skill's parameters in the names of the outermost skill.
        here: where the vehicle is, as a list of one entry, which the steps replace.
    """
    for step in skill.execute:
        match step:
            case Fly(place):
                here[0] = names.get(place, place)
            case Land():
                yield _Landing(here[0], None)
            case LandOn(place):
                yield _Landing(here[0], names.get(place, place))
            case Do(called, arguments):
                inner = skills[called]
                own = [names.get(word, word) for word in arguments]
                bound = dict(zip((name for name, _ in inner.parameters), own, strict=True))
                yield from _walk(inner, skills, bound, here)
