"""The table of goals: which command brings each about, in which modes, in what time.

A goal is a state of the vehicle (`port.Goal`). The command is sent and, if the vehicle accepts
it without getting there, sent again, until the state is observed or the time is up: EFFECT_S
while nothing happens, and all of the goal's time while it is under way. The modes
listed are those that the vehicle may pass through on the way without anybody having taken it
from us; authority is watched from the first goal on, also while the vehicle is disarmed.

When PX4 disarms it falls back to the mode that was chosen last and may be armed in: OFFBOARD after
a flight, else the mode in which the vehicle stood at first. In OFFBOARD it arms with setpoints
alone, so a vehicle that stands there is brought to hold first. That takes nothing from a pilot:
OFFBOARD is nobody's but a companion's. Any other mode stays as it is. It falls back once: where the
vehicle has stood disarmed for FALLEN_BACK heartbeats, another mode was chosen by somebody. So it
may have been in a silence: after one, a vehicle that landed out of OFFBOARD stands in that again.

Source: PX4 v1.16 as observed, and its UserModeIntention.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from companion.mavlink.commands import Parameters
from companion.mavlink.framing import dialect
from companion.mavlink.px4_modes import MODES
from companion.vehicle.port import Goal, Mode, VehicleState

NAN = math.nan
CUSTOM_MODE_ENABLED = 1.0  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
EFFECT_S = 12.0
"""Time within which a command has to have an effect: longer than ten tries with a second between
them, or the 10 s after an IN_PROGRESS. A PX4 is armed, or shows another mode, within a second."""

FALLEN_BACK = 3
"""Heartbeats after a landing in which an autopilot has fallen back: a PX4 tells of the disarming
and of the mode that follows in the same one, or in the next."""


@dataclass(frozen=True, slots=True)
class Approach:
    """One way to a goal.

    Attributes:
        command: MAV_CMD number.
        parameters: its parameters, from the altitude above mean sea level to take off to.
        is_reached: whether a state is the goal.
        passes: modes on the way; the mode at the start is one of them until it was left.
        keeps: modes in which the goal, once reached, still stands; None for those on the way.
        leaves: modes in which it cannot be reached; the vehicle is asked to hold first.
        needs_arming: a vehicle that is not armed cannot get there.
        underway: modes that show that the vehicle is on its way and need not be asked again.
        lead_s: time to stream setpoints before asking; PX4 wants to see them first.
        timeout_s: time after which the goal has failed, though the vehicle is on its way.
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
    """A goal under way.

    Attributes:
        allowed: modes that do not mean that somebody else took over.
        takeoff_up_m: altitude above home that a take-off leads to.
        ticket: the command under way.
        asked: the approach to which that command belongs.
        is_in_failsafe: one of the autopilot's is gone on from, which was active at its start, or
            is that our stream was lost.
        has_failed: it was given up; the goal may be pursued anew.
        underway_s: when the vehicle was last on its way; the start before that.
        standing: heartbeats since the vehicle has landed for this goal, and is disarmed.
        stands_in: the mode of the last of them.
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
        """Takes a mode; whether the goal passes through it, so that nobody has taken control.

        The mode of the goal's start is ours until it was left. A vehicle that has landed for us
        may fall back to the mode in which it stood at first, and then stays in it.

        Args:
            mode: what is flown.
            is_armed: the vehicle.
            first_mode: in which it stood before the first goal.
            was_silent: nothing was heard for a while before.
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
        """Takes the mode; the time after which the goal has failed, None while it has not."""
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
    """Returns whether AUTO.TAKEOFF has ended: hold was heard after the vehicle had left the ground.

    The mode heard last before that says nothing, as heartbeats may be lost on the way.
    """
    return not state.is_landed and state.mode is Mode.LOITER and state.mode_s > state.landed_since_s


APPROACHES: dict[Goal, Approach] = {
    Goal.ARMED: Approach(
        command=dialect.MAV_CMD_COMPONENT_ARM_DISARM,
        parameters=lambda _: (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        is_reached=lambda s: s.is_armed,
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
        is_reached=lambda s: s.mode is Mode.OFFBOARD,
        passes=frozenset({Mode.OFFBOARD}),
        keeps=frozenset({Mode.OFFBOARD}),
        needs_arming=True,
        lead_s=1.0,
    ),
    Goal.HOLDING: Approach(
        command=dialect.MAV_CMD_DO_SET_MODE,
        parameters=lambda _: _set_mode(Mode.LOITER),
        is_reached=lambda s: s.mode is Mode.LOITER,
        passes=frozenset({Mode.LOITER}),
        keeps=frozenset({Mode.LOITER}),
    ),
    Goal.LANDED: Approach(
        command=dialect.MAV_CMD_NAV_LAND,
        parameters=lambda _: (0.0, 0.0, 0.0, NAN, NAN, NAN, NAN),
        is_reached=lambda s: s.is_landed and not s.is_armed,
        passes=frozenset({Mode.LAND}),
        keeps=frozenset({Mode.LAND, Mode.LOITER, Mode.OFFBOARD}),
        timeout_s=120.0,
        underway=frozenset({Mode.LAND}),
    ),
}
