"""The leaf that turns the vehicle: a step with `look_at` begins once the vehicle looks there."""

from __future__ import annotations

import math

from py_trees.common import Status

from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.flight_events.tree import LeafType
from companion.mission.places import PointOfInterest
from companion.motion.heading import HEADING_TOLERANCE_RAD, error_rad, towards

TURN_TIMEOUT_S = 15.0
"""How much longer a turn may take than half a turn of this vehicle."""


class LookAt(Leaf):
    """Turns to a point on the spot, until the vehicle looks at it.

    A step that holds the vehicle then keeps the heading, and a flight itself keeps looking at the
    point. The vehicle does not turn on the ground, or if the point is too near to have a direction.

    Args:
        flight: what it acts on.
        point: what is looked at.
        before: the step; once that is under way, nothing is left to do.
    """

    does = LeafType.LOOK_AT

    def __init__(self, flight: Flight, point: PointOfInterest, before: Leaf) -> None:
        super().__init__(flight, f"look at {point.name}")
        self._point = point
        self._before = before

    def initialise(self) -> None:
        """Starts the timer."""
        most_s = TURN_TIMEOUT_S + math.pi / self._flight.profile.yaw_rate_radps
        self._end_s = self._flight.now_s + most_s

    def update(self) -> Status:
        """SUCCESS when the vehicle looks there."""
        flight, state = self._flight, self._flight.vehicle.state
        if self._before.status is Status.RUNNING or flight.progress.is_landed_by_plan:
            return Status.SUCCESS
        there = self._point.position
        heading_rad = None if state is None else towards(state.motion.position, there)
        if state is None or heading_rad is None:
            return Status.SUCCESS
        off_rad = error_rad(state.attitude.yaw_rad, heading_rad)
        flight.guidance.hold(heading_rad)
        if off_rad <= HEADING_TOLERANCE_RAD:
            return Status.SUCCESS
        if flight.now_s > self._end_s:
            left_deg = round(math.degrees(off_rad))
            return self.fail(f"{left_deg} degrees off the direction of {self._point.name}")
        return Status.RUNNING
