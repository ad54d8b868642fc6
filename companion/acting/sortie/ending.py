"""Tells how a sortie ends, as an event, and who controls the vehicle then."""

from __future__ import annotations

from companion.acting.journal import EndingBegun
from companion.acting.sortie.phases import TRANSITIONS, SortieEvent
from companion.errors import CompanionError
from companion.flight_events.sortie import (
    EndedAtLimit,
    Phase,
    ReturnedAsAsked,
    RunEnded,
    RunFailed,
    StoppedAsAsked,
    TaskSatisfied,
)
from companion.vehicle.ports.state import Mode, VehicleState


def ending(
    failure: CompanionError | None,
    is_called_home: bool,
    is_satisfied: bool,
    at_limit: EndedAtLimit | None = None,
) -> RunEnded:
    """The event for the end of a sortie.

    >>> ending(None, is_called_home=False, is_satisfied=True)
    TaskSatisfied(exit_code=0)

    Args:
        failure: why it did not end well; None if it did.
        is_called_home: the vehicle was called home, and nobody has stopped it since.
        is_satisfied: the task is satisfied.
        at_limit: the limit of the flight for which it was called home.
    """
    if failure is not None:
        return RunFailed(str(failure), failure.exit_code)
    if is_called_home:
        return at_limit or ReturnedAsAsked()
    return TaskSatisfied() if is_satisfied else StoppedAsAsked()


def ending_begun(failure: CompanionError | None, called_to: str, is_satisfied: bool) -> EndingBegun:
    """The journal entry for an end that has begun; it contains what `ending` will need."""
    reason, exit_code = (str(failure), failure.exit_code) if failure is not None else ("", 0)
    return EndingBegun(is_satisfied, bool(called_to), reason, exit_code, called_to)


def last_resort(phase: Phase, state: VehicleState) -> str:
    """Says who controls the vehicle after its last goal has failed in the air; added to the reason.

    A vehicle in OFFBOARD that neither holds nor lands on command gets no more setpoints. Only its
    autopilot's failsafe is left, which was checked before arming.
    """
    if state.is_landed or TRANSITIONS.next(phase, SortieEvent.FAILED) is not Phase.ENDED:
        return ""
    if state.heartbeat.mode is Mode.OFFBOARD:
        return "; setpoints end, so that the autopilot's offboard-loss failsafe takes the vehicle"
    return f"; the autopilot has the vehicle, in {state.heartbeat.mode.value}"
