"""Sends the commands of skills to payloads over MAVLink.

1. A command is sent only if the rules of `mavlink/payload_commands.py` allow it.
2. Silence and absence are told apart: a component that did not answer and sends no heartbeat is
   absent.
3. While the autopilot is not heard, no command is sent, and no time of a command passes.
4. A command that is left is not sent again until somebody comes back to it; its answer still
   counts.

Source: https://mavlink.io/en/services/command.html.
"""

from __future__ import annotations

import math

from companion.mavlink.commands import CommandSender, Exchange
from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.payload_commands import why_not_sent
from companion.outcomes import Failed, Outcome, Progress, Refusal
from companion.vehicle.services import Moment
from companion.vehicle.wire import COMPONENT, Wire

ONLINE_S = 3.0
"""A component is present if its newest heartbeat is not older; one comes each second."""
NUMBERS: dict[str, int] = {entry.name: n for n, entry in dialect.enums["MAV_CMD"].items()}


class PayloadCommands:
    """Implements `ports.payloads.Payloads`; a service of the vehicle.

    Args:
        wire: of the system that the payloads belong to.
    """

    wanted = frozenset({"COMMAND_ACK", "HEARTBEAT"})
    needs_control = True

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._commands = CommandSender()
        self._heard_s = 0.0
        self._targets: dict[int, int] = {}
        self._heartbeats_s: dict[int, float] = {}

    # -- port.Payloads -------------------------------------------------------------------------

    def number(self, command: str) -> int | None:
        """The number of a MAV_CMD; None if there is no command of that name."""
        return NUMBERS.get(command)

    def send(
        self, component: int, command: int, parameters: tuple[float, ...], timeout_s: float | None
    ) -> int:
        """Starts a command if payloads may receive it; returns its ticket."""
        p1, p2, p3, p4, p5, p6, p7 = (*parameters, *[0.0] * (7 - len(parameters)))
        target = (self._wire.system, component)
        ticket = self._commands.start(
            self._heard_s, target, command, (p1, p2, p3, p4, p5, p6, p7), timeout_s
        )
        self._targets[ticket] = component
        if why_not := why_not_sent(component, command):
            self._commands.refuse(ticket, Refusal(f"not sent: {why_not}"))
        return ticket

    def outcome(self, ticket: int) -> Outcome:
        """How far the command of a ticket has come."""
        exchange = self._commands[ticket]
        if exchange.has_failed:
            return Failed(exchange.in_words + self._absence(ticket, exchange))
        return Progress.DONE if exchange.result else Progress.RUNNING

    def leave(self, ticket: int) -> None:
        """Stops sending a command for now; its answer still counts."""
        self._commands.leave(ticket)

    def come_back(self, ticket: int) -> None:
        """Resumes a command that was left."""
        self._commands.come_back(ticket)

    def forget(self, ticket: int) -> None:
        """Drops a command; a component that still works on it gets no other with its number."""
        self._commands.abandon(ticket)
        self._targets.pop(ticket, None)

    def _absence(self, ticket: int, exchange: Exchange) -> str:
        """Words that say that the component is absent; "" if it is present or has answered."""
        component = self._targets[ticket]
        heard_s = self._heartbeats_s.get(component, -math.inf)
        if (
            exchange.result != "NO_ANSWER"
            or exchange.is_answered
            or self._heard_s - heard_s <= ONLINE_S
        ):
            return ""
        return f", and no heartbeat of component {component}"

    # -- services.Service ----------------------------------------------------------------------

    def step(self, moment: Moment) -> None:
        """Notes the time."""
        self._heard_s = moment.heard_s

    def take(self, moment: Moment, message: Message) -> None:
        """Takes an answer to our commands, or a heartbeat."""
        if message.get_type() == "HEARTBEAT":
            self._heartbeats_s[source(message)[1]] = moment.heard_s
            return
        if message.target_component in (0, COMPONENT):
            self._commands.receive(moment.heard_s, message)

    def due(self, moment: Moment) -> list[Message]:
        """The commands to send now."""
        return [] if moment.is_quiet else self._commands.due(moment.heard_s)

    def release(self) -> None:
        """Stops sending all commands."""
        self._commands.leave_all()
