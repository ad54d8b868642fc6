"""Checks whether the vehicle still is at the place where the task believes it to be.

A completed flight makes `at(X)` true, and the task believes it until the next flight. Wind, a pilot
or a bad estimate may take the vehicle away from there. So in the air `at(X)` is compared with the
position, except while a skill flies. A gust may pass: the place counts as lost after a second
outside of it, or at once if somebody else has flown the vehicle meanwhile.

A loss is an interruption: it adds no position to the word, and the vehicle is at no place.
"""

from __future__ import annotations

from collections.abc import Mapping

from companion.acting.flight import Flight
from companion.acting.plan_progress import GroundState
from companion.acting.positions import tell_positions
from companion.flight_events.facts import PlaceLost
from companion.geometry import distance
from companion.mission.facts import AT
from companion.mission.places import Place

OUTSIDE_S = 1.0
"""Time outside of a place after which it is lost."""
MARGIN_M = 0.5
"""How far outside a place's region the vehicle still counts as being there."""
SIGMAS = 2.0
"""The same in standard deviations of the position, if that is more; 5 % are beyond it."""


class Whereabouts:
    """Compares the place of the vehicle, as the task has it, with its position.

    Args:
        flight: knows the task and the position of the vehicle.
        places: the mission's places, by name.
    """

    def __init__(self, flight: Flight, places: Mapping[str, Place]) -> None:
        self._flight = flight
        self._places = places
        self._outside_since_s: float | None = None

    def look(self) -> PlaceLost | None:
        """Checks once a tick; returns the place lost now, after the task has learnt of it."""
        outside, now_s = self._outside(), self._flight.now_s
        if outside is None:
            self._outside_since_s = None
            return None
        if self._outside_since_s is None:
            self._outside_since_s = now_s
        return self._lose(outside) if now_s - self._outside_since_s >= OUTSIDE_S else None

    def look_after_absence(self) -> PlaceLost | None:
        """Checks after somebody else may have flown the vehicle; waits for no gust to pass."""
        outside = self._outside()
        return self._lose(outside) if outside is not None else None

    def _outside(self) -> PlaceLost | None:
        """The place where the vehicle should be but is not; None if it is there."""
        flight, state = self._flight, self._flight.vehicle.state
        is_flying = flight.task.running is not None and flight.task.running.destination is not None
        if state is None or state.is_landed or flight.progress.is_landed_by_plan or is_flying:
            return None
        believed = (fact.arguments[0] for fact in flight.task.facts if fact.predicate == AT)
        place = self._places.get(next(believed, ""))
        if place is None:  # between places already
            return None
        margin_m = max(MARGIN_M, SIGMAS * state.motion.accuracy_m)
        north, east, down = state.motion.position
        there = flight.guidance.sent(place.position)
        if flight.progress.ground is GroundState.DESCENDING:
            down = there[2]  # it descends to its marker
        if place.region.away_m(there, (north, east, down)) <= margin_m:
            return None
        return PlaceLost(place.name, round(distance(there, state.motion.position), 1))

    def _lose(self, lost: PlaceLost) -> PlaceLost:
        """Puts the vehicle between places, for the task; the action there is interrupted."""
        flight = self._flight
        flight.task.interrupt()
        flight.task.depart()
        tell_positions(flight)
        flight.report(lost)
        return lost
