"""Converts positions between the mission's frame and the autopilot's local frame.

A mission in metres: its origin is the home position, at first that of the first HOME_POSITION
heard. That is one sample of an estimate. PX4 takes another sample when it arms, and both are off by
as much as the estimate wanders. So the frame settles before the first sortie: it is laid so that
the place where the mission begins lies at the mean of the vehicle's positions while it stands
there. From then on the frame is kept, whatever HOME_POSITION says: the walls of the map do not move
when the vehicle lands and arms again, nor when another run of the program continues
(laid_frames.py). Only what the vehicle sees of these walls moves the frame, by the error of its
position (surroundings.py).

A mission in latitude and longitude: the file gives its origin (its anchor). Its height is that of
the standing vehicle when the mission begins. Positions are converted by way of the earth, as the
projections around two points differ by more than a shift. This needs the origin of the autopilot's
local frame (origin_watch.py).

If the autopilot moves its origin, in flight or on the ground, the mission's frame stays where it is
on the earth. Directions are not turned: between two origins 10 km apart they differ by 0.16 degrees
at a latitude of 60.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from companion.geometry import GlobalOrigin, Ned, NorthEast, distance, horizontal_distance
from companion.motion.position_error import EXACT_M

SETTLING_S = 10.0
"""Time over which the position of the standing vehicle is averaged."""
SETTLED_M = 0.05
"""If the vehicle stands this close to where it should, the frame is not moved."""
MOVED_M = 1.0
"""A jump this far from the mean: the vehicle was carried, and averaging starts anew."""


@dataclass(frozen=True, slots=True)
class LaidHome:
    """Where the frame of missions in metres was laid.

    Attributes:
        local: its origin, in the autopilot's local frame.
        altitude_m: of that origin, above mean sea level.
        reference: where the local frame was on the earth; None if not known.
    """

    local: Ned
    altitude_m: float
    reference: GlobalOrigin | None


class MissionFrame:
    """The mission's frame.

    Attributes:
        altitude_m: of its origin, above mean sea level.
        anchor: where its origin is on the earth, if the mission says so.
        reference: where the origin of the autopilot's local frame is on the earth; None until
            known.
        is_laid: whether a frame in metres is where it will stay.
    """

    def __init__(self) -> None:
        self.altitude_m = 0.0
        self.anchor: GlobalOrigin | None = None
        self.reference: GlobalOrigin | None = None
        self._home: Ned | None = None  # of a mission in metres: its origin, but for the shift
        self._shift: NorthEast = (0.0, 0.0)
        self.is_laid = self._is_recalled = False
        self._mean: Ned | None = None
        self._since_s = self._heard_s = 0.0
        self._newest: Ned = (0.0, 0.0, 0.0)

    @property
    def is_known(self) -> bool:
        """Whether positions can be converted."""
        return self._home is not None and (self.anchor is None or self.reference is not None)

    @property
    def is_home_known(self) -> bool:
        """Whether a HOME_POSITION was heard."""
        return self._home is not None

    @property
    def origin(self) -> Ned | None:
        """Its origin in the autopilot's local frame; None until known."""
        return self.local((0.0, 0.0, 0.0)) if self.is_known else None

    def position(self, local: Ned) -> Ned:
        """Converts a position from the autopilot's local frame to the mission's."""
        north, east, down = self._unshifted(local)
        return (north + self._shift[0], east + self._shift[1], down)

    def local(self, position: Ned) -> Ned:
        """Converts a position from the mission's frame to the autopilot's local frame."""
        north, east, down = position
        there = (north - self._shift[0], east - self._shift[1], down)
        if self.anchor is not None and self.reference is not None:
            return self.reference.to_local(*self._on_earth(self.anchor).to_global(there))
        assert self._home is not None
        return _sum(self._home, there)

    def _unshifted(self, local: Ned) -> Ned:
        if self.anchor is not None and self.reference is not None:
            return self._on_earth(self.anchor).to_local(*self.reference.to_global(local))
        assert self._home is not None
        north, east, down = self._home
        return (local[0] - north, local[1] - east, local[2] - down)

    def _on_earth(self, anchor: GlobalOrigin) -> GlobalOrigin:
        return replace(anchor, altitude_m=self.altitude_m)

    @property
    def zero(self) -> GlobalOrigin | None:
        """Where its origin is on the earth; None if not known."""
        if self.reference is None or not self.is_known:
            return None
        return GlobalOrigin(*self.reference.to_global(self.local((0.0, 0.0, 0.0))))

    def on_earth(self, point: NorthEast) -> tuple[float, float] | None:
        """Latitude and longitude of a point, by the autopilot's projection; None if not known."""
        if self.reference is None or not self.is_known:
            return None
        return self.reference.to_global(self.local((*point, 0.0)))[:2]

    def from_earth(self, latitude_deg: float, longitude_deg: float) -> NorthEast | None:
        """North and east of a point on the earth, the reverse of `on_earth`; None if not known."""
        if self.reference is None or not self.is_known:
            return None
        there = self.reference.to_local(latitude_deg, longitude_deg, self.reference.altitude_m)
        return self.position(there)[:2]

    def anchor_at(self, anchor: GlobalOrigin | None) -> None:
        """Begins a mission with this origin; None if the mission begins where the vehicle
        stands."""
        if anchor != self.anchor:
            self.anchor, self._shift = anchor, (0.0, 0.0)

    def take_home(self, home: Ned, altitude_m: float) -> None:
        """Takes a HOME_POSITION; only the first one counts."""
        if self._home is None:
            self._home, self.altitude_m = home, altitude_m

    def take_reference(self, reference: GlobalOrigin) -> None:
        """Takes where the autopilot's local frame is on the earth; home is converted to the new
        frame.
        """
        before, self.reference = self.reference, reference
        if before is not None:
            self._mean = None
            if self._home is not None:
                self._home = reference.to_local(*before.to_global(self._home))

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
            accuracy_m: of the position, as the autopilot reports it.
        """
        if self._mean is None or not self.is_known:
            return None
        stands = (self._mean, self._newest)
        gaps_m = [horizontal_distance(self.position(each), place) for each in stands]
        is_there = accuracy_m <= EXACT_M and max(gaps_m) <= SETTLED_M
        if not is_there and self.is_settling:
            return None
        return gaps_m[0]

    @property
    def is_settling(self) -> bool:
        """Whether the vehicle's position has been averaged for too short a time."""
        return self._mean is not None and self._heard_s - self._since_s < SETTLING_S

    def lay(self, place: Ned) -> None:
        """Moves the frame so that the vehicle stands at a place, when a sortie begins.

        A frame in metres is moved only the first time. For one that lies where the file says, only
        the height is set, each time: the height by GPS drifts by metres in an hour.
        """
        if self._mean is None or not self.is_known:
            return
        if self.anchor is not None and self.reference is not None:
            self.altitude_m = self.reference.altitude_m - self._mean[2]
        elif not self.is_laid and self._home is not None:
            home = (self._mean[0] - place[0], self._mean[1] - place[1], self._mean[2])
            if distance(home, self._home) > SETTLED_M:
                self.altitude_m -= home[2] - self._home[2]
                self._home = home
            self.is_laid = True

    @property
    def laid(self) -> LaidHome | None:
        """Where it was laid; None if the file says where it lies."""
        if self.anchor is not None or self._home is None or not self.is_laid:
            return None
        return LaidHome(self._home, self.altitude_m, self.reference)

    @property
    def is_fixed(self) -> bool:
        """Whether it lies where it does, wherever the vehicle stands when a sortie begins."""
        return self.is_laid or self.anchor is not None

    @property
    def is_recalled(self) -> bool:
        """Whether the frame is the one that another run of the program has laid."""
        return self._is_recalled and self.anchor is None

    def recall(self, laid: LaidHome) -> None:
        """Lays the frame where another run of the program had laid it."""
        self.keep(laid.local, laid.altitude_m)
        self._is_recalled = True
        if laid.reference is None:
            return
        if self.reference is None:
            self.reference = laid.reference
        else:
            self._home = self.reference.to_local(*laid.reference.to_global(laid.local))

    def keep(self, origin: Ned, altitude_m: float) -> None:
        """Lays the frame where another process has laid it in this flight."""
        self._home, self.altitude_m, self.is_laid = origin, altitude_m, True

    def move(self, by: NorthEast, most_m: float) -> None:
        """Adds a shift to all positions in the frame, once the frame is fixed.

        Args:
            by: north and east.
            most_m: greatest distance of the frame from where it was laid.
        """
        shift = (self._shift[0] + by[0], self._shift[1] + by[1])
        if self.is_fixed and math.hypot(*shift) <= most_m:
            self._shift = shift


def _sum(a: Ned, b: Ned) -> Ned:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _between(start: Ned, end: Ned, share: float) -> Ned:
    return (
        start[0] + share * (end[0] - start[0]),
        start[1] + share * (end[1] - start[1]),
        start[2] + share * (end[2] - start[2]),
    )
