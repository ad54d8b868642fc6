"""The gate that every setpoint passes; nothing else sends one.

Rules, in this order; the first that applies decides:
1. No position known, or none for `lost_s`, or the mode is not ours: nothing is sent.
2. Telemetry older than `max_age_s`: hold.
3. Asked for longer ago than `lease_s`: hold. Who flies renews the setpoint in every tick.
4. A number that is not finite: hold.
5. Outside the fence or the altitude band: hold.
6. Further from the vehicle than the carrot: hold. A setpoint that stays behind when
   this program dies means "hover a carrot's length ahead", never "fly to the far end".
7. Faster than the speed limit: hold.
8. Climbing or descending faster than the vehicle can: hold.

To hold is to be sent to the present position with no velocity. The gate knows no map: walls
are the business of routes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.geometry import NorthEast, distance, is_in_polygon
from companion.outcomes import Refusal
from companion.vehicle.port import Setpoint, VehicleState, hold_at

SPEED_TOLERANCE = 1.01
"""Rounding of a velocity that is exactly at the limit must not stop the vehicle."""


@dataclass(frozen=True, slots=True)
class Envelope:
    """What no setpoint may leave.

    Attributes:
        fence: polygon of north-east corners.
        up_m: lowest and highest altitude above home.
        speed_mps: greatest speed.
        climb_mps: greatest vertical speed upwards.
        descent_mps: the same downwards.
        carrot_m: greatest distance of a setpoint from the vehicle.
        max_age_s: age of telemetry at which the vehicle holds.
        lease_s: age of a setpoint at which the vehicle holds.
        lost_s: age of telemetry at which the stream ends and the autopilot's failsafe begins.
    """

    fence: tuple[NorthEast, ...]
    up_m: tuple[float, float]
    speed_mps: float
    climb_mps: float
    descent_mps: float
    carrot_m: float
    max_age_s: float = 0.5
    lease_s: float = 0.5
    lost_s: float = 3.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """What may be sent, and why it is not what was asked for; without a refusal it is."""

    setpoint: Setpoint | None
    refusal: Refusal | None = None


def admit(
    setpoint: Setpoint,
    asked_s: float,
    state: VehicleState | None,
    now_s: float,
    is_our_mode: bool,
    envelope: Envelope,
) -> Verdict:
    """The setpoint that was asked for at some time, a hold in its place, or nothing."""
    if state is None or not all(map(math.isfinite, (*state.position, state.yaw_rad))):
        return Verdict(None, Refusal("the position is unknown"))
    age_s = now_s - state.stamp_s
    if age_s > envelope.lost_s:
        return Verdict(None, Refusal(f"no position for {age_s:.1f} s"))
    if not is_our_mode:
        return Verdict(None, Refusal(f"the mode is {state.mode.value}"))
    asked = _Asked(setpoint, now_s - asked_s, state, age_s, envelope)
    for rule in _RULES:
        if refusal := rule(asked):
            return Verdict(hold_at(state.position, state.yaw_rad), refusal)
    return Verdict(setpoint)


@dataclass(frozen=True, slots=True)
class _Asked:
    """What rules 2 to 8 judge: a setpoint and the vehicle's state, and how old both are."""

    setpoint: Setpoint
    setpoint_age_s: float
    state: VehicleState
    age_s: float
    envelope: Envelope


def _stale(asked: _Asked) -> Refusal | None:
    is_fresh = asked.age_s <= asked.envelope.max_age_s
    return None if is_fresh else Refusal(f"the position is {asked.age_s:.1f} s old")


def _ownerless(asked: _Asked) -> Refusal | None:
    is_renewed = asked.setpoint_age_s <= asked.envelope.lease_s
    return None if is_renewed else Refusal(f"not renewed for {asked.setpoint_age_s:.1f} s")


def _not_finite(asked: _Asked) -> Refusal | None:
    setpoint = asked.setpoint
    vectors = (*setpoint.position, *setpoint.velocity, *setpoint.acceleration)
    is_finite = all(map(math.isfinite, (*vectors, setpoint.yaw_rad)))
    return None if is_finite else Refusal("the setpoint is not finite")


def _outside_fence(asked: _Asked) -> Refusal | None:
    is_inside = is_in_polygon(asked.setpoint.position, asked.envelope.fence)
    return None if is_inside else Refusal("outside the fence")


def _outside_band(asked: _Asked) -> Refusal | None:
    low, high = asked.envelope.up_m
    is_inside = low <= -asked.setpoint.position[2] <= high
    return None if is_inside else Refusal("outside the altitude band")


def _too_far(asked: _Asked) -> Refusal | None:
    gap_m = distance(asked.setpoint.position, asked.state.position)
    is_near = gap_m <= asked.envelope.carrot_m
    return None if is_near else Refusal(f"{gap_m:.1f} m from the vehicle")


def _too_fast(asked: _Asked) -> Refusal | None:
    speed_mps = math.hypot(*asked.setpoint.velocity)
    is_within = speed_mps <= asked.envelope.speed_mps * SPEED_TOLERANCE
    return None if is_within else Refusal(f"{speed_mps:.1f} m/s is too fast")


def _too_steep(asked: _Asked) -> Refusal | None:
    down_mps, envelope = asked.setpoint.velocity[2], asked.envelope
    down, up = ("down", envelope.descent_mps), ("up", envelope.climb_mps)
    direction, most_mps = down if down_mps > 0 else up
    is_within = abs(down_mps) <= most_mps * SPEED_TOLERANCE
    return None if is_within else Refusal(f"{abs(down_mps):.1f} m/s {direction} is too fast")


_RULES: Sequence[Callable[[_Asked], Refusal | None]] = (
    _stale,
    _ownerless,
    _not_finite,
    _outside_fence,
    _outside_band,
    _too_far,
    _too_fast,
    _too_steep,
)
