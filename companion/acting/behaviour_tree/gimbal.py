"""The leaves that point a gimbal: in a direction, or at what a skill looks at."""

from __future__ import annotations

import math

from py_trees.common import Status

from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.flight_events.tree import LeafType
from companion.geometry import horizontal_distance
from companion.mission.payload_steps import PointGimbal
from companion.mission.places import PointOfInterest
from companion.motion.heading import towards
from companion.outcomes import Failed, Progress
from companion.vehicle.ports.gimbals import Aim


class _Pointing(Leaf):
    """Points a gimbal while the vehicle holds, until the gimbal points there."""

    does = LeafType.GIMBAL

    def __init__(self, flight: Flight, name: str, component: int, timeout_s: float | None) -> None:
        super().__init__(flight, name)
        self._component = component
        self._timeout_s = timeout_s
        self._ticket: int | None = None

    def _point(self, aim: Aim) -> Status:
        """Begins to point, or checks how far the gimbal has come."""
        gimbals = self._flight.vehicle.gimbals
        if self._ticket is None:
            self._ticket = gimbals.point(self._component, aim, self._timeout_s)
        match gimbals.outcome(self._ticket):
            case Progress.DONE:
                return Status.SUCCESS
            case Failed(reason):
                return self.fail(reason)
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stops waiting; the gimbal keeps its direction."""
        if new_status is not Status.RUNNING and self._ticket is not None:
            self._flight.vehicle.gimbals.forget(self._ticket)
            self._ticket = None


class AimGimbal(_Pointing):
    """Points a gimbal by its angles from the vehicle.

    Args:
        flight: what it acts on.
        step: the direction.
        timeout_s: time for all of it; None for the default.
    """

    def __init__(self, flight: Flight, step: PointGimbal, timeout_s: float | None) -> None:
        super().__init__(flight, f"gimbal {step.gimbal}", step.component, timeout_s)
        self._aim = Aim(step.pitch_rad, step.yaw_rad, is_from_north=False)

    def update(self) -> Status:
        """SUCCESS when it points there."""
        self._flight.guidance.hold()
        return self._point(self._aim)


class LookThroughGimbal(_Pointing):
    """Points a gimbal at what a skill looks at, before a step that holds the vehicle.

    From straight above the point has no direction, and the gimbal looks down along the heading.

    Args:
        flight: what it acts on.
        point: what is looked at; it names the gimbal.
        before: the step; once that is under way, nothing is left to do.
    """

    def __init__(self, flight: Flight, point: PointOfInterest, before: Leaf) -> None:
        assert point.gimbal is not None
        super().__init__(flight, f"gimbal at {point.name}", point.gimbal, None)
        self._target = point
        self._before = before

    def update(self) -> Status:
        """SUCCESS when it points there."""
        flight, state = self._flight, self._flight.vehicle.state
        if self._before.status is Status.RUNNING or state is None:
            return Status.SUCCESS
        if flight.progress.is_landed_by_plan:
            return Status.SUCCESS
        flight.guidance.hold(towards(state.motion.position, self._target.position))
        down_m = -state.motion.position[2] - self._target.up_m
        away_m = horizontal_distance(state.motion.position, self._target.position)
        heading_rad = towards(state.motion.position, self._target.position)
        yaw_rad = state.attitude.yaw_rad if heading_rad is None else heading_rad
        return self._point(Aim(-math.atan2(down_m, away_m), yaw_rad, is_from_north=True))
