"""The MAVLink commands of the autopilot and their results.

`COMMANDS` maps a MAV_CMD to a function of the autopilot's link and the seven parameters; all others
are UNSUPPORTED. COMMAND_LONG and COMMAND_INT are first converted to a `CommandRequest`. Results and
meanings of parameters are PX4's (common.xml and observed answers). The autopilot writes the reason
of a rejection as STATUSTEXT.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from companion.mavlink.framing import Message, dialect
from companion.mavlink.px4_modes import mode_from
from sitl.autopilot.modes import FLIGHT_MODES
from sitl.link.vehicle import SimulatedVehicle
from sitl.results import MavResult

FORCE = 21196  # magic number of MAV_CMD_COMPONENT_ARM_DISARM
CHANGE_MODE = 1  # MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
RELATIVE_FRAMES = (3, 6)  # MAV_FRAME_GLOBAL_RELATIVE_ALT(_INT)
HIGHEST_HOME_M = 100_000.0
UINT16_MAX = 2**16 - 1
INT_UNKNOWN = 2**31 - 1  # COMMAND_INT's x or y: not given


@dataclass(frozen=True, slots=True)
class CommandRequest:
    """A COMMAND_LONG or COMMAND_INT.

    Attributes:
        command: MAV_CMD.
        parameters: param1 to param7; positions in degrees, NaN where not given.
        is_relative: whether param7 is above home; otherwise it is above sea level.
    """

    command: int
    parameters: tuple[float, ...]
    is_relative: bool = False


class CommandContext(Protocol):
    """One link of the autopilot, on which the commands act."""

    vehicle: SimulatedVehicle

    def send(self, message: Message) -> None:
        """Sends a message on this link."""

    def ask_for_checks(self) -> None:
        """Reports the arming checks in the next step."""

    def interval_us(self, message_id: int) -> int:
        """Interval of a stream; 0 for what is not streamed."""

    def request_message(self, message_id: int) -> bool:
        """Sends a message once; False if the id is unknown."""

    def set_interval(self, message_id: int, interval_us: float) -> bool:
        """Changes a stream's interval; False if it is not streamed."""


def request_from(message: Message) -> CommandRequest:
    """The request in a COMMAND_LONG or COMMAND_INT."""
    first = (message.param1, message.param2, message.param3, message.param4)
    if message.get_type() == "COMMAND_LONG":
        return CommandRequest(
            message.command, (*first, message.param5, message.param6, message.param7)
        )
    x, y = (math.nan if v == INT_UNKNOWN else v / 1e7 for v in (message.x, message.y))
    is_relative = message.frame in RELATIVE_FRAMES
    return CommandRequest(message.command, (*first, x, y, message.z), is_relative)


def execute(on: CommandContext, request: CommandRequest) -> MavResult:
    """Executes a request; returns its result."""
    handler = COMMANDS.get(request.command)
    return handler(on, request) if handler else MavResult.UNSUPPORTED


def _granted(is_granted: bool) -> MavResult:
    return MavResult.ACCEPTED if is_granted else MavResult.TEMPORARILY_REJECTED


def _arm_disarm(on: CommandContext, request: CommandRequest) -> MavResult:
    autopilot, is_forced = on.vehicle.autopilot, request.parameters[1] == FORCE
    act = {1.0: autopilot.arm, 0.0: autopilot.disarm}.get(request.parameters[0])
    return _granted(act(is_forced=is_forced)) if act else MavResult.UNSUPPORTED


def _do_set_mode(on: CommandContext, request: CommandRequest) -> MavResult:
    base, main, sub = request.parameters[:3]
    if not all(math.isfinite(p) for p in (base, main, sub)) or not int(base) & 1:
        return MavResult.UNSUPPORTED  # PX4 knows only custom modes
    mode = mode_from(int(main), int(sub))
    if mode not in FLIGHT_MODES:
        return MavResult.TEMPORARILY_REJECTED
    return _granted(on.vehicle.autopilot.set_mode(mode))


def _takeoff(on: CommandContext, request: CommandRequest) -> MavResult:
    return _granted(on.vehicle.autopilot.take_off(_down_m(on, request)))


def _mode(name: str) -> Callable[[CommandContext, CommandRequest], MavResult]:
    return lambda on, request: _granted(on.vehicle.autopilot.set_mode(name))


def _reposition(on: CommandContext, request: CommandRequest) -> MavResult:
    autopilot = on.vehicle.autopilot
    flags, yaw_rad, lat_deg, lon_deg = (request.parameters[i] for i in (1, 3, 4, 5))
    if not math.isfinite(flags) or not int(flags) & CHANGE_MODE:
        if autopilot.mode != "AUTO.LOITER":
            return MavResult.DENIED
    north_m = east_m = None
    if math.isfinite(lat_deg) and math.isfinite(lon_deg):
        north_m, east_m, _ = on.vehicle.origin.to_local(lat_deg, lon_deg, 0.0)
    yaw = yaw_rad if math.isfinite(yaw_rad) else None
    return _granted(autopilot.hold_at((north_m, east_m, _down_m(on, request)), yaw))


def _down_m(on: CommandContext, request: CommandRequest) -> float | None:
    """param7 as down in local NED; None if it is not given."""
    altitude_m = request.parameters[6]
    if not math.isfinite(altitude_m):
        return None
    if request.is_relative:
        return on.vehicle.autopilot.home[2] - altitude_m
    return on.vehicle.origin.altitude_m - altitude_m


