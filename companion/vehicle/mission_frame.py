"""Where the mission's frame lies in the autopilot's local frame.

Its origin is the home position: at first that of the first HOME_POSITION heard. That is one sample
of an estimate, and PX4 takes another one when it arms; both are off by what the estimate wanders.
So the frame settles before the first sortie: the vehicle stands where the mission begins, and the
mean of where it is heard to stand is laid there. After that the frame is kept for good, whatever
HOME_POSITION says: the walls of the map do not move where the vehicle lands and arms again. Only
what the vehicle sees of these walls moves it, by what the position is wrong by (surroundings.py).
"""

from __future__ import annotations

from companion.geometry import Ned, NorthEast, distance, horizontal_distance

SETTLING_S = 10.0
"""Time over which the standing vehicle's position is averaged."""
SETTLED_M = 0.05
"""A vehicle this near to where it should stand moves no frame."""
EXACT_M = 0.1
"""A position that is as good as this is not averaged."""
MOVED_M = 1.0
"""A jump from the mean: the vehicle was carried there, and the averaging begins anew."""


class MissionFrame:
    """The origin of the mission's frame.

    Attributes:
        origin: in the autopilot's local frame; None until a home position was heard.
        altitude_m: of the origin above mean sea level.
    """

    def __init__(self) -> None:
        self.origin: Ned | None = None
        self.altitude_m = 0.0
        self._laid: Ned | None = None
        self._mean: Ned | None = None
        self._since_s = self._heard_s = 0.0
        self._newest: Ned = (0.0, 0.0, 0.0)

    def take_home(self, home: Ned, altitude_m: float) -> None:
        """Takes a HOME_POSITION; the first alone counts."""
        if self.origin is None:
            self.origin, self.altitude_m = home, altitude_m

    def take_position(self, now_s: float, local: Ned, is_standing: bool) -> None:
        """Takes a position in the autopilot's local frame."""
        if not is_standing:
            self._mean = None
        elif self._mean is None or distance(local, self._mean) > MOVED_M:
            self._mean, self._since_s = local, now_s
        elif now_s > self._since_s:
            share = (now_s - self._heard_s) / min(now_s - self._since_s, SETTLING_S)
            self._mean = _between(self._mean, local, min(share, 1.0))
        self._heard_s, self._newest = now_s, local

    def gap_m(self, place: Ned, accuracy_m: float) -> float | None:
        """How far from a place the vehicle stands; None until that is certain.

        Args:
            place: in the mission's frame.
            accuracy_m: of the position, as the autopilot tells it.
        """
        if self._mean is None or self.origin is None:
            return None
        north, east, _ = self.origin
        there = (north + place[0], east + place[1], 0.0)
        is_there = accuracy_m <= EXACT_M and all(
            horizontal_distance(each, there) <= SETTLED_M for each in (self._mean, self._newest)
        )
        if not is_there and self._heard_s - self._since_s < SETTLING_S:
            return None
        return horizontal_distance(self._mean, there)

    def lay(self, place: Ned) -> None:
        """The vehicle stands at a place: moves the frame so that this is so, the first time."""
        if self._laid is not None or self._mean is None or self.origin is None:
            return
        origin = (self._mean[0] - place[0], self._mean[1] - place[1], self._mean[2])
        if distance(origin, self.origin) > SETTLED_M:
            self.altitude_m -= origin[2] - self.origin[2]
            self.origin = origin
        self._laid = self.origin

    def keep(self, origin: Ned, altitude_m: float) -> None:
        """The frame is where it was laid in this flight, by another process."""
        self.origin = self._laid = origin
        self.altitude_m = altitude_m

    def move(self, by: NorthEast, most_m: float) -> None:
        """Positions in the frame become greater by so much; not before it is laid.

        Args:
            by: north and east.
            most_m: greatest distance from where it was laid.
        """
        if self._laid is None or self.origin is None:
            return
        north, east, down = self.origin
        moved = (north - by[0], east - by[1], down)
        if horizontal_distance(moved, self._laid) <= most_m:
            self.origin = moved


def _between(start: Ned, end: Ned, share: float) -> Ned:
    return (
        start[0] + share * (end[0] - start[0]),
        start[1] + share * (end[1] - start[1]),
        start[2] + share * (end[2] - start[2]),
    )
