"""The leaf that calls a function of an installed package, and holds until the function ends.

The journal stores the call on the disk before it begins, and each command that the function
requests. When the leaf is left (by a pause, another plan, a pilot, a landing), the call is
cancelled, and later the function is called again. If it then requests a command that it has
requested before, it gets the outcome of the first one.
"""

from __future__ import annotations

import math

from py_trees.common import Status

from companion.acting.begun_steps import BegunStep
from companion.acting.behaviour_tree.kept_intention import kept
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.behaviour_tree.payload_command import PayloadCommand
from companion.acting.flight import Flight
from companion.acting.function_port import known_place, known_vehicle
from companion.errors import printable
from companion.flight_events.skills import SkillProgressed
from companion.flight_events.tree import LeafType
from companion.mission.python_call import PythonCall
from companion.mission.steps import Command
from companion.outcomes import Failed, Progress
from companion.skills.calls import CallRequest, CommandAsked, Progressed, Returned

CALL_S = 60.0
"""The longest time of a call if the mission sets no limit."""
TELL_S = 5.0
"""Time between two reports of how far a call has come."""


class CallFunction(Leaf):
    """Calls a function; SUCCESS when it returns.

    Args:
        flight: the flight in which it is called.
        step: the call, with all parameters bound.
        timeout_s: of a try of the skill; None if it has no limit.
    """

    does = LeafType.PYTHON

    def __init__(self, flight: Flight, step: PythonCall, timeout_s: float | None) -> None:
        super().__init__(flight, step.call.text)
        self._step = step
        self._timeout_s = CALL_S if timeout_s is None else timeout_s
        self._begun: BegunStep | None = None
        self._ticket: int | None = None
        self._command: PayloadCommand | None = None

    def initialise(self) -> None:
        """Writes the intention into the journal."""
        flight, text, self._owner = self._flight, self._step.call.text, self.owner()
        self._begun = flight.steps.begin(self._owner, text, flight.now_s)
        self._begun_s, self._told_s = flight.now_s, -math.inf
        self._news: Progressed | None = None
        self._asked = 0

    def update(self) -> Status:
        """SUCCESS if it has returned."""
        flight, begun = self._flight, self._begun
        assert begun is not None
        flight.guidance.hold()
        if begun.is_done:
            return Status.SUCCESS
        elapsed_s = flight.now_s - self._begun_s
        if self._ticket is None:
            if (is_kept := kept(flight, self._begun_s)) is not Progress.DONE:
                return self.status_of(is_kept)
            self._ticket = flight.functions.begin(self._request())
        if elapsed_s > self._timeout_s:
            return self.fail(f"not done after {self._timeout_s:g} s")
        if self._command is not None and not self._is_answered(self._command, self._ticket):
            return Status.RUNNING
        for answer in flight.functions.take(self._ticket, flight.now_s):
            match answer:
                case Progressed():
                    self._news = answer
                case CommandAsked():
                    self._ask(answer, self._ticket)
                case Returned():
                    self._tell()
                    begun.is_done = True
                    return Status.SUCCESS
                case Failed(reason):
                    self._tell()
                    return self.fail(printable(reason))
        self._tell()
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Cancels the call, and stops waiting for its command."""
        flight, begun = self._flight, self._begun
        if new_status is Status.RUNNING or begun is None:
            return
        if self._command is not None:
            self._command.leave()
        if self._ticket is not None:
            flight.functions.cancel(self._ticket)
        if not begun.is_done:
            flight.steps.drop(self._owner)
        self._begun = self._ticket = self._command = None

    def _request(self) -> CallRequest:
        flight = self._flight
        state, location = flight.vehicle.state, flight.vehicle.frame.location
        known = [flight.symbols.find(name) for name in sorted(self._step.names)]
        places = tuple(known_place(place, location) for place in known if place is not None)
        return CallRequest(self._step.call, places, known_vehicle(state))

    def _ask(self, asked: CommandAsked, ticket: int) -> None:
        """Begins a command that the function requests, or says why not."""
        payloads, named = self._flight.vehicle.payloads, dict(self._step.components)
        component, number = asked.component, payloads.number(asked.command)
        component_id = named.get(component) if isinstance(component, str) else component
        if component_id is None or not 0 < component_id < 256:
            why = f"the mission has no component {printable(str(component))}"
            self._flight.functions.reply(ticket, why)
        elif number is None:
            why = f"there is no command {printable(asked.command)}"
            self._flight.functions.reply(ticket, why)
        else:
            self._asked += 1
            owner = self.owner(self._asked)
            command = Command(component_id, number, asked.command, asked.parameters)
            self._command = PayloadCommand(self._flight, owner, command, None)

    def _is_answered(self, command: PayloadCommand, ticket: int) -> bool:
        """Continues with the requested command; returns whether its outcome is known."""
        outcome = command.progress()
        if outcome is Progress.RUNNING:
            return False
        failure = outcome.reason if isinstance(outcome, Failed) else None
        self._flight.functions.reply(ticket, failure)
        self._command = None
        return True

    def _tell(self) -> None:
        """Reports how far the call has come, now and then."""
        flight, news, running = self._flight, self._news, self._flight.task.running
        if news is None or flight.now_s - self._told_s < TELL_S:
            return
        percent = None if news.share is None else round(100 * news.share)
        action = running.name if running is not None else self.name
        flight.report(SkillProgressed(action, percent, printable(news.text)))
        self._told_s, self._news = flight.now_s, None