def _request_message(on: CommandContext, request: CommandRequest) -> MavResult:
    return MavResult.ACCEPTED if on.request_message(_id(request)) else MavResult.DENIED


def _set_message_interval(on: CommandContext, request: CommandRequest) -> MavResult:
    interval_us = request.parameters[1]
    is_set = math.isfinite(interval_us) and on.set_interval(_id(request), interval_us)
    return MavResult.ACCEPTED if is_set else MavResult.FAILED


def _get_message_interval(on: CommandContext, request: CommandRequest) -> MavResult:
    number = _id(request)
    if not 0 <= number <= UINT16_MAX:
        return MavResult.DENIED
    interval_us = on.interval_us(number)
    on.send(dialect.MAVLink_message_interval_message(number, interval_us))
    return MavResult.ACCEPTED


def _answer_with(message_id: int) -> Callable[[CommandContext, CommandRequest], MavResult]:
    """Handles an older command that requests one message."""

    def handler(on: CommandContext, request: CommandRequest) -> MavResult:
        return MavResult.ACCEPTED if on.request_message(message_id) else MavResult.DENIED

    return handler


def _accepted(on: CommandContext, request: CommandRequest) -> MavResult:
    """Accepts a command that asks for what is already so."""
    return MavResult.ACCEPTED


def _run_prearm_checks(on: CommandContext, request: CommandRequest) -> MavResult:
    autopilot = on.vehicle.autopilot
    if autopilot.is_armed:
        return MavResult.TEMPORARILY_REJECTED
    autopilot.report_arming_denial()
    on.ask_for_checks()
    return MavResult.ACCEPTED


def _set_home(on: CommandContext, request: CommandRequest) -> MavResult:
    vehicle, (current, _, _, _, lat_deg, lon_deg, altitude_m) = on.vehicle, request.parameters
    if current == 1:
        vehicle.autopilot.home = vehicle.state.position
        return MavResult.ACCEPTED
    if not (abs(lat_deg) <= 90 and abs(lon_deg) <= 180 and abs(altitude_m) <= HIGHEST_HOME_M):
        return MavResult.DENIED
    vehicle.autopilot.home = vehicle.origin.to_local(lat_deg, lon_deg, altitude_m)
    return MavResult.ACCEPTED


def _change_speed(on: CommandContext, request: CommandRequest) -> MavResult:
    _, speed_mps, *_ = request.parameters
    if not math.isfinite(speed_mps) or speed_mps == 0:
        return MavResult.DENIED
    on.vehicle.autopilot.cruise_mps = speed_mps if speed_mps > 0 else None
    return MavResult.ACCEPTED


def _mission_start(on: CommandContext, request: CommandRequest) -> MavResult:
    vehicle, (first, *_) = on.vehicle, request.parameters
    mission = vehicle.autopilot.mission
    if not (mission.is_ready(vehicle.state.time_s) and -1 <= first < len(mission.items)):
        return MavResult.DENIED
    return _granted(vehicle.autopilot.start_mission(int(first) if first >= 0 else None))


def _terminate(on: CommandContext, request: CommandRequest) -> MavResult:
    if request.parameters[0] > 0.5:
        on.vehicle.autopilot.terminate()
    return MavResult.ACCEPTED


def _id(request: CommandRequest) -> int:
    value = request.parameters[0]
    return int(value) if math.isfinite(value) else -1


COMMANDS: dict[int, Callable[[CommandContext, CommandRequest], MavResult]] = {
    dialect.MAV_CMD_COMPONENT_ARM_DISARM: _arm_disarm,
    dialect.MAV_CMD_DO_SET_MODE: _do_set_mode,
    dialect.MAV_CMD_NAV_TAKEOFF: _takeoff,
    dialect.MAV_CMD_NAV_LAND: _mode("AUTO.LAND"),
    dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH: _mode("AUTO.RTL"),
    dialect.MAV_CMD_DO_REPOSITION: _reposition,
    dialect.MAV_CMD_MISSION_START: _mission_start,
    dialect.MAV_CMD_DO_CHANGE_SPEED: _change_speed,
    dialect.MAV_CMD_DO_SET_HOME: _set_home,
    dialect.MAV_CMD_DO_FLIGHTTERMINATION: _terminate,
    dialect.MAV_CMD_RUN_PREARM_CHECKS: _run_prearm_checks,
    dialect.MAV_CMD_GET_HOME_POSITION: _answer_with(dialect.MAVLINK_MSG_ID_HOME_POSITION),
    dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: _answer_with(
        dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION
    ),
    dialect.MAV_CMD_REQUEST_PROTOCOL_VERSION: _accepted,  # the dialect lacks PROTOCOL_VERSION
    dialect.MAV_CMD_SET_MESSAGE_INTERVAL: _set_message_interval,
    dialect.MAV_CMD_GET_MESSAGE_INTERVAL: _get_message_interval,
    dialect.MAV_CMD_REQUEST_MESSAGE: _request_message,
}
"""MAV_CMD -> the function that executes it."""

ACCEPTED_FIRST = frozenset({dialect.MAV_CMD_DO_SET_MODE})
"""Commands that PX4 answers twice: ACCEPTED at once, the real result within 10 ms."""
