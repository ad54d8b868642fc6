"""The leaf that lands on a marker: own setpoints lead down over it, then the autopilot lands.

During the descent (marker_descent.py) the plan may be interrupted as in any flight; from the
autopilot's landing on, it is as on the ground (landing.py). After a descent that fails, the vehicle
is in the air, at its place.
"""

from __future__ import annotations

from py_trees.common import Status

from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.behaviour_tree.marker_descent import MarkerDescent, why_not_from_here
from companion.acting.flight import Flight
from companion.acting.goals_in_order import WayDown
from companion.flight_events.landing import LandedOnMarker
from companion.flight_events.sortie import VehicleLanded
from companion.flight_events.tree import LeafType
from companion.geometry import horizontal_distance
from companion.outcomes import Progress
from companion.vehicle.ports.state import VehicleState


class LandOnMarker(Leaf):
    """Lands on the marker of a place, and disarms."""

    does = LeafType.LAND_ON

    def __init__(self, flight: Flight, place: str) -> None:
        super().__init__(flight, f"land on {place}")
        self._place = flight.symbols.place(place)
        marker = self._place.marker
        assert marker is not None
        self._marker = marker

    def initialise(self) -> None:
        """Begins to look for the marker, from where the vehicle is."""
        self._descent: MarkerDescent | None = None
        self._landing: WayDown | None = None
        self._begun_s = self._flight.now_s
        self._flight.progress.begin_descent()

    def update(self) -> Status:
        """SUCCESS on the ground; FAILURE in the air, at the place."""
        flight, state = self._flight, self._flight.vehicle.state
        if self._landing is not None:
            return self._land(self._landing)
        if flight.progress.is_landed_by_plan:
            return self.fail("the vehicle is on the ground already")
        if state is None or flight.guidance.stop is not None:
            return Status.RUNNING  # it still brakes from the flight before
        if self._descent is None:
            if refusal := why_not_from_here(self._place, self._marker, state):
                return self.fail(refusal.reason)
            self._descent = self._descent_from(state)
        outcome = self._descent.tick(state)
        if outcome is not Progress.DONE:
            return self.status_of(outcome)
        self._landing = WayDown(flight)
        return self._land(self._landing)

    def terminate(self, new_status: Status) -> None:
        """Holds the vehicle where it is when something above interrupts."""
        self._flight.progress.end_descent()
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._flight.guidance.hold()

    def _descent_from(self, state: VehicleState) -> MarkerDescent:
        """A descent that begins at the setpoint, or without one where the vehicle is."""
        told = self._flight.guidance.setpoint
        start = told.position if told is not None else state.motion.position
        return MarkerDescent(self._flight, self._place, self._marker, start, self._begun_s)

    def _land(self, landing: WayDown) -> Status:
        """Lets the autopilot land; reports how far from the marker the vehicle then stands."""
        flight, state = self._flight, self._flight.vehicle.state
        outcome = landing.tick()
        if outcome is Progress.DONE:
            marker = self._descent.marker_at if self._descent is not None else None
            if state is not None and marker is not None:
                off_m = horizontal_distance(state.motion.position, marker)
                flight.report(LandedOnMarker(self._place.name, round(off_m, 2)))
            flight.report(VehicleLanded())
        return self.status_of(outcome)
