"""How do the payload and the target detector speak MAVLink?

Each is a component of its own on board, beside the autopilot: own component id, own sequence
numbers, own HEARTBEAT at 1 Hz. The detector reports NAMED_VALUE_INT "target" at 2 Hz. What they
decide is in sitl/world; here it becomes messages. They send to whoever listens; routing.py says
where that is.
"""

from __future__ import annotations

from typing import Protocol

from companion.geometry import Ned
from companion.mavlink.framing import Endpoint, Message, dialect, source
from sitl.flight.physics import FlightState
from sitl.link.routing import target
from sitl.results import Result
from sitl.world.detector import Detector
from sitl.world.payload import Asker, Payload

HEARTBEAT_S = 1.0
REPORT_S = 0.5
TARGET_NAME = b"target"
_ONBOARD_CONTROLLER, _NO_AUTOPILOT, _ACTIVE = 18, 8, 4

Sent = tuple[Message, bytes]
"""A message and its frame."""


class Device(Protocol):
    """A component on board."""

    address: tuple[int, int]

    def receive(self, message: Message, state: FlightState) -> list[Sent]:
        """Handle any message; what is sent at once."""

    def step(self, state: FlightState) -> list[Sent]:
        """What is due now."""


class _Voice:
    """Packs messages and keeps time for what repeats."""

    def __init__(self, address: tuple[int, int]) -> None:
        self._endpoint = Endpoint(*address)
        self._next_s: dict[float, float] = {}

    def say(self, message: Message) -> Sent:
        return message, self._endpoint.pack(message)

    def is_due(self, every_s: float, now_s: float) -> bool:
        next_s = self._next_s.get(every_s, now_s)
        if now_s < next_s:
            return False
        self._next_s[every_s] = next_s + every_s
        return True

    def heartbeat(self, now_s: float) -> list[Sent]:
        if not self.is_due(HEARTBEAT_S, now_s):
            return []
        return [
            self.say(
                dialect.MAVLink_heartbeat_message(
                    _ONBOARD_CONTROLLER, _NO_AUTOPILOT, 0, 0, _ACTIVE, 3
                )
            )
        ]


class DetectorDevice:
    """The target detector as a component."""

    def __init__(self, system: int, detector: Detector) -> None:
        self.address = (system, detector.sighting.component)
        self._detector = detector
        self._voice = _Voice(self.address)

    def receive(self, message: Message, state: FlightState) -> list[Sent]:
        """Listens to nobody."""
        return []

    def step(self, state: FlightState) -> list[Sent]:
        """HEARTBEAT and the report."""
        self._detector.update(state.position)
        sent = self._voice.heartbeat(state.time_s)
        if self._voice.is_due(REPORT_S, state.time_s):
            report = dialect.MAVLink_named_value_int_message(
                round(state.time_s * 1e3), TARGET_NAME, int(self._detector.sees_target)
            )
            sent.append(self._voice.say(report))
        return sent


class PayloadDevice:
    """The payload as a component; answers every command that is for it alone."""

    def __init__(self, system: int, payload: Payload) -> None:
        self.address = (system, payload.script.component)
        self._payload = payload
        self._voice = _Voice(self.address)

    def receive(self, message: Message, state: FlightState) -> list[Sent]:
        """A COMMAND_LONG or COMMAND_INT."""
        if message.get_type() not in ("COMMAND_LONG", "COMMAND_INT"):
            return []
        if target(message) != self.address:
            return []
        position: Ned = state.position
        answer = self._payload.ask(source(message), message.command, position, state.time_s)
        return [self._acknowledge(message.command, answer, source(message))]

    def step(self, state: FlightState) -> list[Sent]:
        """HEARTBEAT and the final answer."""
        sent = self._voice.heartbeat(state.time_s)
        if finished := self._payload.finished(state.time_s):
            asker, answer = finished
            sent.append(self._acknowledge(self._payload.script.command, answer, asker))
        return sent

    def _acknowledge(self, command: int, answer: Result, asker: Asker) -> Sent:
        return self._voice.say(dialect.MAVLink_command_ack_message(command, answer, 0, 0, *asker))
