"""The speed limit in force, shared by the costs of plans, the trajectories and the gate.

The target is what the mission and the vehicle allow, or less if an operator says so or the vehicle
does not see far enough. It may change in flight. The limit in force then approaches the new target
at the vehicle's acceleration. A trajectory under way is flown more slowly along the same path,
without a jump in speed, and the gate does not refuse it, because it knows the same limit. New plans
use the target at once.

No clock is read: the caller tells the time.
"""

from __future__ import annotations

import math
from dataclasses import replace

from companion.motion.profile import SpeedLimits
from companion.motion.trajectory import Sample

_ROUNDING = 1e-6  # of a speed; avoids slowing a trajectory that is exactly at the limit


class LiveSpeedLimit:
    """The speed limit of one flight.

    Args:
        limits: those of the mission and its vehicle; the operator and the sight only lower the
            speed.

    Attributes:
        greatest_mps: what the mission and the vehicle allow.
        target: the limits that new plans use.
        now_mps: the speed limit in force.
        version: number of changes of the target.
    """

    def __init__(self, limits: SpeedLimits) -> None:
        self.target = limits
        self.now_mps = limits.speed_mps
        self.version = 0
        self.greatest_mps = limits.speed_mps
        self._operator_mps = self._sight_mps = math.inf
        self._change_mps2 = 0.0
        self._now_s: float | None = None

    @property
    def for_trajectory(self) -> SpeedLimits:
        """The limits of a trajectory made now; above the target while the vehicle slows down."""
        return replace(self.target, speed_mps=max(self.now_mps, self.target.speed_mps))

    def set_operator_limit(self, speed_mps: float) -> None:
        """Sets the operator's limit; one above the mission's limit changes nothing."""
        self._operator_mps = speed_mps
        self._set_target()

    def set_sight_limit(self, speed_mps: float) -> None:
        """Sets the greatest speed from which the vehicle can stop within what it sees."""
        self._sight_mps = speed_mps
        self._set_target()

    def _set_target(self) -> None:
        speed_mps = min(self.greatest_mps, self._operator_mps, self._sight_mps)
        if speed_mps != self.target.speed_mps:
            self.target = replace(self.target, speed_mps=speed_mps)
            self.version += 1

    def advance(self, now_s: float) -> None:
        """Moves on to the time of a tick."""
        passed_s = 0.0 if self._now_s is None else max(0.0, now_s - self._now_s)
        self._now_s = now_s
        missing_mps = self.target.speed_mps - self.now_mps
        step_mps = self.target.acceleration_mps2 * passed_s
        if abs(missing_mps) <= step_mps:
            self.now_mps, self._change_mps2 = self.target.speed_mps, 0.0
        else:
            self.now_mps += math.copysign(step_mps, missing_mps)
            self._change_mps2 = math.copysign(self.target.acceleration_mps2, missing_mps)

    def slowed(self, sample: Sample) -> tuple[Sample, float]:
        """A moment of a trajectory, as it may be flown now.

        Returns:
            The sample, no faster than the limit in force; and the rate at which the trajectory's
            time runs.

        >>> limit = LiveSpeedLimit(SpeedLimits(2.0, 2.0, 8.0))
        >>> limit.set_operator_limit(1.0)
        >>> limit.advance(10.0), limit.advance(10.25)
        (None, None)
        >>> sample = Sample((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 0.0, 0.0), False)
        >>> slowed, rate = limit.slowed(sample)
        >>> slowed.velocity[0], slowed.acceleration[0], rate
        (1.5, -2.0, 0.75)
        """
        speed_mps = math.hypot(*sample.velocity)
        if speed_mps <= self.now_mps * (1 + _ROUNDING):
            return sample, 1.0
        rate = self.now_mps / speed_mps
        along_mps2 = sum(a * v for a, v in zip(sample.acceleration, sample.velocity, strict=True))
        share = (self._change_mps2 - rate**2 * along_mps2 / speed_mps) / speed_mps
        slower = sample.slower(rate)
        north, east, down = (
            a + share * v for a, v in zip(slower.acceleration, sample.velocity, strict=True)
        )
        return replace(slower, acceleration=(north, east, down)), rate
