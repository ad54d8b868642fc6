"""Detects from the accuracy that the autopilot reports whether it is losing its position.

Without fixes an estimator continues by inertial sensors alone, and its accuracy gets worse every
second. PX4 takes over by a failsafe after some 5 s of that (EKF2_NOAID_TOUT), or at 5 m
(COM_POS_FS_EPH). Until then no clearance is worth much. A merely bad receiver reports a constant
accuracy: the flight continues with the greatest clearance.

Rules:
1. The position drifts from the report on whose standard deviation is above `WORST_M`, where
   clearances no longer grow with it, and above `GROWTH` times a value of the last `WITHIN_S`.
2. It drifts until reports have said otherwise for `STEADY_S`.
3. After a silence the first report is compared with the last one before it.
"""

from __future__ import annotations

import math
from collections import deque

from companion.motion.position_error import MOST_M, SIGMAS

WORST_M = MOST_M / SIGMAS
"""Standard deviation above which clearances no longer grow with the accuracy."""
GROWTH = 1.5
"""A receiver's own accuracy changes by less in a few seconds. PX4's estimate that was good for 0.25
m is three times as bad after 2.5 s without fixes."""
WITHIN_S = 5.0
STEADY_S = 3.0


class PositionWatch:
    """Follows the accuracy of the position.

    Attributes:
        is_drifting: the autopilot is losing its position.

    >>> watch = PositionWatch()
    >>> for second, accuracy_m in enumerate([0.3, 0.4, 0.6]):
    ...     watch.take(float(second), accuracy_m)
    >>> watch.is_drifting
    True
    """

    def __init__(self) -> None:
        self.is_drifting = False
        self._reports: deque[tuple[float, float]] = deque()
        self._worse_s = -math.inf

    def take(self, now_s: float, accuracy_m: float) -> None:
        """Takes a report.

        Args:
            now_s: when it was heard.
            accuracy_m: standard deviation of the horizontal position.
        """
        reports = self._reports
        reports.append((now_s, accuracy_m))
        while len(reports) > 1 and reports[1][0] <= now_s - WITHIN_S:
            reports.popleft()
        best_m = min(told_m for _, told_m in reports)
        if accuracy_m > max(WORST_M, GROWTH * best_m):
            self._worse_s = now_s
        self.is_drifting = now_s - self._worse_s < STEADY_S
