"""The end of a sortie, as an event."""

from __future__ import annotations

from companion.errors import CompanionError
from companion.flight_events.sortie import (
    EndedAtLimit,
    ReturnedAsAsked,
    RunEnded,
    RunFailed,
    StoppedAsAsked,
    TaskSatisfied,
)


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
