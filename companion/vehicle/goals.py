"""The table of goals: the command that brings each about, its modes, and its time limits.

A goal is a state of the vehicle (`ports/goals.py`). Its command is sent, and sent again if the
vehicle accepts it without getting there, until the state is observed or time is up: EFFECT_S while
nothing happens, and the goal's whole time while the vehicle is on its way. The listed modes are
those that the vehicle may pass through without anybody having taken control. Control is watched
from the first goal on, also while the vehicle is disarmed.

Modes after a landing:
1. When PX4 disarms, it falls back to the last chosen mode in which it may be armed: OFFBOARD after
   a flight, otherwise the mode before the first goal.
2. In OFFBOARD PX4 arms only with setpoints, so a vehicle in OFFBOARD is first commanded to hold.
   This takes nothing from a pilot: only a companion uses OFFBOARD. Other modes are left as they
   are.
3. PX4 falls back only once. If the mode changes after the vehicle stood disarmed for FALLEN_BACK
   heartbeats, somebody chose it. The same holds after a silence, except that a vehicle which landed
   out of OFFBOARD may be in OFFBOARD again.

Source: PX4 v1.16 as observed, and its UserModeIntention.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from companion.mavlink.commands import Parameters
from companion.mavlink.framing import dialect
from companion.mavlink.px4_modes import MODES
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Mode, VehicleState

NAN = math.nan
CUSTOM_MODE_ENABLED = 1.0  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
EFFECT_S = 12.0
"""Time within which a command must take effect: longer than ten tries at one a second, or the 10 s
after an IN_PROGRESS. A PX4 is armed, or shows another mode, within a second."""

FALLEN_BACK = 3
"""Heartbeats after a landing within which an autopilot falls back: a PX4 reports the disarming and
the new mode in the same heartbeat, or the new mode in the next."""


@dataclass(frozen=True, slots=True)
class Approach:
    """How to reach a goal.

    Attributes:
        command: MAV_CMD number.
        parameters: of the command, computed from the take-off altitude above mean sea level.
        is_reached: whether the goal is reached in a state.
        passes: modes on the way; the initial mode also counts until the vehicle has left it.
        keeps: modes in which a reached goal remains reached; None for those on the way.
        leaves: modes in which the goal cannot be reached; the vehicle is first commanded to hold.
        needs_arming: the vehicle has to be armed.
        underway: modes that show that the vehicle is on its way, so the command is not repeated.
        lead_s: time to stream setpoints before the command; PX4 wants to see them first.
        timeout_s: time after which the goal has failed even if the vehicle is on its way.
    """

    command: int
    parameters: Callable[[float], Parameters]
    is_reached: Callable[[VehicleState], bool]
    passes: frozenset[Mode]
    keeps: frozenset[Mode] | None
    timeout_s: float = math.inf
    leaves: frozenset[Mode] = frozenset()
    needs_arming: bool = False
    underway: frozenset[Mode] = frozenset()
    lead_s: float = 0.0


@dataclass
class Pursuit:
    """A goal that is pursued.

    Attributes:
        allowed: modes that do not mean that somebody has taken control.
        takeoff_up_m: altitude above home of a take-off.
        ticket: the command under way.
        asked: the approach that the command belongs to.
        is_in_failsafe: the autopilot's failsafe is tolerated: it was active at the start, or is the
            loss of our stream.
        has_failed: it has failed; the goal may be pursued anew.
        underway_s: when the vehicle was last on its way; before that, the start.
        standing: heartbeats since the vehicle landed for this goal and is disarmed.
        stands_in: mode of the last of these heartbeats.
    """

    goal: Goal
    allowed: frozenset[Mode]
    start_mode: Mode
    start_s: float
    takeoff_up_m: float
    is_in_failsafe: bool
    ticket: int | None = None
    asked: Approach | None = None
    has_failed: bool = False
    underway_s: float = field(init=False)
    standing: int = 0
    stands_in: Mode | None = None

    def __post_init__(self) -> None:
        self.underway_s = self.start_s

    def admits(
        self, mode: Mode, is_armed: bool, first_mode: Mode | None, was_silent: bool = False
    ) -> bool:
        """Takes a mode; returns whether the goal passes through it, so that control is still ours.

        The initial mode is ours until the vehicle has left it. A vehicle that has landed for us may
        fall back to the mode before the first goal, and then has to stay in it.

        Args:
            mode: the present one.
            is_armed: whether the vehicle is armed.
            first_mode: the mode before the first goal.
            was_silent: the autopilot was not heard for a while before.
        """
        passes = APPROACHES[self.goal].passes
        has_landed = self.goal is Goal.LANDED and not is_armed
        if has_landed and self.standing >= FALLEN_BACK and self.stands_in not in passes:
            return mode is self.stands_in
        falls_back = has_landed and mode in (Mode.LOITER, Mode.OFFBOARD, first_mode)
        is_ours = mode in passes or mode in self.allowed or falls_back
        if has_landed and was_silent and self.start_mode is Mode.OFFBOARD:
            is_ours = mode in (*passes, Mode.OFFBOARD, self.stands_in)
        if mode in passes:
            self.allowed -= {self.start_mode} - passes
        if has_landed and is_ours:
            self.standing, self.stands_in = self.standing + 1, mode
        return is_ours

    def overdue_s(self, now_s: float, mode: Mode) -> float | None:
        """Takes the mode; returns the time after which the goal has failed, None while it has
        not."""
        approach = APPROACHES[self.goal]
        if mode in approach.underway:
            self.underway_s = now_s
        waited_s = now_s - self.start_s
        is_idle = now_s - self.underway_s >= EFFECT_S + approach.lead_s
        return waited_s if is_idle or waited_s >= approach.timeout_s else None


def _set_mode(mode: Mode) -> Parameters:
    main, sub = MODES[mode.value]
    return (CUSTOM_MODE_ENABLED, main, sub, 0.0, 0.0, 0.0, 0.0)


def _has_climbed(state: VehicleState) -> bool:
    """Whether AUTO.TAKEOFF has ended: hold was heard after the vehicle had left the ground.

    The previous mode is not used, as heartbeats may be lost.
    """
    heartbeat = state.heartbeat
    is_held = heartbeat.mode is Mode.LOITER and heartbeat.received_s > state.landed_since_s
    return is_held and not state.is_landed


APPROACHES: dict[Goal, Approach] = {
    Goal.ARMED: Approach(
        command=dialect.MAV_CMD_COMPONENT_ARM_DISARM,
        parameters=lambda _: (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        is_reached=lambda s: s.heartbeat.is_armed,
        passes=frozenset({Mode.LOITER, Mode.OFFBOARD}),
        keeps=None,
        leaves=frozenset({Mode.OFFBOARD}),
    ),
    Goal.AIRBORNE: Approach(
        command=dialect.MAV_CMD_NAV_TAKEOFF,
        parameters=lambda altitude_m: (NAN, NAN, NAN, NAN, NAN, NAN, altitude_m),
        is_reached=_has_climbed,
        passes=frozenset({Mode.TAKEOFF, Mode.LOITER}),
        keeps=frozenset({Mode.LOITER}),
        timeout_s=60.0,
        needs_arming=True,
        underway=frozenset({Mode.TAKEOFF}),
    ),
    Goal.OFFBOARD: Approach(
        command=dialect.MAV_CMD_DO_SET_MODE,
        parameters=lambda _: _set_mode(Mode.OFFBOARD),
        is_reached=lambda s: s.heartbeat.mode is Mode.OFFBOARD,
        passes=frozenset({Mode.OFFBOARD}),
        keeps=frozenset({Mode.OFFBOARD}),
        needs_arming=True,
        lead_s=1.0,
    ),
    Goal.HOLDING: Approach(
        command=dialect.MAV_CMD_DO_SET_MODE,
        parameters=lambda _: _set_mode(Mode.LOITER),
        is_reached=lambda s: s.heartbeat.mode is Mode.LOITER,
        passes=frozenset({Mode.LOITER}),
        keeps=frozenset({Mode.LOITER}),
    ),
    Goal.LANDED: Approach(
        command=dialect.MAV_CMD_NAV_LAND,
        parameters=lambda _: (0.0, 0.0, 0.0, NAN, NAN, NAN, NAN),
        is_reached=lambda s: s.is_standing,
        passes=frozenset({Mode.LAND}),
        keeps=frozenset({Mode.LAND, Mode.LOITER, Mode.OFFBOARD}),
        timeout_s=120.0,
        underway=frozenset({Mode.LAND}),
    ),
}
