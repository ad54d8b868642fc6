"""A gimbal as a MAVLink component: device and manager in one, by the gimbal protocol, version 2.

Source: https://mavlink.io/en/services/gimbal_v2.html.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Message, dialect, source
from sitl.flight.physics import FlightState
from sitl.link.component_sender import COMMANDS, ComponentSender, PackedMessage
from sitl.link.routing import target
from sitl.results import MavResult
from sitl.world.gimbal import IN_EARTH_FRAME, IN_VEHICLE_FRAME, YAW_LOCK, Gimbal
from sitl.world.payload import CommandAck

ATTITUDE_S, STATUS_S = 0.1, 0.5
_LEVEL = 4 | 8  # roll and pitch are locked
_GIMBAL = dialect.MAV_TYPE_GIMBAL
_CONFIGURE = dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE
_TURN = dialect.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW
_INFORMATION = dialect.MAVLINK_MSG_ID_GIMBAL_MANAGER_INFORMATION


class GimbalComponent:
    """The gimbal as a component.

    Args:
        system: the system id of the vehicle.
        gimbal: its mechanics and control.
    """

    def __init__(self, system: int, gimbal: Gimbal) -> None:
        self.address = (system, gimbal.spec.component)
        self._gimbal = gimbal
        self._sender = ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Handles a command to the gimbal."""
        if self._gimbal.is_silent:
            return []
        if message.get_type() not in COMMANDS or target(message) != self.address:
            return []
        command, asker = message.command, source(message)
        if command == _CONFIGURE:
            ack = self._gimbal.configure(asker, message.param1, message.param2)
        elif command == _TURN:
            flags = getattr(message, "param5", None)
            flags = message.x if flags is None else flags
            ack = self._gimbal.turn(asker, message.param1, message.param2, flags)
        elif command == dialect.MAV_CMD_REQUEST_MESSAGE and message.param1 == _INFORMATION:
            ack = CommandAck(asker, MavResult.ACCEPTED)
            said = self._sender.pack(self._information(state))
            return [self._sender.acknowledge(command, ack), said]
        else:
            return self._sender.refuse(message, self.address)
        return [self._sender.acknowledge(command, ack)]

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT, its attitude, and who controls it."""
        now_s = state.time_s
        self._gimbal.step(state.euler[2], now_s)
        sent = self._sender.heartbeat(now_s, _GIMBAL)
        if self._sender.is_due(ATTITUDE_S, now_s):
            sent.append(self._sender.pack(self._attitude(state)))
        if self._sender.is_due(STATUS_S, now_s):
            sent.append(self._sender.pack(self._status(state)))
        return [] if self._gimbal.is_silent else sent

    @property
    def _flags(self) -> int:
        is_in_earth_frame = self._gimbal.is_in_earth_frame
        return _LEVEL | (YAW_LOCK | IN_EARTH_FRAME if is_in_earth_frame else IN_VEHICLE_FRAME)

    def _attitude(self, state: FlightState) -> Message:
        yaw_rad = self._gimbal.yaw_rad
        if self._gimbal.is_in_earth_frame:
            yaw_rad += state.euler[2]
        return dialect.MAVLink_gimbal_device_attitude_status_message(
            0,
            0,
            _ms(state),
            self._flags,
            _quaternion(self._gimbal.pitch_rad, yaw_rad),
            *(math.nan,) * 3,
            0,
            math.nan,
            math.nan,
            0,
        )

    def _status(self, state: FlightState) -> Message:
        own = self.address[1]
        return dialect.MAVLink_gimbal_manager_status_message(
            _ms(state), self._flags, own, *self._gimbal.control, 0, 0
        )

    def _information(self, state: FlightState) -> Message:
        lowest, highest = self._gimbal.spec.pitch_rad
        return dialect.MAVLink_gimbal_manager_information_message(
            _ms(state),
            cap_flags=0,
            gimbal_device_id=self.address[1],
            roll_min=0.0,
            roll_max=0.0,
            pitch_min=lowest,
            pitch_max=highest,
            yaw_min=-math.pi,
            yaw_max=math.pi,
        )


def _quaternion(pitch_rad: float, yaw_rad: float) -> tuple[float, float, float, float]:
    """The attitude as w, x, y, z; level in roll."""
    sin_p, cos_p = math.sin(pitch_rad / 2), math.cos(pitch_rad / 2)
    sin_y, cos_y = math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)
    return (cos_p * cos_y, -sin_p * sin_y, sin_p * cos_y, cos_p * sin_y)


def _ms(state: FlightState) -> int:
    return round(state.time_s * 1e3)
