"""One landing marker, followed through its sightings.

Sightings come 10 to 50 times a second, and some are of other things. The position is the median of
those of the last WINDOW_S, axis by axis, so single strays do not move it.

Rules for a sighting:
1. It lies where the mission says that the marker is: in its region, as far as the position can
   tell, and within HEIGHT_M of its height. Otherwise it is refused.
2. It lies within STRAY_M of the previous median. Otherwise it is a stray, and refused. If strays
   outnumber the others, either the marker has been moved there, or the first sightings were the
   strays.
Rule for the marker:
3. A marker more than MOVED_M from where it was first seen has moved, and so has one that was moved
   as in rule 2. The vehicle does not land on anything that moves.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from statistics import median

from companion.geometry import Ned
from companion.motion.position_error import greatest_error_m
from companion.motion.region import Region
from companion.outcomes import Refusal

LAND_FROM_M = 0.5
"""Height above the marker from which the autopilot lands on its own."""
HEIGHT_M = 1.0
"""The greatest error of a marker's apparent height: altitudes drift with the air pressure."""
WINDOW_S = 0.6
FEWEST = 3
"""The least number of sightings in the window before the marker counts as seen."""
STRAY_M = 0.5
MOVED_M = 1.0


@dataclass(frozen=True, slots=True)
class ExpectedMarker:
    """Where the mission says that a marker is.

    Attributes:
        place: its place, a point above it.
        region: the region of that place, in which the marker lies.
        up_m: its height above home.
    """

    place: Ned
    region: Region
    up_m: float

    def why_not(self, position: Ned, accuracy_m: float) -> Refusal | None:
        """Why something seen at this position cannot be the marker; None if it can."""
        north, east, down = position
        level = (north, east, self.place[2])
        away_m = self.region.away_m(self.place, level)
        if away_m > greatest_error_m(accuracy_m):
            from_place_m = math.dist(self.place[:2], (north, east))
            return Refusal(f"it is {from_place_m:.1f} m from its place, outside the region")
        if abs(-down - self.up_m) > HEIGHT_M:
            return Refusal(f"it is {-down:.1f} m above home, not {self.up_m:.1f} m")
        return None


class MarkerTrack:
    """The sightings of one marker.

    Args:
        expected: where the mission says that the marker is.

    Attributes:
        seen_s: when it was last seen; -inf before the first time.
        problem: why the vehicle must not land on it; None if there is no reason.
    """

    def __init__(self, expected: ExpectedMarker) -> None:
        self.seen_s = -math.inf
        self.problem: Refusal | None = None
        self._expected = expected
        self._recent: deque[tuple[float, Ned]] = deque()
        self._strays: deque[float] = deque()
        self._position: Ned | None = None
        self._first: Ned | None = None

    @property
    def position(self) -> Ned | None:
        """Where the marker is, as far as is known; None before it has been seen."""
        return self._position

    def age_s(self, now_s: float) -> float:
        """The time since it was last seen; inf if it never was."""
        return now_s - self.seen_s

    def take(self, seen_s: float, position: Ned, accuracy_m: float) -> Refusal | None:
        """Takes a sighting. Returns why it does not count; None if it does.

        Args:
            seen_s: time of the sighting.
            position: in the mission's frame.
            accuracy_m: standard deviation of the vehicle's own position.
        """
        if refusal := self._expected.why_not(position, accuracy_m):
            return refusal
        self._forget(seen_s)
        off_m = math.dist(position, self._median()) if self._recent else 0.0
        if off_m > STRAY_M and not self._are_strays_the_rule(seen_s):
            return Refusal(f"it is {off_m:.1f} m from where it was just before")
        self._recent.append((seen_s, position))
        if len(self._recent) >= FEWEST:
            self._see(seen_s, accuracy_m)
        return None

    def _see(self, seen_s: float, accuracy_m: float) -> None:
        """Takes the median of the sightings as the marker's position."""
        self.seen_s, self._position = seen_s, self._median()
        self._first = self._first or self._position
        moved_m = math.dist(self._first, self._position)
        if moved_m > MOVED_M + greatest_error_m(accuracy_m):
            moved = Refusal(f"the marker has moved by {moved_m:.1f} m")
            self.problem = self.problem or moved

    def _are_strays_the_rule(self, seen_s: float) -> bool:
        """Takes a stray; if the first sightings were the strays, forgets them and returns true."""
        self._strays.append(seen_s)
        if len(self._strays) <= max(FEWEST, len(self._recent)):
            return False
        if len(self._recent) >= FEWEST:
            self.problem = self.problem or Refusal("the marker was laid elsewhere")
            return False
        self._recent.clear()
        self._strays.clear()
        return True

    def _forget(self, now_s: float) -> None:
        while self._recent and now_s - self._recent[0][0] > WINDOW_S:
            self._recent.popleft()
        while self._strays and now_s - self._strays[0] > WINDOW_S:
            self._strays.popleft()

    def _median(self) -> Ned:
        north, east, down = (
            median(position[axis] for _, position in self._recent) for axis in range(3)
        )
        return (north, east, down)
