"""Points gimbals over MAVLink, by the gimbal protocol, version 2.

Rules:
1. Control is requested first, with our system and component ids as numbers. PX4 does not understand
   -2, which stands for the sender, in this command.
2. The manager accepts a direction at once. The direction is reached when a
   GIMBAL_DEVICE_ATTITUDE_STATUS, heard after that, is within REACHED_RAD of it.
3. A direction from north is locked there (flags: yaw lock, earth frame). A direction from the
   heading turns with the vehicle.
4. Control is given back before the vehicle lands.

    phase        leads to
    CONFIGURING  AIMING, once control was accepted
    AIMING       TURNING, once the direction was accepted
    TURNING      the end, by rule 2
    any          the end, by a refusal or when its time is over

The gimbal's device is the manager itself, or the one that GIMBAL_MANAGER_STATUS names, or else the
one with the default id. Only time in which the autopilot is heard counts (`heard_time.py`). Source:
https://mavlink.io/en/services/gimbal_v2.html; PX4 v1.16, gimbal module.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum, auto

from companion.geometry import euler_from_quaternion
from companion.mavlink.commands import CommandSender, Parameters
from companion.mavlink.framing import Message, dialect, source
from companion.outcomes import Failed, Outcome, Progress
from companion.vehicle.ports.gimbals import Aim
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import COMPONENT, Wire

REACHED_RAD = math.radians(2.0)
TURN_S = 15.0
"""Time to point, if the skill does not specify one."""
USUAL_DEVICE = dialect.MAV_COMP_ID_GIMBAL
MOST_BUILT_IN = 6
"""Gimbal device ids up to this are not MAVLink components, but the manager's own gimbals."""
CONFIGURE, PITCHYAW = (
    dialect.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
    dialect.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
)
_LEVEL = dialect.GIMBAL_MANAGER_FLAGS_ROLL_LOCK | dialect.GIMBAL_MANAGER_FLAGS_PITCH_LOCK
_LOCK = dialect.GIMBAL_MANAGER_FLAGS_YAW_LOCK
_VEHICLE, _EARTH = (
    dialect.GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME,
    dialect.GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME,
)
_NO_LONGER, _UNCHANGED = -3.0, -1.0
_STATUS, _ATTITUDE = "GIMBAL_MANAGER_STATUS", "GIMBAL_DEVICE_ATTITUDE_STATUS"
Direction = tuple[float, float, float]
"""A unit vector, north, east, down."""


class AimPhase(Enum):
    """The phases of pointing a gimbal."""

    CONFIGURING = auto()
    AIMING = auto()
    TURNING = auto()


@dataclass
class _Pointing:
    """A request to point a gimbal.

    Attributes:
        ticket: of the command under way.
        accepted_s: when the direction was accepted.
    """

    component: int
    aim: Aim
    limit_s: float
    begun_s: float
    phase: AimPhase = AimPhase.CONFIGURING
    ticket: int | None = None
    accepted_s: float = math.inf
    outcome: Outcome = Progress.RUNNING


@dataclass
class _Manager:
    """What a gimbal manager has said: which device it controls, and who controls the manager."""

    device: int | None = None
    control: tuple[int, int] | None = None


@dataclass
class _Attitude:
    """The direction of a device, from north, and when it was heard."""

    direction: Direction
    heard_s: float


