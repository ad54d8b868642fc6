"""Estimates the error of the autopilot's velocity, from the change of its position.

An estimator's velocity may be wrong for seconds while fixes hold its position. The autopilot
controls by both: with a velocity error b it stands b / MPC_XY_P beside its setpoint, or b / MPC_Z_P
above it (a PX4 with noisy inertial sensors: 0.4 m, and up to 1.5 m; 0.15 m). The change of the
position tells the true velocity. So setpoints are sent in the autopilot's own measure: the error is
added to their velocity, as their positions are converted to its frame.

Position and velocity are smoothed alike, so that the error is zero where they agree, however the
vehicle is flown:

    b = lowpass(v) - d/dt lowpass(p)

Rules:
1. An error below IGNORED_MPS counts as rounding; at most MOST_MPS is added.
2. A jump of the position is not motion: the estimator has moved it.
3. Nothing is known before SMOOTH_S of successive reports. After a gap, or a report older than
   FRESH_S, estimation starts anew.
"""

from __future__ import annotations

import math

from companion.geometry import Ned

SMOOTH_S = 0.5
"""Time constant. On logs of a PX4, 0.3 to 1 s explained four fifths of its distance from the
setpoint."""
IGNORED_MPS = 0.05
MOST_MPS = 0.6
JUMP_M = 0.3
"""A change of the position between two reports, beyond what the velocity accounts for."""
FRESH_S = 0.5
"""Greatest age of a report, and greatest time between two."""
STILL = (0.0, 0.0, 0.0)


class VelocityBias:
    """Follows the positions and velocities of one vehicle."""

    def __init__(self) -> None:
        self._heard_s = self._measured_s = self._begun_s = -math.inf
        self._before = [0.0] * 6  # north, east, down, and the velocities
        self._smooth = self._before

    def take(self, now_s: float, measured_s: float, position: Ned, velocity: Ned) -> None:
        """Takes a report; all its numbers are finite.

        Args:
            now_s: when it was heard.
            measured_s: when it was measured, by the autopilot's clock.
            position: by the autopilot's estimate: north, east, down; m.
            velocity: likewise; m/s.
        """
        since_s, before = measured_s - self._measured_s, self._before
        if since_s == 0.0:
            return
        report = [*position, *velocity]
        self._heard_s, self._measured_s, self._before = now_s, measured_s, report
        if not 0 < since_s <= FRESH_S:
            self._begun_s, self._smooth = measured_s, report
            return
        mean = [(old + new) / 2 for old, new in zip(before[3:], velocity, strict=True)]
        jump = [position[i] - before[i] - mean[i] * since_s for i in range(3)]
        if math.hypot(*jump) > JUMP_M:
            shift = zip(self._smooth, [*jump, 0.0, 0.0, 0.0], strict=True)
            self._smooth = [old + by for old, by in shift]
        share = since_s / (SMOOTH_S + since_s)
        smooth = zip(self._smooth, [*position, *mean], strict=True)
        self._smooth = [old + share * (new - old) for old, new in smooth]

    def at(self, now_s: float) -> Ned:
        """What to add to a velocity so that the vehicle flies it, in m/s."""
        is_stale = now_s - self._heard_s > FRESH_S
        if is_stale or self._measured_s - self._begun_s < SMOOTH_S:
            return STILL
        position, smooth = self._before, self._smooth
        off = [smooth[3 + i] - (position[i] - smooth[i]) / SMOOTH_S for i in range(3)]
        size_mps = math.hypot(*off)
        if size_mps <= IGNORED_MPS:
            return STILL
        counted = min(size_mps - IGNORED_MPS, MOST_MPS) / size_mps
        return (off[0] * counted, off[1] * counted, off[2] * counted)
