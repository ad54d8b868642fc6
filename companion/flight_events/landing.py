"""Events about landings on markers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason

PlaceName = Annotated[str, Doc("the place whose marker it is")]


@dataclass(frozen=True, slots=True)
class MarkerSeen(FlightEvent):
    """The marker to land on is seen; the vehicle descends over it."""

    kind = "marker"
    template = "the marker of {place} is seen, {off_m:.1f} m from the middle of the place"

    place: PlaceName
    off_m: Annotated[float, Doc("horizontal distance from the middle of its place")]


@dataclass(frozen=True, slots=True)
class MarkerLost(FlightEvent):
    """The marker to land on is not seen any more."""

    kind = "marker"
    template = "the marker of {place} is not seen any more; the vehicle is {up_m:.1f} m above it"

    place: PlaceName
    up_m: Annotated[float, Doc("of the vehicle above the marker")]


@dataclass(frozen=True, slots=True)
class SightingsRefused(FlightEvent):
    """Sightings of a marker cannot be used; reported whenever their number has doubled."""

    kind = "marker"
    template = "sightings of the marker of {place} refused: {number}; the last one: {reason}"

    place: PlaceName
    number: Annotated[int, Doc("sightings refused since the landing began")]
    reason: Reason


@dataclass(frozen=True, slots=True)
class MarkerAbandoned(FlightEvent):
    """The companion gave up a landing on a marker; the vehicle climbs back to the place."""

    kind = "marker"
    template = "no landing on the marker of {place}: {reason}"

    place: PlaceName
    reason: Reason


@dataclass(frozen=True, slots=True)
class LandedOnMarker(FlightEvent):
    """The vehicle has landed on a marker."""

    kind = "marker"
    template = "landed {off_m:.2f} m from the marker of {place}"

    place: PlaceName
    off_m: Annotated[float, Doc("distance from its middle, as far as the vehicle knows")]


@dataclass(frozen=True, slots=True)
class DockMayBeMissed(FlightEvent):
    """The plan charges where there is no marker, although the position is not exact."""

    kind = "dock"
    template = (
        "the vehicle may land {beside_m:.1f} m beside a dock, as its position is not exact: the "
        "dock has to be that wide, or have a marker (land_on)"
    )

    beside_m: Annotated[float, Doc("rounded to 0.1 m; 1 of 20 landings may be farther away")]
