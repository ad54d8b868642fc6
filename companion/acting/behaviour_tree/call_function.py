"""The leaf that calls a function of an installed package, and waits, holding, for its end.

That it is about to be called is in the journal, on the disk, before it is; so is each command that
it asks for. Whatever leaves the leaf cancels the call: a pause, another plan, a pilot, a landing.
"""

from __future__ import annotations

import math

from py_trees.common import Status

from companion.acting.behaviour_tree.kept_intention import kept
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.acting.function_port import known_place, known_vehicle
from companion.errors import printable
from companion.flight_events.skills import SkillProgressed
from companion.flight_events.tree import LeafType
from companion.mission.python_call import PythonCall
from companion.skills.calls import CallRequest, CommandAsked, NotDone, Progressed, Returned
from companion.vehicle.port import Failed, Progress

CALL_S = 60.0
"""What a call may take where the mission sets no time limit."""
TELL_S = 5.0
"""Time between two pieces of news about how far a call has come."""


class CallFunction(Leaf):
    """Calls a function; SUCCESS when it returns.

    Args:
        flight: in which it is called.
        step: what is called; all parameters are bound.
        timeout_s: of a try of the skill; None where it has no limit.
    """

    does = LeafType.PYTHON

    def __init__(self, flight: Flight, step: PythonCall, timeout_s: float | None) -> None:
        super().__init__(flight, step.call.text)
        self._step = step
        self._timeout_s = CALL_S if timeout_s is None else timeout_s
        self._intention: int | None = None
        self._ticket: int | None = None
        self._command: _AskedCommand | None = None

    def initialise(self) -> None:
        """Writes down what is intended."""
        self._intention = self._flight.intend(self._step.call.text)
        self._begun_s, self._told_s = self._flight.now_s, -math.inf
        self._news: Progressed | None = None

    def update(self) -> Status:
        """SUCCESS if it has returned."""
        flight = self._flight
        flight.guidance.hold()
        elapsed_s = flight.now_s - self._begun_s
        if self._ticket is None:
            if (is_kept := kept(flight, self._begun_s)) is not Progress.DONE:
                return self.status_of(is_kept)
            self._ticket = flight.functions.begin(self._request())
        if elapsed_s > self._timeout_s:
            return self.fail(f"not done after {self._timeout_s:g} s")
        if self._command is not None and not self._step_command(self._command, self._ticket):
            return Status.RUNNING
        for answer in flight.functions.take(self._ticket, flight.now_s):
            match answer:
                case Progressed():
                    self._news = answer
                case CommandAsked():
                    self._command = _AskedCommand(flight, answer, self._step.components)
                case Returned():
                    self._tell()
                    return Status.SUCCESS
                case NotDone(reason):
                    self._tell()
                    return self.fail(printable(reason))
        self._tell()
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Leaves the call. What was done is settled by the end of the skill that it belongs to."""
        if new_status is Status.RUNNING or self._intention is None:
            return
        if self._command is not None:
            self._command.forget()
        if self._ticket is not None:
            self._flight.functions.cancel(self._ticket)
        if new_status is not Status.SUCCESS:
            self._flight.settle(self._intention)
        self._intention = self._ticket = self._command = None

    def _request(self) -> CallRequest:
        flight = self._flight
        state, location = flight.vehicle.state, flight.vehicle.location
        known = [flight.symbols.find(name) for name in sorted(self._step.names)]
        places = tuple(known_place(place, location) for place in known if place is not None)
        return CallRequest(self._step.call, places, known_vehicle(state))

    def _step_command(self, command: _AskedCommand, ticket: int) -> bool:
        """Goes on with the command that was asked for; whether its outcome is known."""
        outcome = command.step()
        if outcome is Progress.RUNNING:
            return False
        failure = outcome.reason if isinstance(outcome, Failed) else None
        self._flight.functions.reply(ticket, failure)
        self._command = None
        return True

    def _tell(self) -> None:
        """Tells how far it has come, the newest, now and then."""
        flight, news, running = self._flight, self._news, self._flight.task.running
        if news is None or flight.now_s - self._told_s < TELL_S:
            return
        percent = None if news.share is None else round(100 * news.share)
        action = running.name if running is not None else self.name
        flight.report(SkillProgressed(action, percent, printable(news.text)))
        self._told_s, self._news = flight.now_s, None


class _AskedCommand:
    """A payload's command that a function has asked for."""

    def __init__(
        self, flight: Flight, asked: CommandAsked, components: tuple[tuple[str, int], ...]
    ) -> None:
        self._flight, self._asked = flight, asked
        self._number = flight.vehicle.payloads.number(asked.command)
        named, component = dict(components), asked.component
        self._component = named.get(component) if isinstance(component, str) else component
        self._intention: int | None = None
        self._ticket: int | None = None
        self._begun_s = flight.now_s

    def step(self) -> Progress | Failed:
        """One tick; the command is sent once, when the journal has it."""
        flight, asked = self._flight, self._asked
        if self._component is None or not 0 < self._component < 256:
            return Failed(f"the mission has no component {printable(str(asked.component))}")
        if self._number is None:
            return Failed(f"there is no command {printable(asked.command)}")
        if self._intention is None:
            self._intention = flight.intend(asked.command)
        if self._ticket is None:
            match kept(flight, self._begun_s):
                case Failed(reason):
                    return self._settled(reason)
                case Progress.RUNNING:
                    return _WAITS
            self._ticket = flight.vehicle.payloads.send(
                self._component, self._number, asked.parameters, None
            )
        outcome = flight.vehicle.payloads.outcome(self._ticket)
        if outcome is not _WAITS:
            flight.vehicle.payloads.forget(self._ticket)
            self._ticket = None
        return self._settled(outcome.reason) if isinstance(outcome, Failed) else outcome

    def forget(self) -> None:
        """It is asked for no longer."""
        if self._ticket is not None:
            self._flight.vehicle.payloads.forget(self._ticket)
        if self._intention is not None:
            self._settled("")

    def _settled(self, reason: str) -> Failed:
        assert self._intention is not None
        self._flight.settle(self._intention)
        return Failed(reason)


_WAITS = Progress.RUNNING
