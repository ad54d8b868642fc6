"""Component 191 towards ground stations: heartbeat, commands, texts, parameters and FTP.

Messages in, messages out. No I/O, and no state by which one ground station could block another.
Rules:

1. HEARTBEAT once a second, and at once when the status changes:

    STANDBY     nothing is flown
    ACTIVE      a sortie is flown, from arming to the landing
    CRITICAL    the last sortie failed, or the pilot or a failsafe has control

2. Every command to this component is answered in the tick in which it arrives: ACCEPTED, DENIED (it
   makes no sense), TEMPORARILY_REJECTED (not now; a STATUSTEXT says why) or UNSUPPORTED. A command
   that an event of the mission waits for is accepted. Commands to component 0 are left to the
   autopilot.
3. A command names a desired state. So a command that is repeated because its answer was lost gets
   the same answer, and changes nothing.
4. The end of a run is also reported to programs: NAMED_VALUE_INT `exit_code`, after its last text.
5. Answers are addressed to the sender of the request, by the target of the message. PARAM_VALUE has
   no target.

Sources: https://mavlink.io/en/services/ command, heartbeat, parameter, ping. Left out: message
intervals and missions (UNSUPPORTED). TIMESYNC is answered by `vehicle/time_answers.py`.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import ClassVar

from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import RunEnded
from companion.ground import about
from companion.ground.operations import MonitorPage, Operations, SystemStatus, UploadService
from companion.ground.parameters import MONITOR, TEXT_LEVEL, CompanionParameters
from companion.ground.texts import INFO, WARNING, StatusTextQueue, severity
from companion.mavlink import ftp
from companion.mavlink.framing import Message, dialect, source
from companion.mission.signals import COMMAND, Signal
from companion.outcomes import Refusal
from companion.vehicle.wire import COMPONENT

HEARTBEAT_S = 1.0
EVERYBODY = 0

ACCEPTED: int = dialect.MAV_RESULT_ACCEPTED
DENIED: int = dialect.MAV_RESULT_DENIED
UNSUPPORTED: int = dialect.MAV_RESULT_UNSUPPORTED
NOT_NOW: int = dialect.MAV_RESULT_TEMPORARILY_REJECTED

COMMANDS = frozenset({"COMMAND_LONG", "COMMAND_INT"})
REQUESTED: dict[int, Callable[[], Message]] = {
    dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION: about.autopilot_version,
    about.ProtocolVersion.id: about.protocol_version,
}
"""Message id -> the answer to MAV_CMD_REQUEST_MESSAGE; HEARTBEAT can be requested too."""

log = logging.getLogger(__name__)


class Component:
    """The companion as ground stations see it.

    Args:
        operations: does what operators request.
        uploads: missions from outside; if None, FTP is refused.
        page: the monitor page; if None, CMP_MONITOR stays 0.

    Attributes:
        parameters: the companion's own.
    """

    def __init__(
        self,
        operations: Operations,
        uploads: UploadService | None = None,
        page: MonitorPage | None = None,
    ) -> None:
        effects = {TEXT_LEVEL: self._tell_up_to, MONITOR: self._switch_page}
        self.parameters = CompanionParameters(effects)
        self._operations = operations
        self._uploads = uploads
        self._page = page
        self.parameters.put(MONITOR, self._is_page_served)
        self._texts = StatusTextQueue()
        self._out: list[Message] = []
        self._ending: list[Message] = []
        self._events: list[tuple[Signal, float]] = []
        self._system = 0
        self._now_s = 0.0
        self._told: SystemStatus | None = None
        self._next_heartbeat_s = 0.0

    # -- in ------------------------------------------------------------------------------------

    def receive(
        self, now_s: float, system: int, messages: list[Message]
    ) -> list[tuple[Signal, float]]:
        """Takes what has arrived; returns the commands that the mission's events wait for.

        Args:
            now_s: time of the tick.
            system: the vehicle's system id, which is our own.
            messages: everything that was heard; only messages of ground stations are read.
        """
        self._now_s, self._system = now_s, system
        self._events = []
        for message in messages:
            service = self.SERVICES.get(message.get_type())
            if service is not None and self._is_for_us(message):
                service(self, message)
        return self._events

    def foresee(self, messages: list[Message]) -> list[tuple[Signal, float]]:
        """Like `receive`, for messages that have not been taken yet; does and answers nothing."""
        commands = [m for m in messages if m.get_type() in COMMANDS and self._is_for_us(m)]
        return [reading for m in commands for reading in self._awaited(m.command)]

    def tell(self, now_s: float, event: FlightEvent) -> None:
        """Queues the text of an event that is meant for people."""
        if event.is_told:
            self._texts.tell(now_s, severity(event), event.text)
        if isinstance(event, RunEnded):
            self._ending.append(_exit_code(now_s, event.exit_code))

    def mark(self, name: str) -> None:
        """Sends the name of the run when the vehicle is armed, or that it is not recorded.

        PX4 writes the texts of its own system into the log that it begins on arming. A flight
        without a record sends as much, so that a lossy link treats both alike.
        """
        self._texts.mark(f"run {name}" if name else "run is not recorded")

    def transmit(self, now_s: float, is_last: bool = False) -> list[Message]:
        """Returns the messages to send now; at the end of a run, all that are left."""
        if not self._system:
            return []  # no vehicle was heard yet, so whatever is sent would be lost
        if self.parameters[MONITOR] and not self._is_page_served:
            self._out.append(self.parameters.put(MONITOR, False))
            self._texts.tell(now_s, WARNING, "monitor page has ended by itself")
        messages, self._out = self._out, []
        status = self._operations.system_status
        if now_s >= self._next_heartbeat_s or status is not self._told:
            self._next_heartbeat_s, self._told = now_s + HEARTBEAT_S, status
            messages.insert(0, about.heartbeat(status))
        if not is_last:
            return messages + self._texts.due(now_s)
        ending, self._ending = self._ending, []
        return messages + self._texts.rest() + ending

    def _is_for_us(self, message: Message) -> bool:
        """Whether a message is addressed to us; or to all, for services that all components
        offer."""
        system, component = message.target_system, message.target_component
        if message.get_type() in self.FOR_ALL:
            return system in (EVERYBODY, self._system) and component in (EVERYBODY, COMPONENT)
        return (system, component) == (self._system, COMPONENT)

    # -- commands ------------------------------------------------------------------------------

    def _command(self, message: Message) -> None:
        result = self._do(message.command, _parameters(message))
        log.debug("command %d of %d/%d: result %d", message.command, *source(message), result)
        answer = dialect.MAVLink_command_ack_message(
            message.command, result, 0, 0, *source(message)
        )
        self._out.append(answer)

    def _do(self, command: int, parameters: list[float]) -> int:
        is_awaited = bool(readings := self._awaited(command))
        self._events += readings
        action = self.ACTIONS.get(command)
        if action is None or (is_awaited and command not in self.ALSO_WITH_EVENTS):
            return ACCEPTED if is_awaited else UNSUPPORTED
        return action(self, parameters)

    def _awaited(self, command: int) -> list[tuple[Signal, float]]:
        """The reading of a command that the mission's events wait for; [] for other commands."""
        entry = dialect.enums["MAV_CMD"].get(command)
        is_awaited = entry is not None and entry.name in self._operations.awaited
        return [(Signal(COMMAND, "", entry.name), 1.0)] if is_awaited else []

    def _result(self, refusal: Refusal | None) -> int:
        """Returns the MAV_RESULT of a request; also sends a refusal as a text."""
        if refusal is None:
            return ACCEPTED
        self._tell_refusal(refusal.reason)
        return NOT_NOW

    def _tell_refusal(self, reason: str) -> None:
        self._texts.tell(self._now_s, WARNING, f"refused: {reason}")

    def _start(self, _: list[float]) -> int:
        return self._result(self._operations.start())

    def _pause_or_resume(self, parameters: list[float]) -> int:
        if parameters[0] == 0.0:
            return self._result(self._operations.pause())
        if parameters[0] == 1.0:
            return self._result(self._operations.resume())
        return DENIED

    def _return_home(self, _: list[float]) -> int:
        return self._result(self._operations.return_home())

    def _refuse_item(self, _: list[float]) -> int:
        self._tell_refusal("the task decides what comes next, there are no mission items")
        return DENIED

    def _request_message(self, parameters: list[float]) -> int:
        number = parameters[0]
        if number == dialect.MAVLINK_MSG_ID_HEARTBEAT:
            self._told = None
            return ACCEPTED
        message = REQUESTED.get(int(number)) if number == number // 1 else None
        if message is None:
            return UNSUPPORTED
        self._out.append(message())
        return ACCEPTED

    def _request_protocol(self, _: list[float]) -> int:
        return self._request_message([about.ProtocolVersion.id])

    def _request_capabilities(self, _: list[float]) -> int:
        return self._request_message([dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION])

    # -- other services ------------------------------------------------------------------------

    def _list(self, _: Message) -> None:
        self._out += self.parameters.values()

    def _read(self, message: Message) -> None:
        self._out += self.parameters.read(message)

    def _write(self, message: Message) -> None:
        self._out += self.parameters.write(message)

    def _tell_up_to(self, level: float) -> float:
        self._texts.level = int(level)
        return level

    @property
    def _is_page_served(self) -> bool:
        return self._page is not None and self._page.is_served

    def _switch_page(self, value: float) -> float:
        """Starts or ends the page if possible; returns whether it is served then."""
        is_on = bool(value)
        if self._page is not None and is_on is not self._is_page_served:
            text = self._page.switch(is_on)
            level = INFO if is_on is self._is_page_served else WARNING
            self._texts.tell(self._now_s, level, text)
        return self._is_page_served

    def _ping(self, message: Message) -> None:
        """Answers pings from other systems; those of the autopilot are meant for ground
        stations."""
        is_for_all = message.target_system == message.target_component == EVERYBODY
        if is_for_all and message.get_srcSystem() != self._system:
            pong = dialect.MAVLink_ping_message(message.time_usec, message.seq, *source(message))
            self._out.append(pong)

    def _ftp(self, message: Message) -> None:
        if self._uploads is None:
            answer = ftp.refusal(message)
            self._out += [answer] if answer else []
            return
        client = source(message)
        for payload in self._uploads.ftp(self._now_s, client, bytes(message.payload)):
            self._out.append(
                dialect.MAVLink_file_transfer_protocol_message(0, *client, list(payload))
            )

    ACTIONS: ClassVar[dict[int, Callable[[Component, list[float]], int]]] = {
        dialect.MAV_CMD_MISSION_START: _start,
        dialect.MAV_CMD_DO_PAUSE_CONTINUE: _pause_or_resume,
        dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH: _return_home,
        dialect.MAV_CMD_DO_SET_MISSION_CURRENT: _refuse_item,
        dialect.MAV_CMD_REQUEST_MESSAGE: _request_message,
        dialect.MAV_CMD_REQUEST_PROTOCOL_VERSION: _request_protocol,
        dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: _request_capabilities,
    }
    """Command -> the method that does it and returns the MAV_RESULT."""
    ALSO_WITH_EVENTS = frozenset(
        {
            dialect.MAV_CMD_MISSION_START,
            dialect.MAV_CMD_DO_PAUSE_CONTINUE,
            dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH,
        }
    )
    """Commands that are done even if an event waits for them."""

    SERVICES: ClassVar[dict[str, Callable[[Component, Message], None]]] = {
        **dict.fromkeys(COMMANDS, _command),
        "PARAM_REQUEST_LIST": _list,
        "PARAM_REQUEST_READ": _read,
        "PARAM_SET": _write,
        "PING": _ping,
        "FILE_TRANSFER_PROTOCOL": _ftp,
    }
    """Message -> the method that answers it."""
    FOR_ALL = frozenset({"PARAM_REQUEST_LIST", "PARAM_REQUEST_READ", "PING"})


WANTED = frozenset(Component.SERVICES)
"""Names of the messages that are read here."""


def _parameters(message: Message) -> list[float]:
    """Returns param1 to param7 of COMMAND_LONG, or their counterparts in COMMAND_INT."""
    if message.get_type() == "COMMAND_LONG":
        names = ("param1", "param2", "param3", "param4", "param5", "param6", "param7")
    else:
        names = ("param1", "param2", "param3", "param4", "x", "y", "z")
    return [float(getattr(message, name)) for name in names]


def _exit_code(now_s: float, code: int) -> Message:
    boot_ms = int(now_s * 1000) & 0xFFFFFFFF
    return dialect.MAVLink_named_value_int_message(boot_ms, b"exit_code", code)
