"""The payload, the target detector, the lidar and the operator as MAVLink components.

Each is a component of its own beside the autopilot, with its own component id, sequence numbers and
HEARTBEAT at 1 Hz. The detector sends NAMED_VALUE_INT "target" at 2 Hz, the lidar OBSTACLE_DISTANCE
at 10 Hz. A command that a component does not know is UNSUPPORTED. sitl/world makes their decisions;
this module makes the messages, and routing.py chooses the links. The operator is a ground station
that sends only what the scenario says.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from companion.mavlink.framing import Message, dialect, source
from sitl.flight.physics import STANDING_M, FlightState
from sitl.link.component_sender import COMMANDS, ComponentSender, PackedMessage
from sitl.link.routing import target
from sitl.world.detector import TargetDetector
from sitl.world.lidar import BEAMS, Lidar
from sitl.world.payload import Payload

REPORT_S = 0.5
SCAN_S = 0.1
OPERATOR = (254, 190)
"""System and component of the operator; real ground stations use 255 by default."""
COMPANION = 191
NEAREST_CM = 5
TARGET_NAME = b"target"
_LASER, _BODY_FRD = 0, 12


class DetectorComponent:
    """The target detector as a component."""

    def __init__(self, system: int, detector: TargetDetector) -> None:
        self.address = (system, detector.component)
        self._detector = detector
        self._sender = ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """The detector has no commands."""
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
    """The payload as a component; answers every command that is addressed to it alone."""

    def __init__(self, system: int, payload: Payload) -> None:
        self.address = (system, payload.script.component)
        self._payload = payload
        self._sender = ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """A COMMAND_LONG or COMMAND_INT."""
        if message.get_type() not in COMMANDS or target(message) != self.address:
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
    """The operator: sends each command once, and ignores the answers."""

    address = OPERATOR

    def __init__(self, system: int, commands: list[str]) -> None:
        self._system = system
        self._commands = commands
        self._sender = ComponentSender(OPERATOR)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """The operator answers nothing."""
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
        self._sender = ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """The lidar has no commands."""
        return self._sender.refuse(message, self.address)

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT and the scan."""
        sent = self._sender.heartbeat(state.time_s)
        if self._sender.is_due(SCAN_S, state.time_s):
            roll_rad, pitch_rad, yaw_rad = state.euler
            up_m = STANDING_M - state.position[2]
            scan_m = self._lidar.scan(state.position[:2], yaw_rad, up_m, (roll_rad, pitch_rad))
            sent.append(self._sender.pack(self._report(scan_m, state.time_s)))
        return sent

    def _report(self, scan_m: npt.NDArray[np.float64], now_s: float) -> Message:
        far_cm = round(100 * self._lidar.spec.range_m)
        clear_cm = far_cm + 1  # for a beam that meets nothing
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
