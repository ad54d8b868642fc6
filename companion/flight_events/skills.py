"""Events about skills: what was reached and done, what has failed, how the way has changed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason
from companion.geometry import Ned

ActionName = Annotated[str, Doc("as the mission spells it, e.g. `move(A, B)`")]


@dataclass(frozen=True, slots=True)
class PlaceReached(FlightEvent):
    """A flight reached its place."""

    kind = "at"
    template = "at {place}"

    place: Annotated[str, Doc("that was reached")]
    action: ActionName


@dataclass(frozen=True, slots=True)
class SkillCompleted(FlightEvent):
    """Another skill was completed."""

    kind = "done"
    template = "{action} done"

    action: ActionName


@dataclass(frozen=True, slots=True)
class SkillFailed(FlightEvent):
    """A skill failed."""

    kind = "failed"
    template = "{action} failed: {reason}"

    action: ActionName
    reason: Reason


@dataclass(frozen=True, slots=True)
class PhotoTaken(FlightEvent):
    """A camera took a photo for a skill."""

    kind = "photo"
    template = "photo {number} of {camera} at {place}"

    number: Annotated[int, Doc("of the photo, as the camera counts them, from 1")]
    camera: Annotated[str, Doc("its name in the mission")]
    place: Annotated[str, Doc("where the vehicle was: a place, or metres from home")]
    image_index: Annotated[
        int | None, Doc("that the camera told; null where that message was lost")
    ]
    position: Annotated[Ned, Doc("of the vehicle: local NED, metres")]


@dataclass(frozen=True, slots=True)
class SkillProgressed(FlightEvent):
    """A Python skill reports its progress; every 5 s at most."""

    kind = "progress"
    template = "{action}: {far}"

    action: ActionName
    percent: Annotated[int | None, Doc("how far the skill has come; null if it does not say")]
    words: Annotated[str, Doc("its text, or empty")]

    @property
    def far(self) -> str:
        """How far it has come, in words."""
        share = "" if self.percent is None else f"{self.percent} %"
        return ", ".join(filter(None, (share, self.words))) or "under way"


@dataclass(frozen=True, slots=True)
class FunctionsAwaited(FlightEvent):
    """The flight waits until the functions that its mission calls are loaded."""

    kind = "loading"
    template = "waiting until these functions are loaded: {listed}"

    names: Annotated[tuple[str, ...], Doc("a list of the functions")]

    @property
    def listed(self) -> str:
        """The functions in words."""
        return ", ".join(self.names)


@dataclass(frozen=True, slots=True)
class PlaceFunctionFailed(FlightEvent):
    """A suggester or a test of a place failed: it proposes nothing, or passes nothing."""

    kind = "function"
    template = "{function} failed for {place}: {reason}"

    place: Annotated[str, Doc("that it was asked about")]
    function: Annotated[str, Doc("the name of the suggester or test")]
    reason: Reason


@dataclass(frozen=True, slots=True)
class OutcomeUnknown(FlightEvent):
    """The companion was cut off while a skill commanded a payload, or called a function."""

    kind = "unknown"
    template = "{action}: it is unknown whether this was done; {consequence}"

    action: ActionName
    consequence: Annotated[str, Doc("what is done about it, in words")]


@dataclass(frozen=True, slots=True)
class WrittenTreeFailed(FlightEvent):
    """The mission's own tree failed."""

    kind = "failed"
    template = "the tree has failed: {reason}"

    reason: Reason


class RouteResponse(Enum):
    """What is done about a way that is not clear."""

    ANOTHER_ROUTE = "another route"
    STOPPING = "stopping"
    NO_ROUTE = "no route"


@dataclass(frozen=True, slots=True)
class RouteBlocked(FlightEvent):
    """The flight to a place was rerouted or stopped because of what the lidar saw."""

    kind = "route"
    template = "the route to {place} is not clear: {response}"

    place: Annotated[str, Doc("where the flight leads")]
    response: Annotated[RouteResponse, Doc("what is done about it")]


@dataclass(frozen=True, slots=True)
class WallNear(FlightEvent):
    """The vehicle is off its route, and nearer to an obstacle than its margin allows."""

    kind = "wall"
    template = (
        "the vehicle is off its route, {free_m:.2f} m from an obstacle: its setpoint is moved "
        "away from it"
    )

    free_m: Annotated[float, Doc("between the vehicle's rotors and the obstacle, by its position")]


@dataclass(frozen=True, slots=True)
class GroundNear(FlightEvent):
    """By its range finder, the vehicle is nearer to what is below it than it may be."""

    kind = "ground"
    template = (
        "the vehicle is {below_m:.2f} m above what is below it by its range finder, and "
        "{up_m:.2f} m up by its altitude: it climbs, as far as limits.up_m allows"
    )

    below_m: Annotated[float, Doc("from the vehicle down to what is below it, by a range finder")]
    up_m: Annotated[float, Doc("its altitude above home")]


@dataclass(frozen=True, slots=True)
class SpeedLimitedBySight(FlightEvent):
    """The speed is limited so that the vehicle can stop within the sight of its range finder."""

    kind = "speed"
    template = (
        "speed limited to {speed_mps:.2f} m/s instead of {asked_mps:.2f}: obstacles that no map "
        "shows are seen only {sight_m:.1f} m ahead (limits.beyond_sight)"
    )

    speed_mps: Annotated[float, Doc("the speed from which the vehicle can stop within sight")]
    asked_mps: Annotated[float, Doc("the speed that the mission and the vehicle allow")]
    sight_m: Annotated[float, Doc("the distance up to which the range finder's echoes count")]


@dataclass(frozen=True, slots=True)
class ClearanceChanged(FlightEvent):
    """Routes keep a greater or smaller distance from obstacles.

    It follows the accuracy of the position, and how well the vehicle keeps to its route.
    """

    kind = "clearance"
    template = (
        "routes keep {clearance_m:.1f} m from obstacles where there is room: the position is "
        "accurate to {accuracy_m:.2f} m, the vehicle is up to {off_m:.2f} m off its route"
    )

    clearance_m: Annotated[float, Doc("that routes keep from obstacles, where there is room")]
    accuracy_m: Annotated[float, Doc("standard deviation of the position, by the autopilot")]
    off_m: Annotated[float, Doc("the greatest distance of the vehicle from its route")] = 0.0


@dataclass(frozen=True, slots=True)
class LowPlacesFlown(FlightEvent):
    """Places are so low that the error of the height matters, as the position is not exact."""

    kind = "height"
    template = (
        "heights may be wrong by {error_m:g} m, as the position is not exact; in the mission, "
        "put these places {least_m:g} m or more above what is below them: {listed}"
    )

    places: Annotated[tuple[str, ...], Doc("a list of the places that are so low")]
    least_m: Annotated[float, Doc("how high above what is below them they should be")]
    error_m: Annotated[float, Doc("the greatest error of a height")]

    @property
    def listed(self) -> str:
        """The places in words."""
        return ", ".join(self.places)


@dataclass(frozen=True, slots=True)
class SymbolMoved(FlightEvent):
    """Flights to a place now lead to another waypoint."""

    kind = "symbol"
    template = "{place} is now {east_m:.1f} m east, {north_m:.1f} m north ({source})"

    place: Annotated[str, Doc("the place with the new waypoint")]
    position: Annotated[Ned, Doc("the waypoint: local NED, metres")]
    source: Annotated[str, Doc("who proposed the waypoint")]

    @property
    def north_m(self) -> float:
        """The waypoint, north of home."""
        return self.position[0]

    @property
    def east_m(self) -> float:
        """The waypoint, east of home."""
        return self.position[1]
