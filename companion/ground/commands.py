"""Answers commands to component 191: start, pause, continue, fly home, say what you are.

Every command is answered in the tick in which it arrives:

    ACCEPTED               it is done, or the desired state is there already
    DENIED                 it makes no sense
    TEMPORARILY_REJECTED   not now; a STATUSTEXT says why
    UNSUPPORTED            it is another component's, or nobody's

A command names a desired state. So a command that is repeated because its answer was lost gets the
same answer, and changes nothing. A command that an event of the mission waits for is accepted.

Source: https://mavlink.io/en/services/command.html. Left out: message intervals and missions.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from companion.ground import about
from companion.ground.heartbeat import CompanionHeartbeat
from companion.ground.operations import Operations
from companion.ground.texts import WARNING, StatusTextQueue
from companion.mavlink.framing import Message, dialect, source
from companion.mission.signals import COMMAND, Signal
from companion.outcomes import Refusal

ACCEPTED: int = dialect.MAV_RESULT_ACCEPTED
DENIED: int = dialect.MAV_RESULT_DENIED
UNSUPPORTED: int = dialect.MAV_RESULT_UNSUPPORTED
NOT_NOW: int = dialect.MAV_RESULT_TEMPORARILY_REJECTED

REQUESTED: dict[int, Callable[[], Message]] = {
    dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION: about.autopilot_version,
    about.ProtocolVersion.id: about.protocol_version,
}
"""Message id -> the answer to MAV_CMD_REQUEST_MESSAGE; HEARTBEAT can be requested too."""
ALSO_WITH_EVENTS = frozenset(
    {
        dialect.MAV_CMD_MISSION_START,
        dialect.MAV_CMD_DO_PAUSE_CONTINUE,
        dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    }
)
"""Commands that are done even if an event waits for them."""
NO_ITEMS = Refusal("the task decides what comes next, there are no mission items")

log = logging.getLogger(__name__)


class CommandService:
    """Does what commands request.

    Args:
        operations: does what operators request.
        texts: says why not.
        heartbeat: may be requested.
    """

    def __init__(
        self, operations: Operations, texts: StatusTextQueue, heartbeat: CompanionHeartbeat
    ) -> None:
        self._operations, self._texts, self._heartbeat = operations, texts, heartbeat

    def awaited(self, message: Message) -> list[tuple[Signal, float]]:
        """The reading of a command that the mission's events wait for; [] for other commands."""
        entry = dialect.enums["MAV_CMD"].get(message.command)
        is_awaited = entry is not None and entry.name in self._operations.awaited
        return [(Signal(COMMAND, "", entry.name), 1.0)] if is_awaited else []

    def answer(self, now_s: float, message: Message) -> list[Message]:
        """Does a command; returns the message that it requests, if any, and its COMMAND_ACK."""
        command, operations = message.command, self._operations
        if self.awaited(message) and command not in ALSO_WITH_EVENTS:
            return [_ack(message, ACCEPTED)]
        match command:
            case dialect.MAV_CMD_MISSION_START:
                result = self._result(now_s, operations.start())
            case dialect.MAV_CMD_DO_PAUSE_CONTINUE if _first(message) == 0.0:
                result = self._result(now_s, operations.pause())
            case dialect.MAV_CMD_DO_PAUSE_CONTINUE if _first(message) == 1.0:
                result = self._result(now_s, operations.resume())
            case dialect.MAV_CMD_DO_PAUSE_CONTINUE:
                result = DENIED
            case dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH:
                result = self._result(now_s, operations.return_home())
            case dialect.MAV_CMD_DO_SET_MISSION_CURRENT:
                self._tell_refusal(now_s, NO_ITEMS)
                result = DENIED
            case dialect.MAV_CMD_REQUEST_MESSAGE:
                return self._requested(message, _first(message))
            case dialect.MAV_CMD_REQUEST_PROTOCOL_VERSION:
                return self._requested(message, about.ProtocolVersion.id)
            case dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
                return self._requested(message, dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
            case _:
                result = UNSUPPORTED
        return [_ack(message, result)]

    def _requested(self, command: Message, number: float) -> list[Message]:
        """The message with a number, and the answer to the command that requests it."""
        if number == dialect.MAVLINK_MSG_ID_HEARTBEAT:
            self._heartbeat.request()
            return [_ack(command, ACCEPTED)]
        message = REQUESTED.get(int(number)) if number == number // 1 else None
        return (
            [_ack(command, UNSUPPORTED)]
            if message is None
            else [message(), _ack(command, ACCEPTED)]
        )

    def _result(self, now_s: float, refusal: Refusal | None) -> int:
        """Returns the MAV_RESULT of a request; also sends a refusal as a text."""
        if refusal is None:
            return ACCEPTED
        self._tell_refusal(now_s, refusal)
        return NOT_NOW

    def _tell_refusal(self, now_s: float, refusal: Refusal) -> None:
        self._texts.tell(now_s, WARNING, f"refused: {refusal.reason}")


def _first(command: Message) -> float:
    """The first parameter of COMMAND_LONG or COMMAND_INT."""
    return float(command.param1)


def _ack(command: Message, result: int) -> Message:
    log.debug("command %d of %d/%d: result %d", command.command, *source(command), result)
    return dialect.MAVLink_command_ack_message(command.command, result, 0, 0, *source(command))
