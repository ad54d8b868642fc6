"""A vehicle over MAVLink: bytes in, state and signals out; goals and setpoints in, bytes out.

No I/O: `link.py` moves the bytes, in one loop with everything else. So the setpoints stop when
the program hangs, and the autopilot's own offboard-loss failsafe takes over.

Rules:
1. The system id is learned from the first autopilot heard; other systems are ignored.
2. Every setpoint passes the gate (`gate.py`); nothing repeats a setpoint by itself.
3. A goal is pursued until it is observed (`goals.py`).
4. A mode that our goal does not pass through was chosen by somebody else: our authority ends,
   at once and for good. Nothing is streamed or commanded after that.
5. The mission's frame has its origin at the home position. The autopilot's local frame may
   begin elsewhere, so positions are shifted by HOME_POSITION until the vehicle is in the air.

Sources: https://mavlink.io/en/services/ (heartbeat, command), PX4 offboard mode.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from companion.geometry import Ned
from companion.mavlink.commands import CommandSender, Parameters
from companion.mavlink.framing import Endpoint, Message, dialect, source
from companion.mavlink.px4_modes import mode_name
from companion.mission.model import Signal
from companion.vehicle.gate import Envelope, admit
from companion.vehicle.goals import APPROACHES
from companion.vehicle.port import Goal, Mode, Outcome, Progress, Setpoint, VehicleState

COMPONENT = dialect.MAV_COMP_ID_ONBOARD_COMPUTER
AUTOPILOT = dialect.MAV_COMP_ID_AUTOPILOT1
HEARTBEAT_S = 1.0
ASK_AGAIN_S = 2.0
"""Pause before a command that was accepted without effect is sent again."""

POSITION_VELOCITY_YAW = (
    dialect.POSITION_TARGET_TYPEMASK_AX_IGNORE
    | dialect.POSITION_TARGET_TYPEMASK_AY_IGNORE
    | dialect.POSITION_TARGET_TYPEMASK_AZ_IGNORE
    | dialect.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
)
UNKNOWN_VALUES = {("BATTERY_STATUS", "battery_remaining"): -1, ("SYS_STATUS", "battery_remaining"): -1}
"""Values that mean "not known"; they are never handed on as numbers."""

STILL = (0.0, 0.0, 0.0)


class MavlinkVehicle:
    """Fulfils `port.Vehicle` over MAVLink 2, as component 191 of the vehicle's system.

    Args:
        envelope: limits of the gate.
        signals: what to hand on from the wire besides the state.
        takeoff_up_m: altitude above home to take off to.
    """

    def __init__(
        self, envelope: Envelope, signals: frozenset[Signal], takeoff_up_m: float
    ) -> None:
        self.refusals = 0
        self.status_texts: deque[str] = deque(maxlen=5)
        self.lost_authority = ""
        self._envelope = envelope
        self._takeoff_up_m = takeoff_up_m
        self._listeners: dict[str, list[Signal]] = {}
        for signal in signals:
            self._listeners.setdefault(signal.message, []).append(signal)
        self._endpoint = Endpoint(0, COMPONENT)
        self._now_s = 0.0
        self._next_heartbeat_s = 0.0
        self._commands = CommandSender()
        self._out: list[Message] = []
        self._readings: list[tuple[Signal, float]] = []
        self._setpoint: Setpoint | None = None
        self._pursuit: _Pursuit | None = None
        # last heard
        self._mode: Mode | None = None
        self._is_armed = False
        self._is_failsafe = False
        self._is_landed: bool | None = None
        self._local: tuple[float, Ned, Ned] | None = None  # stamp, position, velocity
        self._yaw_rad: float | None = None
        self._home: tuple[Ned, float] | None = None  # in the local frame, altitude AMSL
        self._battery_percent: int | None = None

    # -- bytes ---------------------------------------------------------------------------------

    def receive(self, now_s: float, datagrams: list[bytes]) -> list[tuple[Signal, float]]:
        """Takes what arrived; returns the signals in it, in order."""
        self._now_s = now_s
        self._readings = []
        for datagram in datagrams:
            for message in self._endpoint.parse(datagram):
                self._take(message)
        return self._readings

    def transmit(self, now_s: float) -> list[bytes]:
        """What has to leave now: heartbeat, answers, commands, and one setpoint."""
        self._now_s = now_s
        if not self._endpoint.system:
            return []
        messages, self._out = self._out, []
        if now_s >= self._next_heartbeat_s:
            self._next_heartbeat_s = now_s + HEARTBEAT_S
            messages.append(self._heartbeat())
        if not self.lost_authority:
            messages += self._commands.due(now_s)
            messages += self._admitted_setpoint()
        return [self._endpoint.pack(m) for m in messages]

    # -- port.Vehicle --------------------------------------------------------------------------

    @property
    def state(self) -> VehicleState | None:
        """See `port.Vehicle`."""
        if (
            self._local is None
            or self._mode is None
            or self._home is None
            or self._yaw_rad is None
            or self._is_landed is None
        ):
            return None
        stamp_s, (x, y, z), velocity = self._local
        home_x, home_y, home_z = self._home[0]
        return VehicleState(
            stamp_s=stamp_s,
            position=(x - home_x, y - home_y, z - home_z),
            velocity=velocity,
            yaw_rad=self._yaw_rad,
            mode=self._mode,
            is_armed=self._is_armed,
            is_landed=self._is_landed,
            is_failsafe=self._is_failsafe,
            battery_percent=self._battery_percent,
        )

    def fly(self, setpoint: Setpoint | None) -> None:
        """See `port.Vehicle`."""
        self._setpoint = setpoint

    def pursue(self, goal: Goal) -> Outcome:
        """See `port.Vehicle`."""
        state = self.state
        if self.lost_authority:
            return Outcome(Progress.FAILED, self.lost_authority)
        if state is None:
            return Outcome(Progress.RUNNING)
        if self._pursuit is None or self._pursuit.goal is not goal:
            self._begin(goal, state)
        assert self._pursuit is not None
        pursuit, approach = self._pursuit, APPROACHES[goal]
        if approach.is_reached(state):
            self._give_up_ticket(pursuit)
            pursuit.allowed = approach.keeps
            return Outcome(Progress.DONE)
        failure = self._drive(pursuit)
        if failure:
            return Outcome(Progress.FAILED, failure)
        return Outcome(Progress.RUNNING)

    def send_command(self, component: int, command: int, parameters: tuple[float, ...]) -> int:
        """See `port.Vehicle`."""
        padded = (*parameters, *[0.0] * 7)[:7]
        return self._command(component, command, padded)  # type: ignore[arg-type]

    def command_outcome(self, ticket: int) -> Outcome:
        """See `port.Vehicle`."""
        exchange = self._commands[ticket]
        if exchange.has_failed:
            return Outcome(Progress.FAILED, exchange.result)
        return Outcome(Progress.DONE if exchange.result else Progress.RUNNING)

    def forget_command(self, ticket: int) -> None:
        """See `port.Vehicle`."""
        self._commands.forget(ticket)

    # -- goals ---------------------------------------------------------------------------------

    def _begin(self, goal: Goal, state: VehicleState) -> None:
        if self._pursuit is not None:
            self._give_up_ticket(self._pursuit)
        approach = APPROACHES[goal]
        self._pursuit = _Pursuit(
            goal=goal,
            allowed=approach.passes | {state.mode},
            deadline_s=self._now_s + approach.timeout_s,
        )

    def _drive(self, pursuit: _Pursuit) -> str:
        """Sends the goal's command when it is time to; returns why the goal has failed, or ""."""
        approach = APPROACHES[pursuit.goal]
        if self._now_s >= pursuit.deadline_s:
            return self._because(f"not {pursuit.goal.value} after {approach.timeout_s:.0f} s")
        if pursuit.ticket is not None:
            exchange = self._commands[pursuit.ticket]
            if exchange.has_failed:
                answer = exchange.result.replace("_", " ").lower()
                return self._because(f"not {pursuit.goal.value}: {answer}")
            if not exchange.result or self._now_s < exchange.next_send_s + ASK_AGAIN_S:
                return ""
            self._give_up_ticket(pursuit)
        altitude_m = (self._home[1] if self._home else 0.0) + self._takeoff_up_m
        pursuit.ticket = self._command(
            AUTOPILOT, approach.command, approach.parameters(altitude_m)
        )
        return ""

    def _because(self, what: str) -> str:
        """A failure with what the autopilot said lately."""
        texts = "; ".join(self.status_texts)
        return f"{what} (autopilot: {texts})" if texts else what

    def _give_up_ticket(self, pursuit: _Pursuit) -> None:
        if pursuit.ticket is not None:
            self._commands.forget(pursuit.ticket)
            pursuit.ticket = None

    def _command(self, component: int, command: int, parameters: Parameters) -> int:
        target = (self._endpoint.system, component)
        return self._commands.start(self._now_s, target, command, parameters)

    # -- out -----------------------------------------------------------------------------------

    def _heartbeat(self) -> Message:
        return dialect.MAVLink_heartbeat_message(
            type=dialect.MAV_TYPE_ONBOARD_CONTROLLER,
            autopilot=dialect.MAV_AUTOPILOT_INVALID,
            base_mode=0,
            custom_mode=0,
            system_status=dialect.MAV_STATE_ACTIVE,
            mavlink_version=3,
        )

    def _admitted_setpoint(self) -> list[Message]:
        """The setpoint that the gate lets out, as a message; at most one."""
        if self._setpoint is None:
            return []
        is_entering = self._pursuit is not None and self._pursuit.goal is Goal.OFFBOARD
        is_our_mode = is_entering or self._mode is Mode.OFFBOARD
        verdict = admit(self._setpoint, self.state, self._now_s, is_our_mode, self._envelope)
        if verdict.refusal:
            self.refusals += 1
        if verdict.setpoint is None or self._home is None:
            return []
        position = [p + h for p, h in zip(verdict.setpoint.position, self._home[0], strict=True)]
        return [
            dialect.MAVLink_set_position_target_local_ned_message(
                int(self._now_s * 1000) & 0xFFFFFFFF,
                self._endpoint.system,
                AUTOPILOT,
                dialect.MAV_FRAME_LOCAL_NED,
                POSITION_VELOCITY_YAW,
                *position,
                *verdict.setpoint.velocity,
                *STILL,
                verdict.setpoint.yaw_rad,
                0.0,
            )
        ]

    # -- in ------------------------------------------------------------------------------------

    def _take(self, message: Message) -> None:
        kind = message.get_type()
        system, component = source(message)
        if not self._endpoint.system and kind == "HEARTBEAT" and _is_autopilot(message):
            self._endpoint = Endpoint(system, COMPONENT)
        if kind in ("COMMAND_LONG", "COMMAND_INT"):
            self._on_command(message)
        if system != self._endpoint.system:
            return
        if kind == "COMMAND_ACK":
            if message.target_component in (0, COMPONENT):
                self._commands.receive(self._now_s, message)
        elif component == AUTOPILOT and kind in _HANDLERS:
            _HANDLERS[kind](self, message)
        for signal in self._listeners.get(kind, ()):
            self._listen(signal, message)

    def _listen(self, signal: Signal, message: Message) -> None:
        if signal.instance and message.name != signal.instance:
            return
        value = getattr(message, signal.field)
        if UNKNOWN_VALUES.get((signal.message, signal.field)) == value:
            return
        if math.isfinite(value):
            self._readings.append((signal, float(value)))

    def _on_command(self, message: Message) -> None:
        """Answers a command that is addressed to this component."""
        if (message.target_system, message.target_component) != (self._endpoint.system, COMPONENT):
            return
        entry = dialect.enums["MAV_CMD"].get(message.command)
        signal = Signal("COMMAND", "", entry.name if entry else "")
        is_known = signal in self._listeners.get("COMMAND", ())
        if is_known:
            self._readings.append((signal, 1.0))
        result = dialect.MAV_RESULT_ACCEPTED if is_known else dialect.MAV_RESULT_UNSUPPORTED
        self._out.append(
            dialect.MAVLink_command_ack_message(message.command, result, 0, 0, *source(message))
        )

    def _on_heartbeat(self, message: Message) -> None:
        self._is_armed = bool(message.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED)
        self._is_failsafe = message.system_status >= dialect.MAV_STATE_CRITICAL
        name = mode_name(message.custom_mode)
        known = {mode.value: mode for mode in Mode}
        self._mode = known.get(name or "", Mode.OTHER)
        pursuit = self._pursuit
        if pursuit and self._is_armed and self._mode not in pursuit.allowed:
            who = "a failsafe of the autopilot" if self._is_failsafe else "the pilot"
            self.lost_authority = f"{who} has control: mode {name or 'unknown'}"

    def _on_position(self, message: Message) -> None:
        numbers = (message.x, message.y, message.z, message.vx, message.vy, message.vz)
        if all(map(math.isfinite, numbers)):
            self._local = (self._now_s, numbers[:3], numbers[3:])

    def _on_attitude(self, message: Message) -> None:
        if math.isfinite(message.yaw):
            self._yaw_rad = message.yaw

    def _on_home(self, message: Message) -> None:
        is_on_ground = self._is_landed is not False
        if is_on_ground and all(map(math.isfinite, (message.x, message.y, message.z))):
            self._home = ((message.x, message.y, message.z), message.altitude / 1000)

    def _on_landed(self, message: Message) -> None:
        if message.landed_state != dialect.MAV_LANDED_STATE_UNDEFINED:
            self._is_landed = message.landed_state == dialect.MAV_LANDED_STATE_ON_GROUND

    def _on_battery(self, message: Message) -> None:
        if message.battery_remaining >= 0:
            self._battery_percent = message.battery_remaining

    def _on_status_text(self, message: Message) -> None:
        text = message.text.rstrip("\t\0 ")
        if text and text not in self.status_texts:
            self.status_texts.append(text)


class _Pursuit:
    """A goal under way.

    Attributes:
        allowed: modes that do not mean that somebody else took over.
        ticket: the command under way.
    """

    def __init__(self, goal: Goal, allowed: frozenset[Mode], deadline_s: float) -> None:
        self.goal = goal
        self.allowed = allowed
        self.deadline_s = deadline_s
        self.ticket: int | None = None


def _is_autopilot(heartbeat: Message) -> bool:
    return (
        heartbeat.get_srcComponent() == AUTOPILOT
        and heartbeat.autopilot != dialect.MAV_AUTOPILOT_INVALID
    )


_HANDLERS: dict[str, Callable[[MavlinkVehicle, Message], None]] = {
    "HEARTBEAT": MavlinkVehicle._on_heartbeat,
    "LOCAL_POSITION_NED": MavlinkVehicle._on_position,
    "ATTITUDE": MavlinkVehicle._on_attitude,
    "HOME_POSITION": MavlinkVehicle._on_home,
    "EXTENDED_SYS_STATE": MavlinkVehicle._on_landed,
    "BATTERY_STATUS": MavlinkVehicle._on_battery,
    "STATUSTEXT": MavlinkVehicle._on_status_text,
}
"""What is taken from the autopilot, and nothing else."""
