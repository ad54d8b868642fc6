"""The gate that every setpoint passes: a run-time monitor that knows nothing of plans or routes.

It is small and pure, and shares no code with what it monitors (ASTM F3269, run-time assurance). It
has its own points, distances and polygons, and relies only on the vehicle's state and the limits.

Rules, in this order; the first that applies decides:
1. Position or heading unknown, no position for `lost_s`, no mode for `mode_lost_s`, not armed, or a
   mode that is not ours: nothing is sent.
2. Position or heading older than `max_age_s`, or the autopilot is losing its position: hold.
3. The place of the mission's frame in the autopilot's frame is not certain: hold.
4. The setpoint was requested longer ago than `lease_s`: hold. The caller renews it in every tick.
5. The setpoint belongs to the task's plan, and the task is violated: hold. A return or a landing
   continues.
6. A number is not finite: hold.
7. Hold if the setpoint (a) is outside the fence, or closer to its edge than the margin; this holds
   for the mission's fence and for an autopilot's fence that is kept beside it; (b) is in a keep-out
   zone or within its margin, or the straight line to it crosses a zone; (c) is outside the altitude
   band. A vehicle that is already in a zone, or outside the band, may be sent to where it is less
   so. A landing on a marker may descend to its site's lowest altitude, below or above the lower end
   of the band.
8. Further from the vehicle than the carrot: hold. So if this program dies, the last setpoint means
   "hover a carrot's length ahead", never "fly to the far end". The vehicle is where it is by now:
   it has flown on at its velocity since it was measured, for `EXTRAPOLATED_S` at most, and no
   faster than the speed limit.
9. Faster than the speed limit: hold.
10. Climbing or descending faster than the vehicle can: hold.

To hold means: the setpoint is the point where the hold began, at rest, while that point is within
the carrot. A PX4 that was sent to its present position in each tick drifted 2.6 m in 6 s. If the
frame is in doubt, the setpoint is the present position, which is right in both frames. Routes, not
the gate, keep clear of walls.

After the gate, `setpoint_stream.py` converts setpoints to the autopilot's own measure: it adds at
most `velocity_bias.MOST_MPS` to the velocity, the error of the autopilot's own estimate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.outcomes import Refusal
from companion.vehicle.gate_polygons import Corner, distance_to, edges, is_crossing, is_inside_of
from companion.vehicle.ports.setpoints import Setpoint, hold_at
from companion.vehicle.ports.state import Mode, VehicleState

EXTRAPOLATED_S = 0.2
"""An older position is not extrapolated further. In this time a vehicle that brakes at 5 m/s2 falls
0.1 m behind; one that flies at 10 m/s moves by 2 m."""
SPEED_TOLERANCE = 1.01
"""So that rounding of a velocity exactly at the limit does not stop the vehicle."""


@dataclass(frozen=True, slots=True)
class LandingSite:
    """A place where the mission lands on a marker.

    Attributes:
        centre: its middle.
        radius_m: of the site.
        lowest_up_m: lowest altitude above home of setpoints there.
    """

    centre: Corner
    radius_m: float
    lowest_up_m: float


@dataclass(frozen=True, slots=True)
class Envelope:
    """The limits that no setpoint may exceed.

    Attributes:
        fence: polygon of north-east corners.
        fence_margin_m: least distance from edges of the fence and of zones.
        keep_out: polygons that are not to be entered.
        within: polygons of the autopilot's own fence; setpoints stay in each of them as in the
            fence.
        up_m: lowest and highest altitude above home.
        speed_mps: greatest speed.
        climb_mps: greatest vertical speed upwards.
        descent_mps: greatest vertical speed downwards.
        carrot_m: greatest distance of a setpoint from the vehicle.
        sites: where the vehicle may land on markers.
        max_age_s: age of position or heading at which the vehicle holds.
        lease_s: age of a setpoint at which the vehicle holds.
        lost_s: age of the position at which the stream ends, so that the autopilot's failsafe
            begins.
        mode_lost_s: age of the mode at which the stream ends. A link that loses 30 % of its
            messages loses five heartbeats in a row in every other flight of five minutes, ten in
            one of a thousand.
    """

    fence: tuple[Corner, ...]
    up_m: tuple[float, float]
    speed_mps: float
    climb_mps: float
    descent_mps: float
    carrot_m: float
    fence_margin_m: float = 0.0
    keep_out: tuple[tuple[Corner, ...], ...] = ()
    max_age_s: float = 0.5
    lease_s: float = 0.5
    lost_s: float = 3.0
    mode_lost_s: float = 10.0
    sites: tuple[LandingSite, ...] = ()
    within: tuple[tuple[Corner, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class Request:
    """A requested setpoint.

    Attributes:
        asked_s: when it was requested.
        is_for_task: it belongs to the task's plan, not to a return, a landing or a hold.
        is_landing: it belongs to the descent to a marker, or to the climb from there.
    """

    setpoint: Setpoint
    asked_s: float
    is_for_task: bool = False
    is_landing: bool = False


@dataclass(frozen=True, slots=True)
class Verdict:
    """What may be sent; and, if that is a hold or nothing, why."""

    setpoint: Setpoint | None
    refusal: Refusal | None = None


def admit(
    request: Request,
    state: VehicleState | None,
    now_s: float,
    envelope: Envelope,
    *,
    is_entering: bool = False,
    is_violated: bool = False,
    frame_doubt: Refusal | None = None,
    before: Verdict | None = None,
) -> Verdict:
    """Returns the requested setpoint, or a hold in its place, or nothing.

    Args:
        request: the requested setpoint.
        state: of the vehicle, as last heard.
        now_s: the time.
        envelope: the limits.
        is_entering: OFFBOARD is about to be requested; the autopilot wants setpoints before that.
        is_violated: the task can no longer be satisfied.
        frame_doubt: why the autopilot may misplace positions of the mission. A hold at the present
            position is right even so.
        before: the verdict of the previous tick; if it was a hold, that hold continues.
    """
    if state is None:
        return Verdict(None, Refusal("the position is unknown"))
    judged = _Judged(request, state, now_s, envelope, is_entering, is_violated, frame_doubt)
    for rule in _SILENT:
        if refusal := rule(judged):
            return Verdict(None, refusal)
    for rule in _HOLD:
        if refusal := rule(judged):
            return Verdict(_hold(judged, before), refusal)
    return Verdict(request.setpoint)


def _hold(judged: _Judged, before: Verdict | None) -> Setpoint:
    """A hold where the present hold began; at the present position if it begins now."""
    here, carrot_m = judged.state.motion.position, judged.envelope.carrot_m
    begun = before.setpoint if before is not None and before.refusal is not None else None
    if (
        begun is None
        or judged.frame_doubt is not None
        or math.dist(begun.position, here) > carrot_m
    ):
        return hold_at(here, judged.state.attitude.yaw_rad)
    return begun


@dataclass(frozen=True, slots=True)
class _Judged:
    """The input of the rules. Each rule tests for what is allowed, so that NaN is refused."""

    request: Request
    state: VehicleState
    now_s: float
    envelope: Envelope
    is_entering: bool
    is_violated: bool
    frame_doubt: Refusal | None


def _unknown(judged: _Judged) -> Refusal | None:
    is_known = _is_finite(*judged.state.motion.position, judged.state.attitude.yaw_rad)
    return None if is_known else Refusal("the position is unknown")


def _lost(judged: _Judged) -> Refusal | None:
    age_s = judged.state.motion.age_s(judged.now_s)
    return None if age_s <= judged.envelope.lost_s else Refusal(f"no position for {age_s:.1f} s")


def _mode_lost(judged: _Judged) -> Refusal | None:
    age_s = judged.state.heartbeat.age_s(judged.now_s)
    return None if age_s <= judged.envelope.mode_lost_s else Refusal(f"no mode for {age_s:.1f} s")


def _disarmed(judged: _Judged) -> Refusal | None:
    return None if judged.state.heartbeat.is_armed else Refusal("the vehicle is not armed")


def _not_ours(judged: _Judged) -> Refusal | None:
    mode = judged.state.heartbeat.mode
    is_ours = mode is Mode.OFFBOARD or judged.is_entering
    return None if is_ours else Refusal(f"the mode is {mode.value}")


def _stale(judged: _Judged) -> Refusal | None:
    for name, measured in ("position", judged.state.motion), ("heading", judged.state.attitude):
        age_s = measured.age_s(judged.now_s)
        if not age_s <= judged.envelope.max_age_s:
            return Refusal(f"the {name} is {age_s:.1f} s old")
    return None


def _drifting(judged: _Judged) -> Refusal | None:
    good_for = f"good for {judged.state.motion.accuracy_m:.1f} m, and gets worse"
    return Refusal(f"the position is {good_for}") if judged.state.motion.is_drifting else None


def _displaced(judged: _Judged) -> Refusal | None:
    return judged.frame_doubt


def _ownerless(judged: _Judged) -> Refusal | None:
    age_s = judged.now_s - judged.request.asked_s
    return None if age_s <= judged.envelope.lease_s else Refusal(f"not renewed for {age_s:.1f} s")


def _in_vain(judged: _Judged) -> Refusal | None:
    is_in_vain = judged.is_violated and judged.request.is_for_task
    return Refusal("the task is violated") if is_in_vain else None


def _not_finite(judged: _Judged) -> Refusal | None:
    setpoint = judged.request.setpoint
    vectors = (*setpoint.position, *setpoint.velocity, *setpoint.acceleration)
    return None if _is_finite(*vectors, setpoint.yaw_rad) else Refusal("the setpoint is not finite")


def _outside_fence(judged: _Judged) -> Refusal | None:
    envelope, there = judged.envelope, judged.request.setpoint.position[:2]
    if not is_inside_of(there, envelope.fence, envelope.fence_margin_m):
        return Refusal("outside the fence")
    is_inside = all(is_inside_of(there, area, envelope.fence_margin_m) for area in envelope.within)
    return None if is_inside else Refusal("outside the autopilot's own fence")


def _in_zone(judged: _Judged) -> Refusal | None:
    there, here = judged.request.setpoint.position[:2], judged.state.motion.position[:2]
    for zone in judged.envelope.keep_out:
        away_m = distance_to(here, zone)
        if not distance_to(there, zone) >= min(away_m, judged.envelope.fence_margin_m):
            return Refusal("in a keep-out zone")
        if away_m >= 0 and any(is_crossing(here, there, *edge) for edge in edges(zone)):
            return Refusal("behind a keep-out zone")
    return None


def _outside_band(judged: _Judged) -> Refusal | None:
    low, high = judged.envelope.up_m
    north, east, down = judged.request.setpoint.position
    if judged.request.is_landing:
        sites = judged.envelope.sites
        over = [s.lowest_up_m for s in sites if math.dist(s.centre, (north, east)) <= s.radius_m]
        low = max(over, default=low)
    here_up_m = -judged.state.motion.position[2]
    is_inside = min(low, here_up_m) <= -down <= max(high, here_up_m)
    return None if is_inside else Refusal("outside the altitude band")


def _too_far(judged: _Judged) -> Refusal | None:
    gap_m = math.dist(judged.request.setpoint.position, _here(judged))
    is_near = gap_m <= judged.envelope.carrot_m
    return None if is_near else Refusal(f"{gap_m:.1f} m from the vehicle")


def _here(judged: _Judged) -> tuple[float, ...]:
    """Where the vehicle is by now."""
    motion, most_mps = judged.state.motion, judged.envelope.speed_mps
    seconds = min(max(0.0, motion.age_s(judged.now_s)), EXTRAPOLATED_S)
    speed_mps = math.hypot(*motion.velocity)
    if speed_mps > most_mps:
        seconds *= most_mps / speed_mps
    return tuple(p + v * seconds for p, v in zip(motion.position, motion.velocity, strict=True))


def _too_fast(judged: _Judged) -> Refusal | None:
    speed_mps = math.hypot(*judged.request.setpoint.velocity)
    is_within = speed_mps <= judged.envelope.speed_mps * SPEED_TOLERANCE
    return None if is_within else Refusal(f"{speed_mps:.1f} m/s is too fast")


def _too_steep(judged: _Judged) -> Refusal | None:
    down_mps, envelope = judged.request.setpoint.velocity[2], judged.envelope
    down, up = ("down", envelope.descent_mps), ("up", envelope.climb_mps)
    direction, most_mps = down if down_mps > 0 else up
    is_within = abs(down_mps) <= most_mps * SPEED_TOLERANCE
    return None if is_within else Refusal(f"{abs(down_mps):.1f} m/s {direction} is too fast")


def _is_finite(*numbers: float) -> bool:
    return all(map(math.isfinite, numbers))


_Rule = Callable[[_Judged], Refusal | None]
_SILENT: Sequence[_Rule] = (_unknown, _lost, _mode_lost, _disarmed, _not_ours)
_HOLD: Sequence[_Rule] = (
    _stale,
    _drifting,
    _displaced,
    _ownerless,
    _in_vain,
    _not_finite,
    _outside_fence,
    _in_zone,
    _outside_band,
    _too_far,
    _too_fast,
    _too_steep,
)
