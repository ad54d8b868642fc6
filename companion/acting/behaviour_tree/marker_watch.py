"""What the vehicle sees of the marker that it lands on, and what was refused."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.flight_events.landing import SightingsRefused
from companion.geometry import Ned
from companion.mission.markers import LandingMarker
from companion.mission.places import Place
from companion.motion.marker_track import ExpectedMarker, MarkerTrack
from companion.outcomes import Refusal
from companion.vehicle.ports.state import VehicleState

LOST_S = 1.0
"""Without a sighting for so long the marker is lost;"""
BLIND_S, BLIND_M = 4.0, 1.0
"""nearer to it than this, it is lost only after this time."""


class MarkerWatch:
    """Takes the sightings of one marker during one landing (`motion/marker_track.py`).

    Args:
        flight: the flight.
        place: the place of the marker.
        marker: the marker.
    """

    def __init__(self, flight: Flight, place: Place, marker: LandingMarker) -> None:
        self._flight, self._name, self._marker = flight, place.name, marker
        self._track = MarkerTrack(ExpectedMarker(place.position, place.region, marker.up_m))
        self._refused = self._told = 0
        self._last_refusal: Refusal | None = None

    @property
    def position(self) -> Ned | None:
        """Where the marker is, as far as is known; None before it has been seen."""
        return self._track.position

    @property
    def problem(self) -> Refusal | None:
        """Why the vehicle must not land on it; None if there is no reason."""
        return self._track.problem

    def look(self, state: VehicleState) -> None:
        """Takes the sightings of the tick; reports refused ones each time their number doubles."""
        flight, marker = self._flight, self._marker
        refused = list(flight.vehicle.markers.refused)
        for seen in flight.vehicle.markers.seen:
            if (seen.component, seen.number) == (marker.component, marker.number):
                accuracy_m = state.motion.accuracy_m
                refusal = self._track.take(seen.seen_s, seen.position, accuracy_m)
                refused += [refusal] if refusal else []
        self._refused += len(refused)
        if refused:
            self._last_refusal = refused[-1]
            if self._refused >= max(1, 2 * self._told):
                self._told = self._refused
                flight.report(SightingsRefused(self._name, self._refused, refused[-1].reason))

    def above_m(self, state: VehicleState) -> float:
        """Height of the vehicle above the marker, or above its place in the mission."""
        up_m = -self.position[2] if self.position is not None else self._marker.up_m
        return -state.motion.position[2] - up_m

    def is_seen(self, state: VehicleState) -> bool:
        """Whether the marker is not lost."""
        for_s = BLIND_S if self.above_m(state) < BLIND_M else LOST_S
        return self._track.age_s(self._flight.now_s) <= for_s

    @property
    def is_seen_now(self) -> bool:
        """Whether the marker was seen a moment ago."""
        return self._track.age_s(self._flight.now_s) <= LOST_S / 2

    @property
    def why_not_seen(self) -> str:
        """Why a search was in vain, in words."""
        what = "its marker is not seen" if self.position is None else "its marker is lost"
        refusal = self._last_refusal
        return f"{what}; what was refused last: {refusal.reason}" if refusal else what
