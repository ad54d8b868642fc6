"""Component 191 towards ground stations: heartbeat, commands, texts, parameters and FTP.

Messages in, messages out. No I/O, and no state by which one ground station could block another.
Rules:

1. HEARTBEAT once a second, and at once when the status changes:

    STANDBY     nothing is flown
    ACTIVE      a sortie is flown, from arming to the landing
    CRITICAL    the last sortie failed, or the pilot or a failsafe has control

2. Commands are answered by `commands.py`. Commands to component 0 are left to the autopilot.
3. The end of a run is also reported to programs: NAMED_VALUE_INT `exit_code`, after its last text.
4. Answers are addressed to the sender of the request, by the target of the message. PARAM_VALUE has
   no target.

Sources: https://mavlink.io/en/services/ heartbeat, parameter, ping. TIMESYNC is answered by
`vehicle/time_answers.py`.
"""

from __future__ import annotations

from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import RunEnded
from companion.ground.commands import CommandService
from companion.ground.heartbeat import CompanionHeartbeat
from companion.ground.operations import MonitorPage, Operations, UploadService
from companion.ground.parameters import MONITOR, TEXT_LEVEL, CompanionParameters
from companion.ground.texts import INFO, WARNING, StatusTextQueue, severity
from companion.mavlink import ftp
from companion.mavlink.framing import Message, dialect, source
from companion.mission.signals import Signal
from companion.vehicle.wire import COMPONENT

EVERYBODY = 0

COMMANDS = frozenset({"COMMAND_LONG", "COMMAND_INT"})
FOR_ALL = frozenset({"PARAM_REQUEST_LIST", "PARAM_REQUEST_READ", "PING"})
"""Names of the messages that are read also if they are addressed to all components."""
WANTED = COMMANDS | FOR_ALL | {"PARAM_SET", "FILE_TRANSFER_PROTOCOL"}
"""Names of the messages that are read here."""


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
        self._texts, self._heartbeat = StatusTextQueue(), CompanionHeartbeat()
        self._commands = CommandService(operations, self._texts, self._heartbeat)
        self._out: list[Message] = []
        self._ending: list[Message] = []
        self._system = 0
        self._now_s = 0.0

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
        readings: list[tuple[Signal, float]] = []
        for message in messages:
            if message.get_type() in WANTED and self._is_for_us(message):
                if message.get_type() in COMMANDS:
                    readings += self._commands.awaited(message)
                self._out += self._answer(message)
        return readings

    def foresee(self, messages: list[Message]) -> list[tuple[Signal, float]]:
        """Like `receive`, for messages that have not been taken yet; does and answers nothing."""
        commands = [m for m in messages if m.get_type() in COMMANDS and self._is_for_us(m)]
        return [reading for m in commands for reading in self._commands.awaited(m)]

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
        messages = self._heartbeat.due(now_s, self._operations.system_status) + messages
        if not is_last:
            return messages + self._texts.due(now_s)
        ending, self._ending = self._ending, []
        return messages + self._texts.rest() + ending

    def _is_for_us(self, message: Message) -> bool:
        """Whether a message is addressed to us; or to all, for services that all components
        offer."""
        system, component = message.target_system, message.target_component
        if message.get_type() in FOR_ALL:
            return system in (EVERYBODY, self._system) and component in (EVERYBODY, COMPONENT)
        return (system, component) == (self._system, COMPONENT)

    # -- services ------------------------------------------------------------------------------

    def _answer(self, message: Message) -> list[Message]:
        match message.get_type():
            case "COMMAND_LONG" | "COMMAND_INT":
                return self._commands.answer(self._now_s, message)
            case "PARAM_REQUEST_LIST":
                return self.parameters.values()
            case "PARAM_REQUEST_READ":
                return self.parameters.read(message)
            case "PARAM_SET":
                return self.parameters.write(message)
            case "PING":
                return self._pong(message)
            case "FILE_TRANSFER_PROTOCOL":
                return self._ftp(message)
        return []

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

    def _pong(self, ping: Message) -> list[Message]:
        """Answers pings from other systems; those of the autopilot are meant for ground
        stations."""
        is_for_all = ping.target_system == ping.target_component == EVERYBODY
        if not is_for_all or ping.get_srcSystem() == self._system:
            return []
        return [dialect.MAVLink_ping_message(ping.time_usec, ping.seq, *source(ping))]

    def _ftp(self, message: Message) -> list[Message]:
        if self._uploads is None:
            refusal = ftp.refusal(message)
            return [refusal] if refusal else []
        client = source(message)
        return [
            dialect.MAVLink_file_transfer_protocol_message(0, *client, list(payload))
            for payload in self._uploads.ftp(self._now_s, client, bytes(message.payload))
        ]


def _exit_code(now_s: float, code: int) -> Message:
    boot_ms = int(now_s * 1000) & 0xFFFFFFFF
    return dialect.MAVLink_named_value_int_message(boot_ms, b"exit_code", code)
