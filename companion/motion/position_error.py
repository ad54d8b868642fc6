"""The error of the position that the autopilot estimates, and the clearance that covers it.

An autopilot reports one standard deviation of its horizontal position: `pos_horiz_accuracy` of
ESTIMATOR_STATUS, which PX4 takes from its filter's covariance, for north and east together. Along
one axis, as towards a wall, the error is 1 / sqrt(2) of that. We do not divide by sqrt(2), because
two more errors are about as large: the map was made with the same estimate, and a wrong velocity
takes the vehicle off its route (on a PX4: 0.3 m/s, 0.25 m). We use three of the reported
deviations.

The vehicle's deviation from its route is independent of that error, so the two are added as the
root of the sum of their squares. The deviation is that of the profile, or what is observed in
flight (`tracking_error.py`).
"""

from __future__ import annotations

import math

SIGMAS = 3.0
MOST_M = 1.5
"""The greatest error that is covered: an autopilot with a worse position soon lands."""
EXACT_M = 0.1
"""A position with at most this error counts as exact."""
EXACT_HEIGHT_M, GPS_HEIGHT_M = 0.3, 1.0
"""The assumed error of the height, if the position is exact and if not: two degrees of attitude at
8 m, and two deviations of PX4's height."""
WORST_HEIGHT_M = 1.4
"""The largest height error of PX4's simulator with GPS."""
STEP_M = 0.1
"""The step by which the clearance changes, and with it all routes."""


def greatest_error_m(accuracy_m: float) -> float:
    """The greatest distance of the vehicle from its estimated position, towards a wall.

    >>> round(greatest_error_m(0.25), 2)
    0.75
    """
    return min(SIGMAS * accuracy_m, MOST_M)


def height_error_m(accuracy_m: float, up_m: float, below_m: float | None) -> float:
    """How far the vehicle may be below its estimated height above what is below it.

    If the position is not exact and a range finder looks down, its measurement decides: what it
    sees may be the ground, or something that stands on the ground.

    Args:
        accuracy_m: accuracy of the position.
        up_m: the estimated height.
        below_m: the distance to what is below the vehicle; None if that is not measured, inf if
            nothing is within range.

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
    """What routes keep from obstacles in addition to the clearance of the vehicle's profile.

    It follows both errors in steps, with a hysteresis of half a step, so that an error between two
    steps does not change all routes again and again.

    Attributes:
        metres: the present value.

    Args:
        deviation_m: deviation of the vehicle from its route, which the profile's clearance already
            covers.
    """

    def __init__(self, deviation_m: float) -> None:
        self.metres = 0.0
        self._deviation_m = deviation_m

    def follow(self, accuracy_m: float, off_m: float = 0.0) -> bool:
        """Takes the accuracy of the position; true if that changes the added clearance.

        Args:
            accuracy_m: accuracy of the position.
            off_m: observed distance of the vehicle from its route; it counts only if it exceeds the
                profile's deviation by more than a step.

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
