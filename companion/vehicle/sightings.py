"""Converts what another program has seen to a position, by where the vehicle was at that time.

A detector evaluates a picture, and reports later. It reports how far ahead and to the right of the
vehicle something is, with the time of the picture by the machine's monotonic clock
(`time.monotonic_ns()` in Python); without a time, it was seen now. So the vehicle's poses of the
last HISTORY_S are kept. A detector that knows latitude and longitude reports these instead.

Directions are those of a level vehicle. The height of the thing is not reported: the mission
determines at what height a place is flown to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.geometry import GlobalOrigin, NorthEast
from companion.outcomes import Refusal
from companion.vehicle.ports.state import VehicleState
from companion.vehicle.poses import Pose, PoseHistory

HISTORY_S = 10.0
AHEAD_S = 0.1
"""A picture may be newer than the newest pose by this much."""
SILENT_S = 1.0
"""If there was no pose for longer, the vehicle's position is unknown."""
FAR_M = 200.0
"""Beyond this distance a sighting is too inaccurate: one degree is 3.5 m there."""


@dataclass(frozen=True, slots=True)
class SeenFromVehicle:
    """Something ahead and to the right of the vehicle.

    Attributes:
        monotonic_ns: when it was seen, by the machine's clock; None for now.
    """

    forward_m: float
    right_m: float
    monotonic_ns: float | None


@dataclass(frozen=True, slots=True)
class SeenOnEarth:
    """Something at a latitude and a longitude, degrees."""

    lat_deg: float
    lon_deg: float


Sighting = SeenFromVehicle | SeenOnEarth


def sighting_of(report: dict[str, object]) -> Sighting | Refusal:
    """The position in a report, or why it contains none.

    >>> sighting_of({"forward_m": 4, "right_m": -1.5})
    SeenFromVehicle(forward_m=4.0, right_m=-1.5, monotonic_ns=None)
    """
    numbers: dict[str, float] = {}
    for key, value in report.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            return Refusal(f"{key[:20]} is not a number")
        try:
            numbers[key] = float(value)
        except OverflowError:
            return Refusal(f"{key[:20]} is not a number")
        if not math.isfinite(numbers[key]):
            return Refusal(f"{key[:20]} is not a number")
    keys = set(numbers)
    if keys == {"lat_deg", "lon_deg"}:
        return SeenOnEarth(numbers["lat_deg"], numbers["lon_deg"])
    if {"forward_m", "right_m"} <= keys <= {"forward_m", "right_m", "monotonic_ns"}:
        return SeenFromVehicle(
            numbers["forward_m"], numbers["right_m"], monotonic_ns=numbers.get("monotonic_ns")
        )
    return Refusal(
        "a position is forward_m and right_m, perhaps with monotonic_ns; or lat_deg, lon_deg"
    )


class Sightings:
    """The poses of one flight, to place what was seen."""

    def __init__(self) -> None:
        self._poses = PoseHistory(HISTORY_S)

    def follow(self, state: VehicleState | None) -> None:
        """Stores the present pose; once a tick."""
        newest_s = self._poses.newest_s
        if state is None or (newest_s is not None and state.motion.measured_s <= newest_s):
            return
        self._poses.add(
            state.motion.measured_s, Pose(state.motion.position, (0.0, 0.0, state.attitude.yaw_rad))
        )

    def locate(
        self, sighting: Sighting, now_s: float, zero_s: float | None, zero: GlobalOrigin | None
    ) -> NorthEast | Refusal:
        """Where it is in the mission's frame, or why that is not known.

        Args:
            sighting: what was seen.
            now_s: the flight's time.
            zero_s: what the machine's clock showed when the flight's showed 0; None in lockstep.
            zero: where the mission's frame is on the earth, if known.
        """
        match sighting:
            case SeenOnEarth(lat_deg=latitude, lon_deg=longitude):
                if zero is None:
                    return Refusal("the autopilot has not said where on the earth it is")
                if not (abs(latitude) <= 90 and abs(longitude) <= 180):
                    return Refusal(f"{latitude:g}, {longitude:g} is not a latitude and longitude")
                return zero.to_local(latitude, longitude, zero.altitude_m)[:2]
            case SeenFromVehicle(forward_m=forward_m, right_m=right_m, monotonic_ns=stamp_ns):
                if math.hypot(forward_m, right_m) > FAR_M:
                    return Refusal(f"it is more than {FAR_M:g} m from the vehicle")
                seen_s = now_s if stamp_ns is None else stamp_ns / 1e9 - (zero_s or 0.0)
                pose = self._pose(seen_s, now_s)
                if isinstance(pose, Refusal):
                    return pose
                (north, east, _), (_, _, yaw_rad) = pose
                cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
                north += forward_m * cos - right_m * sin
                return (north, east + forward_m * sin + right_m * cos)

    def _pose(self, seen_s: float, now_s: float) -> Pose | Refusal:
        """The vehicle's pose at a time, or why it is not known."""
        oldest_s, newest_s = self._poses.oldest_s, self._poses.newest_s
        pose = self._poses.at(seen_s)
        if oldest_s is None or newest_s is None or pose is None or now_s - newest_s > SILENT_S:
            return Refusal("where the vehicle is, is not known")
        if seen_s > now_s + AHEAD_S:
            return Refusal(
                f"its time is {seen_s - now_s:.1f} s ahead: monotonic_ns is CLOCK_MONOTONIC"
            )
        if seen_s < oldest_s - AHEAD_S:
            return Refusal(
                f"it is {now_s - seen_s:.1f} s old, and poses are kept for {HISTORY_S:g} s"
            )
        return pose
