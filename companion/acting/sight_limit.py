"""No flight is faster than the vehicle can stop within what its range finder sees.

The map shows what was known before. What it does not show, a range finder sees when the vehicle is
near enough (`RangeScan.reach_m`); so that counts for the speed as soon as one is heard, before
arming as a rule. Of several the one that sees least counts: nobody says which of them looks ahead.
A vehicle without a range finder sees nothing, and nothing is promised.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.acting.flight import Flight
from companion.flight_events.skills import SpeedLimitedBySight
from companion.motion.range_scan import RangeScan
from companion.motion.speed_in_sight import fastest_mps


class SightLimit:
    """Of one flight.

    Args:
        flight: is slowed.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._sight_m = math.inf

    def take(self, scans: Sequence[RangeScan]) -> None:
        """Takes scans that were heard."""
        flight = self._flight
        if not scans or flight.limits.is_beyond_sight:
            return
        sight_m = min(scan.reach_m for scan in scans)
        if sight_m >= self._sight_m:
            return
        self._sight_m = sight_m
        speed_mps = fastest_mps(sight_m, flight.profile)
        flight.speed_limit.set_sight_limit(speed_mps)
        asked_mps = flight.speed_limit.greatest_mps
        if speed_mps < asked_mps:
            about = round(speed_mps, 2), asked_mps, round(sight_m, 2)
            flight.report(SpeedLimitedBySight(*about))
