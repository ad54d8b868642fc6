"""Ways from the air to the ground and back: goals of the vehicle, pursued one after the other.

While one is under way, the plan has the vehicle on the ground (`PlanProgress.is_landed_by_plan`).
Special cases:

1. A vehicle that was disarmed in its take-off is not armed again: somebody has stopped it, or it
   has hit something.
2. If the autopilot lands and does not report that it has landed, it is left alone: the vehicle
   stands somewhere, with a wrong height.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.plan_progress import GroundState
from companion.flight_events.sortie import VehicleAirborne
from companion.mission.facts import AT
from companion.outcomes import Failed, Outcome, Progress
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Mode


class GoalsInOrder:
    """Pursues goals of the vehicle, one after the other.

    Args:
        flight: the flight.
        goals: the goals; at least one.
        takeoff_up_m: altitude above home for a take-off; None for the mission's own.
    """

    def __init__(
        self, flight: Flight, goals: tuple[Goal, ...], takeoff_up_m: float | None = None
    ) -> None:
        self._flight, self._left, self._takeoff_up_m = flight, list(goals), takeoff_up_m
        flight.progress.take_to_ground()

    def tick(self) -> Outcome:
        """One tick; DONE when the last goal is reached.

        After a failure that is to end the sortie it stays RUNNING, as no other try may follow.
        """
        flight, goal = self._flight, self._left[0]
        if goal is Goal.OFFBOARD:
            flight.guidance.hold_here()  # it may still rise
        elif goal is Goal.LANDED:
            flight.guidance.hold()  # until the autopilot does
        outcome = flight.vehicle.goals.pursue(goal, self._takeoff_up_m)
        if isinstance(outcome, Failed):
            return Progress.RUNNING if self._ends_sortie(goal, outcome) else outcome
        flight.progress.take_to_ground()  # and no longer disarmed
        if outcome is Progress.DONE:
            self._left.pop(0)
        return Progress.RUNNING if self._left else Progress.DONE

    def _ends_sortie(self, goal: Goal, failed: Failed) -> bool:
        """Whether no other try may follow: an unnoticed landing, or disarming after our arming."""
        progress, state = self._flight.progress, self._flight.vehicle.state
        if state is None:
            return False
        if goal is Goal.LANDED and state.heartbeat.mode is Mode.LAND:
            progress.miss_landing(failed)
            return True
        if goal in (Goal.AIRBORNE, Goal.OFFBOARD) and not state.heartbeat.is_armed:
            progress.ground = GroundState.DISARMED
            return True
        return False


class WayDown:
    """The autopilot's landing where the vehicle is, until it is disarmed."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._goals = GoalsInOrder(flight, (Goal.LANDED,))

    def tick(self) -> Outcome:
        """One tick; DONE on the ground.

        The last setpoint is then forgotten: after taking off, the vehicle holds where it then is.
        """
        outcome = self._goals.tick()
        if outcome is Progress.DONE:
            self._flight.guidance.forget_setpoint()
        return outcome


class WayUp:
    """Arming, a climb to the altitude of the place, and OFFBOARD.

    The height of the climb is that of the place to which the present action leads, or at which the
    plan has the vehicle.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight, task = flight, flight.task
        place = task.running.destination if task.running is not None else None
        at = next((fact.arguments[0] for fact in task.facts if fact.predicate == AT), None)
        goals = (Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD)
        self._goals = GoalsInOrder(flight, goals, flight.symbols.up_m(place or at))

    def tick(self) -> Outcome:
        """One tick; DONE in the air, where the plan may be interrupted again."""
        outcome = self._goals.tick()
        if outcome is Progress.DONE:
            self._flight.progress.leave_ground()
            self._flight.report(VehicleAirborne())
        return outcome
