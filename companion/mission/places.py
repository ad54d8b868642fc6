"""Where a mission takes place, as values: places, points to look at, and limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from companion.geometry import Ned, NorthEast
from companion.mission.markers import LandingMarker
from companion.mission.python_call import PythonCall
from companion.motion.region import Region


@dataclass(frozen=True, slots=True)
class PointOfInterest:
    """What the vehicle looks at: a place, or a point to which it need not be able to fly.

    Attributes:
        up_m: height above home; for a place, the height of the ground there.
        gimbal: component that also looks at it; None for none.
    """

    name: str
    position: NorthEast
    up_m: float = 0.0
    gimbal: int | None = None


@dataclass(frozen=True, slots=True)
class Place:
    """A named point with a region around it; `at(name)` holds inside the region.

    Attributes:
        heading_rad: the vehicle's heading on arrival, clockwise from north; None for any.
        amsl_m: its altitude above mean sea level, if the mission gives that.
        marker: the marker below it; None if there is none.
        suggesters, tests: installed functions that propose waypoints in it, and judge them.
        found_by: the event that reports where in its region the place is; "" for a place that is
            known from the beginning.
    """

    name: str
    position: Ned
    region: Region
    heading_rad: float | None = None
    amsl_m: float | None = None
    marker: LandingMarker | None = None
    suggesters: tuple[PythonCall, ...] = ()
    tests: tuple[PythonCall, ...] = ()
    found_by: str = ""

    @property
    def inner_m(self) -> float:
        """Radius of the largest disc around the point that the region contains."""
        return self.region.inner_m(self.position)

    @property
    def point(self) -> PointOfInterest:
        """The place as something to look at."""
        return PointOfInterest(self.name, (self.position[0], self.position[1]))


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits that no setpoint exceeds.

    Attributes:
        speed_mps: greatest speed.
        up_m: lowest and highest flight altitude above home.
        fence: polygon of north-east corners.
        keep_out: the polygon of each area that is never entered, by name.
        is_fence_written: whether the mission gives a fence; if not, the map's edge is the fence.
        is_beyond_sight: whether a vehicle with a range finder may fly too fast to stop within the
            distance that it sees.
    """

    speed_mps: float
    up_m: tuple[float, float]
    fence: tuple[NorthEast, ...]
    keep_out: Mapping[str, tuple[NorthEast, ...]] = field(default_factory=dict)
    is_fence_written: bool = True
    is_beyond_sight: bool = False
