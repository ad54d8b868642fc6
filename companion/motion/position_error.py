"""The error of the position, as the autopilot estimates it, and what motion makes of it.

An autopilot tells one standard deviation of its horizontal position: `pos_horiz_accuracy` of
ESTIMATOR_STATUS, which PX4 takes from its filter's covariance, north and east together. Along one
axis, as towards a wall, the error is 1 / sqrt(2) of that. It is not divided by, because two more
errors are about as large: the map was laid by the same estimate, and a wrong velocity takes the
vehicle off its route (on a PX4: 0.3 m/s, 0.25 m). Three deviations of what is told are reckoned
with.

The error adds to the vehicle's own deviation from its route, on which it does not depend, as the
root of the squares. That is what the profile says, or what is seen in flight (`tracking_error.py`).
"""

from __future__ import annotations

import math

SIGMAS = 3.0
MOST_M = 1.5
"""No more is reckoned with: an autopilot that is worse off soon lands."""
EXACT_M = 0.1
"""A position that is as good as this is taken for exact."""
EXACT_HEIGHT_M, GPS_HEIGHT_M = 0.3, 1.0
"""What the height is reckoned to be off by, where the position is exact, and where it is not: two
degrees of attitude at 8 m, and two deviations of a PX4's height."""
WORST_HEIGHT_M = 1.4
"""What the height of PX4's simulator was off by at worst, with GPS."""
STEP_M = 0.1
"""The clearance changes by such steps, and with it all routes."""


def greatest_error_m(accuracy_m: float) -> float:
    """How far the vehicle may be from where it is taken to be, towards a wall.

    >>> round(greatest_error_m(0.25), 2)
    0.75
    """
    return min(SIGMAS * accuracy_m, MOST_M)


def height_error_m(accuracy_m: float, up_m: float, below_m: float | None) -> float:
    """How far the vehicle may be below the height that it is taken to have, above what is below.

    Where the position is not exact and a range finder looks down, that is what it says: what it
    sees may be the ground, or stand on it.

    Args:
        accuracy_m: of the position.
        up_m: the height that it is taken to have.
        below_m: the distance to what is below it; None where that is not measured, and inf where
            nothing is within reach.

    >>> height_error_m(0.05, 2.0, 1.0), height_error_m(0.25, 2.0, None)
    (0.3, 1.0)
    >>> [round(height_error_m(0.25, 2.0, below_m), 2) for below_m in (2.1, 1.6, 0.8, math.inf)]
    [0.3, 0.7, 1.5, 1.0]
    """
    if accuracy_m <= EXACT_M:
        return EXACT_HEIGHT_M
    if below_m is None or math.isinf(below_m):
        return GPS_HEIGHT_M
    return max(up_m - below_m, 0.0) + EXACT_HEIGHT_M


class AddedClearance:
    """What routes keep from obstacles beside the clearance of the vehicle's profile.

    It follows both errors in steps, and lags behind by half a step more, so that an error between
    two steps does not change all routes again and again.

    Attributes:
        metres: now.

    Args:
        deviation_m: of the vehicle from its route; the profile's clearance covers it already.
    """

    def __init__(self, deviation_m: float) -> None:
        self.metres = 0.0
        self._deviation_m = deviation_m

    def follow(self, accuracy_m: float, off_m: float = 0.0) -> bool:
        """Takes how good the position is; true if that changes what is added.

        Args:
            accuracy_m: of the position.
            off_m: how far the vehicle is seen to be off its route; it counts where it is more than
                its deviation by more than a step.

        >>> added = AddedClearance(0.15)
        >>> added.follow(0.05), added.follow(0.25), added.metres
        (False, True, 0.6)
        >>> added.follow(0.25, 0.9), added.metres
        (True, 1.0)
        """
        is_more = off_m > self._deviation_m + STEP_M
        seen_m = min(off_m, MOST_M) if is_more else self._deviation_m
        both_m = math.hypot(seen_m, greatest_error_m(accuracy_m))
        wanted_m = both_m - self._deviation_m
        if abs(wanted_m - self.metres) <= STEP_M:
            return False
        self.metres = round(round(wanted_m / STEP_M) * STEP_M, 9)
        return True
