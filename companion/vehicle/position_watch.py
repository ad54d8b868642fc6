"""Whether the autopilot is losing its position, by the accuracy that it tells.

Without fixes an estimator goes on by inertial sensors alone, and its accuracy gets worse from one
second to the next. PX4 takes the vehicle by a failsafe after some 5 s of that (EKF2_NOAID_TOUT), or
at 5 m (COM_POS_FS_EPH). Until then no clearance that is kept means much. A receiver that is merely
bad tells an accuracy that stays as it is: the flight goes on with the most clearance there is.

Rules:
1. The position drifts from the report on by which its standard deviation is beyond `WORST_M`, where
   clearances no longer follow, and `GROWTH` times what it was at some time in `WITHIN_S` before.
2. It does so until reports have said something else for `STEADY_S`.
3. After a silence the first report is compared with the last one before.
"""

from __future__ import annotations

import math
from collections import deque

from companion.motion.position_error import MOST_M, SIGMAS

WORST_M = MOST_M / SIGMAS
"""Standard deviation beyond which clearances no longer follow the accuracy."""
GROWTH = 1.5
"""A receiver's own accuracy changes by less in a few seconds; an estimate of PX4 that was good for
0.25 m is three times as bad after 2.5 s without fixes."""
WITHIN_S = 5.0
STEADY_S = 3.0


class PositionWatch:
    """Follows the accuracy of the position.

    Attributes:
        is_drifting: the position is being lost.

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
