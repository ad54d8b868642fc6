"""The end of a sortie: as an event, and whose the vehicle is then."""

from __future__ import annotations

from companion.acting.journal import EndingBegun
from companion.acting.phases import TRANSITIONS, SortieEvent
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
from companion.vehicle.port import Mode, VehicleState


def ending(
    failure: CompanionError | None,
    is_called_home: bool,
    is_satisfied: bool,
    at_limit: EndedAtLimit | None = None,
) -> RunEnded:
    """How a sortie has ended.

    >>> ending(None, is_called_home=False, is_satisfied=True)
    TaskSatisfied(exit_code=0)

    Args:
        failure: why it did not end well.
        is_called_home: the vehicle was called home, and nobody has stopped it since.
        is_satisfied: so is the task.
        at_limit: it was called home by a limit of the flight.
    """
    if failure is not None:
        return RunFailed(str(failure), failure.exit_code)
    if is_called_home:
        return at_limit or ReturnedAsAsked()
    return TaskSatisfied() if is_satisfied else StoppedAsAsked()


def ending_begun(failure: CompanionError | None, called_to: str, is_satisfied: bool) -> EndingBegun:
    """What the journal has of an end that has begun, from what `ending` will have of it."""
    reason, exit_code = (str(failure), failure.exit_code) if failure is not None else ("", 0)
    return EndingBegun(is_satisfied, bool(called_to), reason, exit_code, called_to)


def last_resort(phase: Phase, state: VehicleState) -> str:
    """Who has the vehicle when its last goal has failed in the air, to add to the reason.

    A vehicle in OFFBOARD that neither holds nor lands on command is left without setpoints: its
    autopilot's failsafe, which was looked at before arming, is all that is left.
    """
    if state.is_landed or TRANSITIONS.next(phase, SortieEvent.FAILED) is not Phase.ENDED:
        return ""
    if state.mode is Mode.OFFBOARD:
        return "; setpoints end, so that the autopilot's offboard-loss failsafe takes the vehicle"
    return f"; the autopilot has the vehicle, in {state.mode.value}"
