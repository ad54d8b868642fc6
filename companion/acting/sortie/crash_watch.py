"""Detects from MAVLink messages that the vehicle has crashed.

It watches from arming until the vehicle has landed, is disarmed and stands upright:

    sign         when
    DISARMED     disarmed without a reported landing: killed, or stopped by a failure detector
    FALL         it sinks faster than it descends
    IMPACT       its velocity jumps by more than its acceleration explains
    OVERTURNED   it is tilted more than in any flight or landing, in the air or on the ground

A hard touch-down is no crash: at the end of a descent the jump is no larger than the speed of
descent. The vehicle may survive an impact, so another sign may follow; the other signs are final.

PX4 takes 0.9 s to count a vehicle that is disarmed in the air as landed, and reports by one
heartbeat per second that it is disarmed. The fall is detected before that. Left out: accelerations,
which reach 10 g with a stiff landing gear. Source: PX4 1.16, MulticopterLandDetector; failure
detector (FD_FAIL_R 60 degrees, FD_FAIL_R_TTRI 0.3 s).
"""

from __future__ import annotations

import math
from collections import deque
from enum import StrEnum

from companion.geometry import Ned
from companion.vehicle.ports.state import VehicleState
from companion.vehicle_profile import VehicleProfile

DISARMED_S = 0.5
"""Time after disarming within which a landing may still be reported."""
FALL_MPS = 1.5
"""Sinking this much faster than the descent speed is a fall."""
JUMP_S = 0.1
"""The time over which a jump of the velocity is measured."""
JUMP_MPS = 1.0
"""The least jump beyond what the acceleration and a touch-down explain."""
GAP_S = 0.2
"""Older velocities are not compared."""
OVERTURNED_RAD = math.radians(60.0)
OVERTURNED_S = 0.3


class Crash(StrEnum):
    """A sign of a crash, in words."""

    DISARMED = "the vehicle was disarmed in the air"
    FALL = "the vehicle fell"
    IMPACT = "the vehicle has hit something"
    OVERTURNED = "the vehicle is overturned"


class CrashWatch:
    """The watch over one flight.

    Args:
        profile: the vehicle's profile.
    """

    def __init__(self, profile: VehicleProfile) -> None:
        self._crash: Crash | None = None
        self._profile = profile
        self._is_watching = False
        self._disarmed_s: float | None = None
        self._tilted_s: float | None = None
        self._velocities: deque[tuple[float, Ned]] = deque()

    def step(self, now_s: float, state: VehicleState) -> Crash | None:
        """Takes the state of a tick; returns the newest sign so far."""
        is_done = state.is_standing and state.attitude.tilt_rad < OVERTURNED_RAD
        self._is_watching = state.heartbeat.is_armed or (self._is_watching and not is_done)
        if not self._is_watching or self._crash not in (None, Crash.IMPACT):
            return self._crash
        self._crash = self._final_sign(now_s, state) or self._crash or self._impact(state)
        return self._crash

    def _final_sign(self, now_s: float, state: VehicleState) -> Crash | None:
        is_flying = not state.is_landed
        is_disarmed = is_flying and not state.heartbeat.is_armed
        self._disarmed_s = (self._disarmed_s or now_s) if is_disarmed else None
        is_tilted = state.attitude.tilt_rad >= OVERTURNED_RAD
        self._tilted_s = (self._tilted_s or now_s) if is_tilted else None
        if self._tilted_s is not None and now_s - self._tilted_s >= OVERTURNED_S:
            return Crash.OVERTURNED
        if is_flying and state.motion.velocity[2] > self._profile.descent_mps + FALL_MPS:
            return Crash.FALL
        if self._disarmed_s is not None and now_s - self._disarmed_s >= DISARMED_S:
            return Crash.DISARMED
        return None

    def _impact(self, state: VehicleState) -> Crash | None:
        """Compares the velocity with the newest one that is old enough."""
        before, at_s = self._velocities, state.motion.boot_s
        if before and before[-1][0] - at_s > GAP_S:
            before.clear()  # the clock of an autopilot that has restarted
        if before and before[-1][0] >= at_s:
            return None
        before.append((at_s, state.motion.velocity))
        old_s = at_s - JUMP_S + 1e-6
        while len(before) > 1 and before[1][0] <= old_s:
            before.popleft()
        elapsed_s, velocity = at_s - before[0][0], before[0][1]
        if before[0][0] > old_s or state.is_landed or elapsed_s > GAP_S:
            return None
        most = JUMP_MPS + self._profile.max_acceleration_mps2 * elapsed_s
        north, east, down = (b - a for a, b in zip(velocity, state.motion.velocity, strict=True))
        touch_down_mps = self._profile.descent_mps if down < 0 else 0.0
        has_hit = math.hypot(north, east) > most or abs(down) > most + touch_down_mps
        return Crash.IMPACT if has_hit else None
