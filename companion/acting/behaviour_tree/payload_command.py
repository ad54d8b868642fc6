"""A command to a payload, as a part of a leaf: from the intention to the final answer."""

from __future__ import annotations

from companion.acting.begun_steps import StepOwner
from companion.acting.behaviour_tree.kept_intention import kept
from companion.acting.flight import Flight
from companion.mission.steps import Command
from companion.outcomes import Failed, Outcome, Progress


class PayloadCommand:
    """A command of the present skill. After an interruption it is the same command as before.

    Args:
        flight: the flight; its payloads get the command.
        owner: which step it is.
        command: what is sent.
        timeout_s: time for the final answer; None for the protocol's own times.
    """

    def __init__(
        self, flight: Flight, owner: StepOwner, command: Command, timeout_s: float | None
    ) -> None:
        self._flight, self._owner, self._command = flight, owner, command
        self._timeout_s = timeout_s
        self._step = flight.steps.begin(owner, command, flight.now_s)
        self._has_ended = self._step.is_done
        if self._step.ticket is not None:
            flight.vehicle.payloads.come_back(self._step.ticket)

    def progress(self) -> Outcome:
        """Continues with the command and returns its outcome; once a tick, until it has ended."""
        flight, command, step = self._flight, self._command, self._step
        if step.is_done:
            return Progress.DONE
        if step.ticket is None:
            if (is_kept := kept(flight, step.intended_s)) is not Progress.DONE:
                return self._after(is_kept)
            step.ticket = flight.vehicle.payloads.send(
                command.component, command.command, command.parameters, self._timeout_s
            )
        return self._after(flight.vehicle.payloads.outcome(step.ticket))

    def leave(self) -> None:
        """Stops waiting. The answer still counts if the skill comes back to the command."""
        flight, step = self._flight, self._step
        if self._has_ended:
            return
        if step.ticket is None:
            flight.steps.drop(self._owner)
        else:
            flight.vehicle.payloads.leave(step.ticket)

    def _after(self, outcome: Outcome) -> Outcome:
        flight, step = self._flight, self._step
        if isinstance(outcome, Failed):
            self._has_ended = True
            flight.steps.drop(self._owner)
        elif outcome is Progress.DONE and step.ticket is not None:
            self._has_ended = step.is_done = True
            flight.vehicle.payloads.forget(step.ticket)
            step.ticket = None
        return outcome
