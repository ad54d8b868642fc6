"""The gate that every setpoint passes; nothing else sends one.

Rules, in this order; the first that applies decides:
1. No position known, or none for `lost_s`, or the mode is not ours: nothing is sent.
2. Telemetry older than `max_age_s`: hold.
3. A number that is not finite: hold.
4. Outside the fence or the altitude band: hold.
5. Further from the vehicle than the carrot: hold. A setpoint that stays behind when
   this program dies means "hover a carrot's length ahead", never "fly to the far end".
6. Faster than the speed limit: hold.
7. Climbing or descending faster than the vehicle can: hold.

To hold is to be sent to the present position with no velocity. The gate knows no map: walls
are the business of routes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.geometry import NorthEast, distance, is_in_polygon
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
        lost_s: age of telemetry at which the stream ends and the autopilot's failsafe begins.
    """

    fence: tuple[NorthEast, ...]
    up_m: tuple[float, float]
    speed_mps: float
    climb_mps: float
    descent_mps: float
    carrot_m: float
    max_age_s: float = 0.5
    lost_s: float = 3.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """What may be sent, and why it is not what was asked for ("" if it is)."""

    setpoint: Setpoint | None
    refusal: str = ""


def admit(
    setpoint: Setpoint,
    state: VehicleState | None,
    now_s: float,
    is_our_mode: bool,
    envelope: Envelope,
) -> Verdict:
    """The setpoint itself, a hold in its place, or nothing."""
    if state is None or not all(map(math.isfinite, (*state.position, state.yaw_rad))):
        return Verdict(None, "the position is unknown")
    age_s = now_s - state.stamp_s
    if age_s > envelope.lost_s:
        return Verdict(None, f"no position for {age_s:.1f} s")
    if not is_our_mode:
        return Verdict(None, f"the mode is {state.mode.value}")
    for rule in _RULES:
        refusal = rule(setpoint, state, age_s, envelope)
        if refusal:
            return Verdict(hold_at(state.position, state.yaw_rad), refusal)
    return Verdict(setpoint)


def _stale(_: Setpoint, __: VehicleState, age_s: float, envelope: Envelope) -> str:
    return f"the position is {age_s:.1f} s old" if age_s > envelope.max_age_s else ""


def _not_finite(setpoint: Setpoint, _: VehicleState, __: float, ___: Envelope) -> str:
    vectors = (*setpoint.position, *setpoint.velocity, *setpoint.acceleration)
    numbers = (*vectors, setpoint.yaw_rad)
    return "" if all(map(math.isfinite, numbers)) else "the setpoint is not finite"


def _outside_fence(setpoint: Setpoint, _: VehicleState, __: float, envelope: Envelope) -> str:
    return "" if is_in_polygon(setpoint.position, envelope.fence) else "outside the fence"


def _outside_band(setpoint: Setpoint, _: VehicleState, __: float, envelope: Envelope) -> str:
    low, high = envelope.up_m
    return "" if low <= -setpoint.position[2] <= high else "outside the altitude band"


def _too_far(setpoint: Setpoint, state: VehicleState, _: float, envelope: Envelope) -> str:
    gap_m = distance(setpoint.position, state.position)
    return f"{gap_m:.1f} m from the vehicle" if gap_m > envelope.carrot_m else ""


def _too_fast(setpoint: Setpoint, _: VehicleState, __: float, envelope: Envelope) -> str:
    speed_mps = math.hypot(*setpoint.velocity)
    is_within = speed_mps <= envelope.speed_mps * SPEED_TOLERANCE
    return "" if is_within else f"{speed_mps:.1f} m/s is too fast"


def _too_steep(setpoint: Setpoint, _: VehicleState, __: float, envelope: Envelope) -> str:
    down_mps = setpoint.velocity[2]
    most_mps = envelope.descent_mps if down_mps > 0 else envelope.climb_mps
    if abs(down_mps) <= most_mps * SPEED_TOLERANCE:
        return ""
    return f"{abs(down_mps):.1f} m/s {'down' if down_mps > 0 else 'up'} is too fast"


_RULES: Sequence[Callable[[Setpoint, VehicleState, float, Envelope], str]] = (
    _stale,
    _not_finite,
    _outside_fence,
    _outside_band,
    _too_far,
    _too_fast,
    _too_steep,
)