@dataclass
class MavlinkGimbals:
    """Implements `ports.gimbals.Gimbals`; a service of the vehicle.

    Args:
        wire: of the system that the gimbals belong to.
        telemetry: has the vehicle's heading.
    """

    wire: Wire
    telemetry: Telemetry
    wanted: frozenset[str] = frozenset({"COMMAND_ACK", _STATUS, _ATTITUDE})
    needs_control: bool = True
    _commands: CommandSender = field(default_factory=CommandSender)
    _pointings: dict[int, _Pointing] = field(default_factory=dict)
    _managers: dict[int, _Manager] = field(default_factory=dict)
    _attitudes: dict[int, _Attitude] = field(default_factory=dict)
    _controlled: set[int] = field(default_factory=set)
    _tickets: int = 0
    _heard_s: float = 0.0

    # -- ports.gimbals -------------------------------------------------------------------------

    def point(self, component: int, aim: Aim, timeout_s: float | None) -> int:
        """Begins to point a gimbal; returns a ticket."""
        self._tickets += 1
        limit_s = TURN_S if timeout_s is None else timeout_s
        pointing = _Pointing(component, aim, limit_s, self._heard_s)
        own = (float(self.wire.system), float(COMPONENT), _UNCHANGED, _UNCHANGED, 0.0, 0.0, 0.0)
        pointing.ticket = self._send(component, CONFIGURE, own, limit_s)
        self._controlled.add(component)
        self._pointings[self._tickets] = pointing
        return self._tickets

    def outcome(self, ticket: int) -> Outcome:
        """What became of the request."""
        return self._pointings[ticket].outcome

    def forget(self, ticket: int) -> None:
        """Stops pursuing the request."""
        pointing = self._pointings.pop(ticket, None)
        if pointing is not None and pointing.ticket is not None:
            self._commands.forget(pointing.ticket)

    def give_back(self) -> None:
        """Gives back the control of all gimbals."""
        nobody = (_NO_LONGER, _NO_LONGER, _UNCHANGED, _UNCHANGED, 0.0, 0.0, 0.0)
        for component in sorted(self._controlled):
            self._send(component, CONFIGURE, nobody, None)
        self._controlled.clear()

    # -- services.Service ----------------------------------------------------------------------

    def step(self, moment: Moment) -> None:
        """Advances all requests."""
        self._heard_s = moment.heard_s
        for pointing in self._pointings.values():
            if pointing.outcome is Progress.RUNNING:
                self._follow(pointing)

    def take(self, moment: Moment, message: Message) -> None:
        """Takes messages of managers and devices, and answers to our commands."""
        _, component = source(message)
        kind = message.get_type()
        if kind == "COMMAND_ACK":
            if message.target_component in (0, COMPONENT):
                self._commands.receive(moment.heard_s, message)
        elif kind == _STATUS:
            control = (message.primary_control_sysid, message.primary_control_compid)
            built_in = message.gimbal_device_id <= MOST_BUILT_IN
            device = component if built_in else message.gimbal_device_id
            self._managers[component] = _Manager(device, control)
        elif (direction := self._direction(message)) is not None:
            self._attitudes[component] = _Attitude(direction, moment.heard_s)

    def due(self, moment: Moment) -> list[Message]:
        """The commands to send now."""
        return [] if moment.is_quiet else self._commands.due(moment.heard_s)

    def release(self) -> None:
        """Drops all requests."""
        self._commands = CommandSender()
        self._pointings.clear()
        self._controlled.clear()

    # -- phases --------------------------------------------------------------------------------

    def _send(
        self, component: int, command: int, parameters: Parameters, limit_s: float | None
    ) -> int:
        target = (self.wire.system, component)
        return self._commands.start(self._heard_s, target, command, parameters, limit_s)

    def _follow(self, pointing: _Pointing) -> None:
        """Advances one request."""
        who = f"the gimbal (component {pointing.component})"
        left_s = pointing.begun_s + pointing.limit_s - self._heard_s
        if pointing.ticket is not None:
            exchange = self._commands[pointing.ticket]
            if exchange.has_failed:
                pointing.outcome = Failed(f"{who}: {exchange.in_words}{self._control(pointing)}")
            elif exchange.result and pointing.phase is AimPhase.CONFIGURING:
                pointing.phase = AimPhase.AIMING
                self._commands.forget(pointing.ticket)
                parameters = _parameters(pointing.aim)
                pointing.ticket = self._send(pointing.component, PITCHYAW, parameters, left_s)
            elif exchange.result and pointing.phase is AimPhase.AIMING:
                pointing.phase, pointing.accepted_s = AimPhase.TURNING, self._heard_s
        off_rad = self._off_rad(pointing)
        if pointing.phase is AimPhase.TURNING and off_rad is not None and off_rad <= REACHED_RAD:
            pointing.outcome = Progress.DONE
        elif pointing.outcome is Progress.RUNNING and left_s <= 0.0:
            about = "does not say where it points"
            if off_rad is not None:
                about = f"is {math.degrees(off_rad):.0f} degrees off"
            elif pointing.phase is not AimPhase.TURNING:
                about = "has not answered"
            pointing.outcome = Failed(f"{who} {about} after {pointing.limit_s:g} s")

    def _control(self, pointing: _Pointing) -> str:
        """Who else controls the gimbal, in words; "" if nobody."""
        manager = self._managers.get(pointing.component)
        control = manager.control if manager is not None else None
        if control in (None, (0, 0), (self.wire.system, COMPONENT)):
            return ""
        assert control is not None
        return f"; component {control[1]} of system {control[0]} controls it"

    def _off_rad(self, pointing: _Pointing) -> float | None:
        """The remaining angle; None if no attitude was heard since the direction was accepted."""
        attitude = self._attitude_of(pointing.component)
        heading_rad = self._heading_rad
        if attitude is None or heading_rad is None or attitude.heard_s <= pointing.accepted_s:
            return None
        aim = pointing.aim
        yaw_rad = aim.yaw_rad if aim.is_from_north else aim.yaw_rad + heading_rad
        wanted = _unit(aim.pitch_rad, yaw_rad)
        cosine = sum(a * b for a, b in zip(wanted, attitude.direction, strict=True))
        return math.acos(max(-1.0, min(1.0, cosine)))

    def _attitude_of(self, manager: int) -> _Attitude | None:
        known = self._managers.get(manager)
        if known is not None and known.device is not None:
            return self._attitudes.get(known.device)
        return self._attitudes.get(manager) or self._attitudes.get(USUAL_DEVICE)

    @property
    def _heading_rad(self) -> float | None:
        state = self.telemetry.state
        return state.attitude.yaw_rad if state is not None else None

    def _direction(self, message: Message) -> Direction | None:
        """The direction in a GIMBAL_DEVICE_ATTITUDE_STATUS, from north."""
        heading_rad = self._heading_rad
        if heading_rad is None or not all(map(math.isfinite, message.q)):
            return None
        w, x, y, z = message.q
        _, pitch_rad, yaw_rad = euler_from_quaternion((w, x, y, z))
        is_told = message.flags & (_VEHICLE | _EARTH)
        is_from_north = message.flags & (_EARTH if is_told else _LOCK)
        return _unit(pitch_rad, yaw_rad if is_from_north else yaw_rad + heading_rad)


def _parameters(aim: Aim) -> Parameters:
    flags = _LEVEL | (_LOCK | _EARTH if aim.is_from_north else _VEHICLE)
    angles = (math.degrees(aim.pitch_rad), math.degrees(aim.yaw_rad))
    return (*angles, math.nan, math.nan, float(flags), 0.0, 0.0)


def _unit(pitch_rad: float, yaw_rad: float) -> Direction:
    """The unit vector of a pitch and a yaw."""
    flat = math.cos(pitch_rad)
    return (flat * math.cos(yaw_rad), flat * math.sin(yaw_rad), -math.sin(pitch_rad))
