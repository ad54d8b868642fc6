"""The payload, the target detector, the lidar and the operator as MAVLink components.

Each is a component of its own, beside the autopilot: own component id, own sequence numbers, own
HEARTBEAT at 1 Hz. The detector reports NAMED_VALUE_INT "target" at 2 Hz, the lidar
OBSTACLE_DISTANCE at 10 Hz. A command that a component does not know is UNSUPPORTED. What they
decide is in sitl/world; here it becomes messages. They send to whoever listens; routing.py says
where that is. The operator is a ground station that says only what the scenario makes it say.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from companion.mavlink.framing import MavlinkCodec, Message, dialect, source
from sitl.flight.physics import FlightState
from sitl.link.routing import target
from sitl.results import MavResult
from sitl.world.detector import TargetDetector
from sitl.world.lidar import BEAMS, Lidar
from sitl.world.payload import CommandAck, Payload

HEARTBEAT_S = 1.0
REPORT_S = 0.5
SCAN_S = 0.1
OPERATOR = (254, 190)
"""System and component of the operator; real ground stations are 255 by default."""
COMPANION = 191
NEAREST_CM = 5
TARGET_NAME = b"target"
_COMMANDS = ("COMMAND_LONG", "COMMAND_INT")
_LASER, _BODY_FRD = 0, 12
_ONBOARD_CONTROLLER, _NO_AUTOPILOT, _ACTIVE = 18, 8, 4

PackedMessage = tuple[Message, bytes]
"""A message and its frame."""


class OnboardComponent(Protocol):
    """A component on board."""

    address: tuple[int, int]

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Handles any message; returns what is sent at once."""

    def step(self, state: FlightState) -> list[PackedMessage]:
        """The messages that are due now."""


class _ComponentSender:
    """Packs messages and keeps time for what repeats."""

    def __init__(self, address: tuple[int, int]) -> None:
        self._codec = MavlinkCodec(*address)
        self._next_s: dict[float, float] = {}

    def pack(self, message: Message) -> PackedMessage:
        return message, self._codec.pack(message)

    def is_due(self, every_s: float, now_s: float) -> bool:
        next_s = self._next_s.get(every_s, now_s)
        if now_s < next_s:
            return False
        self._next_s[every_s] = next_s + every_s
        return True

    def acknowledge(self, command: int, reply: CommandAck) -> PackedMessage:
        return self.pack(
            dialect.MAVLink_command_ack_message(
                command, reply.result, reply.progress, 0, *reply.requester
            )
        )

    def refuse(self, message: Message, address: tuple[int, int]) -> list[PackedMessage]:
        """UNSUPPORTED for any command."""
        if message.get_type() not in _COMMANDS or target(message) != address:
            return []
        return [
            self.acknowledge(message.command, CommandAck(source(message), MavResult.UNSUPPORTED)),
        ]

    def heartbeat(self, now_s: float) -> list[PackedMessage]:
        if not self.is_due(HEARTBEAT_S, now_s):
            return []
        return [
            self.pack(
                dialect.MAVLink_heartbeat_message(
                    _ONBOARD_CONTROLLER, _NO_AUTOPILOT, 0, 0, _ACTIVE, 3
                )
            )
        ]


class DetectorComponent:
    """The target detector as a component."""

    def __init__(self, system: int, detector: TargetDetector) -> None:
        self.address = (system, detector.component)
        self._detector = detector
        self._sender = _ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Knows no command."""
        return self._sender.refuse(message, self.address)

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT and the report."""
        sent = self._sender.heartbeat(state.time_s)
        if self._sender.is_due(REPORT_S, state.time_s):
            report = dialect.MAVLink_named_value_int_message(
                round(state.time_s * 1e3), TARGET_NAME, int(self._detector.sees_target)
            )
            sent.append(self._sender.pack(report))
        return sent


class PayloadComponent:
    """The payload as a component; answers every command that is for it alone."""

    def __init__(self, system: int, payload: Payload) -> None:
        self.address = (system, payload.script.component)
        self._payload = payload
        self._sender = _ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """A COMMAND_LONG or COMMAND_INT."""
        if message.get_type() not in _COMMANDS or target(message) != self.address:
            return []
        reply = self._payload.receive(
            source(message),
            message.command,
            state.position,
            state.time_s,
            is_repeated=getattr(message, "confirmation", 0) > 0,
        )
        return [self._sender.acknowledge(message.command, reply)] if reply else []

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT, progress and the final answer."""
        sent = self._sender.heartbeat(state.time_s)
        if reply := self._payload.step(state.time_s):
            sent.append(self._sender.acknowledge(self._payload.script.command, reply))
        return sent


class OperatorComponent:
    """The operator: sends each command once, and leaves the answers unread."""

    address = OPERATOR

    def __init__(self, system: int, commands: list[str]) -> None:
        self._system = system
        self._commands = commands
        self._sender = _ComponentSender(OPERATOR)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Nothing is answered."""
        return []

    def step(self, state: FlightState) -> list[PackedMessage]:
        """The commands of the scenario, as COMMAND_LONG with all parameters 0."""
        sent = [
            self._sender.pack(
                dialect.MAVLink_command_long_message(
                    self._system, COMPANION, getattr(dialect, command), 0, *(0.0,) * 7
                )
            )
            for command in self._commands
        ]
        self._commands.clear()
        return sent


class LidarComponent:
    """The lidar as a component."""

    def __init__(self, system: int, lidar: Lidar) -> None:
        self.address = (system, lidar.spec.component)
        self._lidar = lidar
        self._sender = _ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Knows no command."""
        return self._sender.refuse(message, self.address)

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT and the scan."""
        sent = self._sender.heartbeat(state.time_s)
        if self._sender.is_due(SCAN_S, state.time_s):
            scan_m = self._lidar.scan(state.position[:2], state.euler[2], -state.position[2])
            sent.append(self._sender.pack(self._report(scan_m, state.time_s)))
        return sent

    def _report(self, scan_m: npt.NDArray[np.float64], now_s: float) -> Message:
        far_cm = round(100 * self._lidar.spec.range_m)
        clear_cm = far_cm + 1  # of a beam that meets nothing
        in_range_cm = np.minimum(np.maximum(np.rint(100 * scan_m), NEAREST_CM), far_cm)
        scan_cm = np.where(scan_m < math.inf, in_range_cm, clear_cm)
        return dialect.MAVLink_obstacle_distance_message(
            round(now_s * 1e6),
            _LASER,
            scan_cm.astype(int).tolist(),
            360 // BEAMS,
            NEAREST_CM,
            far_cm,
            360 / BEAMS,
            0.0,
            _BODY_FRD,
        )
