"""A setpoint that follows a target which may move: slowly, smoothly, and without overshoot.

Its speed is proportional to the remaining distance, up to a limit, and changes by at most
MOST_MPS2. With a gain of 1 per second it comes to rest at the target without overshooting.
"""

from __future__ import annotations

import math

from companion.geometry import Ned
from companion.motion.trajectory import AT_REST, Sample

GAIN_PER_S = 1.0
MOST_MPS2 = 1.0


class Glide:
    """A moving setpoint.

    Args:
        position: where it begins, at rest.

    Attributes:
        position: position of the setpoint.
        velocity: velocity of the setpoint.
    """

    def __init__(self, position: Ned) -> None:
        self.position = position
        self.velocity: Ned = AT_REST

    def step(
        self, target: Ned, dt_s: float, speed_mps: float, climb_mps: float, descent_mps: float
    ) -> Sample:
        """Moves on towards a target.

        >>> glide = Glide((0.0, 0.0, -2.0))
        >>> for _ in range(200):
        ...     sample = glide.step((1.0, 0.0, -1.0), 0.05, 1.0, 1.0, 0.5)
        >>> [round(metres, 2) for metres in sample.position]
        [1.0, 0.0, -1.0]

        Args:
            target: the target now.
            dt_s: time since the step before.
            speed_mps: greatest speed over the ground.
            climb_mps: greatest speed upwards.
            descent_mps: greatest speed downwards.
        """
        north, east, down = (t - p for t, p in zip(target, self.position, strict=True))
        left_m = math.hypot(north, east)
        share = GAIN_PER_S * min(1.0, speed_mps / (GAIN_PER_S * left_m)) if left_m else 0.0
        sink_mps = min(max(GAIN_PER_S * down, -climb_mps), descent_mps)
        wanted = (share * north, share * east, sink_mps)
        self.velocity = _changed(self.velocity, wanted, MOST_MPS2 * dt_s)
        moved = (p + v * dt_s for p, v in zip(self.position, self.velocity, strict=True))
        north, east, down = moved
        self.position = (north, east, down)
        return Sample(self.position, self.velocity, AT_REST, is_finished=False)

    def wait(self) -> Sample:
        """Stays where it is, because the vehicle falls behind."""
        self.velocity = AT_REST
        return Sample(self.position, AT_REST, AT_REST, is_finished=False)


def _changed(velocity: Ned, wanted: Ned, most_mps: float) -> Ned:
    """A velocity changed towards another one, by at most `most_mps`."""
    change = [w - v for v, w in zip(velocity, wanted, strict=True)]
    size_mps = math.hypot(*change)
    share = min(1.0, most_mps / size_mps) if size_mps else 0.0
    north, east, down = (v + share * c for v, c in zip(velocity, change, strict=True))
    return (north, east, down)
