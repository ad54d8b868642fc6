"""An autopilot without physics at the other end of the wire: it does what its script says.

It sends the telemetry that PX4 sends, is where its last setpoint told it to be, and answers
commands and questions for parameters. What it hears is kept for tests to look at.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.parameters import REAL32
from companion.mavlink.px4_modes import custom_mode, mode_from
from companion.mission.signals import Signal
from companion.outcomes import Outcome, Progress
from companion.vehicle.gate import Envelope
from companion.vehicle.offboard import MavlinkVehicle
from companion.vehicle.ports.goals import Goal
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire

TICK_S = 0.05
ACCEPTED = dialect.MAV_RESULT_ACCEPTED
ARM = dialect.MAV_CMD_COMPONENT_ARM_DISARM
TAKE_OFF = dialect.MAV_CMD_NAV_TAKEOFF
LAND = dialect.MAV_CMD_NAV_LAND
SET_MODE = dialect.MAV_CMD_DO_SET_MODE

FENCE = ((-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0))
ENVELOPE = Envelope(FENCE, (0.5, 4.0), 2.0, climb_mps=2.0, descent_mps=1.5, carrot_m=1.5)
TARGET = Signal("NAMED_VALUE_INT", "target", "value")
CHARGE = Signal("BATTERY_STATUS", "", "battery_remaining")
CALL = Signal("COMMAND", "", "MAV_CMD_NAV_RETURN_TO_LAUNCH")


class Autopilot:
    """Stands on the ground at its local origin, disarmed, in AUTO.LOITER.

    Attributes:
        results: MAV_RESULTs with which a command is answered, in order; None is no answer. The
            last one stays; without an entry it is ACCEPTED.
        is_idle: accepted commands have no effect.
        unsent: names of messages that are lost on the way.
        heard: every message that was addressed to it or to all.
    """

    def __init__(self, system: int = 1, component: int = 1) -> None:
        self.codec = MavlinkCodec(system, component)
        self.mode = "AUTO.LOITER"
        self.is_armed = False
        self.is_landed = True
        self.system_status = dialect.MAV_STATE_STANDBY
        self.position = [0.0, 0.0, 0.0]
        self.velocity = [0.0, 0.0, 0.0]
        self.yaw_rad = 0.0
        self.home = [0.0, 0.0, 0.0]
        self.home_altitude_m = 488.0
        self.battery_percent = 80
        self.parameters = {"COM_OF_LOSS_T": 1.0, "COM_OBL_RC_ACT": 5.0, "COM_LOW_BAT_ACT": 3.0}
        self.parameters |= {"GF_ACTION": 2.0, "COM_RCL_EXCEPT": 0.0, "RTL_RETURN_ALT": 30.0}
        self.parameters |= {"GF_MAX_HOR_DIST": 0.0, "GF_MAX_VER_DIST": 0.0, "MIS_TAKEOFF_ALT": 2.5}
        self.results: dict[int, list[int | None]] = {}
        self.is_idle = False
        self.unsent: set[str] = set()
        self.heard: list[Any] = []

    def telemetry(self) -> list[bytes]:
        """The state, a datagram for each message."""
        base_mode = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        if self.is_armed:
            base_mode |= dialect.MAV_MODE_FLAG_SAFETY_ARMED
        landed = dialect.MAV_LANDED_STATE_ON_GROUND if self.is_landed else 2  # in the air
        return [
            self.codec.pack(message)
            for message in (
                dialect.MAVLink_heartbeat_message(
                    2, 12, base_mode, custom_mode(self.mode), self.system_status, 3
                ),
                dialect.MAVLink_home_position_message(
                    0, 0, round(1000 * self.home_altitude_m), *self.home, [1, 0, 0, 0], 0, 0, 0
                ),
                dialect.MAVLink_extended_sys_state_message(0, landed),
                dialect.MAVLink_attitude_message(0, 0, 0, self.yaw_rad, 0, 0, 0),
                dialect.MAVLink_local_position_ned_message(0, *self.position, *self.velocity),
                battery(self.battery_percent),
            )
            if message.get_type() not in self.unsent
        ]

    def answer(self, datagrams: list[bytes]) -> list[bytes]:
        """Hears datagrams and does what they ask for; returns the answers."""
        answers: list[bytes] = []
        for datagram in datagrams:
            for message in self.codec.parse(datagram):
                self.heard.append(message)
                reply = _REPLIES.get(message.get_type())
                answers += [self.codec.pack(m) for m in reply(self, message)] if reply else []
        return answers

    def _on_command(self, message: Any) -> list[Any]:
        if message.target_component != self.codec.component:
            return []
        results = self.results.get(message.command, [ACCEPTED])
        result = results.pop(0) if len(results) > 1 else results[0]
        if result == ACCEPTED and not self.is_idle:
            self._obey(message)
        return [] if result is None else [ack(message, result)]

    def _obey(self, message: Any) -> None:
        if message.command == ARM:
            self.is_armed = True
        elif message.command == TAKE_OFF:
            self.is_landed, self.mode = False, "AUTO.LOITER"
            self.position[2] = self.home_altitude_m - message.param7 + self.home[2]
        elif message.command == LAND:
            self.is_landed, self.is_armed, self.mode = True, False, "AUTO.LAND"
        elif message.command == SET_MODE:
            self.mode = mode_from(int(message.param2), int(message.param3)) or self.mode

    def _on_setpoint(self, message: Any) -> list[Any]:
        if self.mode == "OFFBOARD":
            self.position = [message.x, message.y, message.z]
        return []

    def _on_question(self, message: Any) -> list[Any]:
        value = self.parameters.get(message.param_id)
        if value is None:
            return []
        name = message.param_id.encode()
        return [dialect.MAVLink_param_value_message(name, value, REAL32, 1, 0)]


_REPLIES: dict[str, Callable[[Autopilot, Any], list[Any]]] = {
    "COMMAND_LONG": Autopilot._on_command,
    "SET_POSITION_TARGET_LOCAL_NED": Autopilot._on_setpoint,
    "PARAM_REQUEST_READ": Autopilot._on_question,
}


class Meeting:
    """A MavlinkVehicle and an autopilot that exchange datagrams once per tick."""

    def __init__(
        self, envelope: Envelope, signals: frozenset[Signal] = frozenset(), up_m: float = 2.0
    ) -> None:
        self.wire = Wire()
        self.vehicle = MavlinkVehicle(self.wire, Telemetry(), envelope, signals, up_m)
        self.wire.listen(self.vehicle.wanted, self.vehicle.continual)
        self.autopilot = Autopilot()
        self.now_s = 0.0
        self.readings: list[tuple[Signal, float]] = []
        self.is_quiet = False  # the autopilot sends no telemetry
        self._ticks = 0
        self._answers: list[bytes] = []

    def tick(self, *datagrams: bytes, act: Callable[[], object] = lambda: None) -> list[Any]:
        """One tick: telemetry and datagrams arrive, something acts, and what left is returned."""
        self._ticks += 1
        self.now_s = self._ticks * TICK_S
        telemetry = [] if self.is_quiet else self.autopilot.telemetry()
        arriving = [*self._answers, *telemetry, *datagrams]
        self.readings = self.vehicle.receive(self.now_s, self.wire.parse(arriving))
        act()
        before = len(self.autopilot.heard)
        leaving = self.wire.pack(self.vehicle.transmit(self.now_s))
        self._answers = self.autopilot.answer(leaving)
        return self.autopilot.heard[before:]

    def run(self, duration_s: float, act: Callable[[], object] = lambda: None) -> list[Any]:
        """Ticks for a time; returns all that left, each with the time when it did."""
        sent = []
        for _ in range(round(duration_s / TICK_S)):
            for message in self.tick(act=act):
                message.left_s = self.now_s
                sent.append(message)
        return sent

    def pursue(self, goal: Goal, limit_s: float = 200.0) -> Outcome:
        """Pursues a goal until it is reached or has failed."""
        outcome: Outcome = Progress.RUNNING

        def act() -> None:
            nonlocal outcome
            outcome = self.vehicle.goals.pursue(goal)

        for _ in range(round(limit_s / TICK_S)):
            self.tick(act=act)
            if outcome is not Progress.RUNNING:
                return outcome
        raise AssertionError(f"{goal} is still pursued after {limit_s:.0f} s")


def battery(percent: int) -> Any:
    """BATTERY_STATUS with a remaining charge; -1 is unknown."""
    return dialect.MAVLink_battery_status_message(0, 0, 0, 32767, [65535] * 10, -1, -1, -1, percent)


def ack(command: Any, result: int) -> Any:
    """The COMMAND_ACK of a command, to who sent it."""
    return dialect.MAVLink_command_ack_message(
        command.command, result, 0, 0, command.get_srcSystem(), command.get_srcComponent()
    )


def named(name: str, value: int) -> Any:
    """NAMED_VALUE_INT."""
    return dialect.MAVLink_named_value_int_message(0, name.encode(), value)


def of_type(messages: list[Any], kind: str) -> list[Any]:
    """The messages of one type."""
    return [m for m in messages if m.get_type() == kind]


def is_close(a: Any, b: tuple[float, ...]) -> bool:
    """Equal within the rounding of the wire's 32 bit floats."""
    return all(math.isclose(x, y, rel_tol=1e-6, abs_tol=1e-6) for x, y in zip(a, b, strict=True))


def in_offboard(meeting: Meeting) -> Meeting:
    """In the air in OFFBOARD, at the altitude of take-off, with the goal reached."""
    for goal in (Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD):
        assert meeting.pursue(goal) is Progress.DONE
    return meeting
