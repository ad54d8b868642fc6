"""Checks, before arming, that the autopilot's fence is the mission's, and that it is in force.

The companion's gate keeps to the mission's fence and zones as long as the companion runs. The
autopilot's fence, along the same edges, is a second line: it holds the vehicle whoever flies.
upload_check.py says how it is read and written, and whose fence may be overwritten.

1. A fence and zones that the mission writes under `limits` are uploaded to an autopilot without a
   fence. They also replace one of this companion for another mission, which is reported.
2. After a fence that was just written has been read back, messages of the autopilot are watched for
   LISTEN_S: PX4 accepts a fence and returns all of it, but ignores an area that does not contain
   its home.
3. A fence that is there already is written again, once in each program, because PX4 does not say
   whether it is in force.
4. Whatever fence it is: the autopilot's home, the vehicle and each place of the mission have to lie
   in all its areas, or the mission is refused. kept_fence.py handles the consequences of a fence
   that is kept.
5. It is reported if the vehicle is nearer to an edge than its position error: its estimate may
   wander across in the climb, and the autopilot would then end the flight.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from companion.acting.flight import Flight
from companion.acting.sortie.preflight.arming_terms import UploadPolicy
from companion.acting.sortie.preflight.upload_check import UploadStep
from companion.flight_events.fence import (
    FenceKept,
    FenceMissing,
    FenceNear,
    FenceReplaced,
    FenceWritten,
)
from companion.geofence import FenceArea, FencePolygon, KeptFence, StoredFence
from companion.geometry import NorthEast
from companion.mission.places import Limits, Place
from companion.motion.position_error import greatest_error_m
from companion.outcomes import Failed
from companion.vehicle.ports.stores import AutopilotFence

LISTEN_S = 2.0
DIRECTIONS = 16
"""The number of directions in which the distance to an edge is measured."""


class FenceJudge:
    """Implements `upload_check.UploadJudge` for the fence.

    Args:
        flight: the flight whose autopilot is asked.
        policy: what the operator has decided.
        places: the mission's places.

    Attributes:
        kept: somebody else's fence that stays; None if there is none.
    """

    is_asked = True

    def __init__(self, flight: Flight, policy: UploadPolicy, places: Sequence[Place]) -> None:
        self._flight = flight
        self._policy = policy
        self._places = places
        self._wanted = areas_of(flight.limits)
        self.kept: StoredFence | None = None
        self._replaced: StoredFence | None = None
        self._silent_from_s = 0.0

    @property
    def store(self) -> AutopilotFence:
        """The autopilot's store of fences."""
        return self._flight.vehicle.fence

    def nowhere(self, reason: str) -> None:
        """Reports that only the gate holds the vehicle inside."""
        self._flight.report(FenceMissing(reason))

    def unanswered(self, failed: Failed) -> Failed:
        """Why the mission is refused, with what to do."""
        return Failed(f"{failed.reason}\n    --autopilot-fence none leaves it alone")

    def judge(self) -> UploadStep | Failed:
        """Keeps the fence that is there, or writes the required one; rules 1 and 3."""
        stored = self.store.stored
        if stored is None:
            return Failed("it is not known where on the earth the autopilot's fence lies")
        if self._policy is UploadPolicy.KEEP or not self._wanted:
            return self._keep(stored)
        is_ours = self._is_wanted(stored)
        if is_ours and self.store.is_vouched_for():
            return self._keep(stored)
        if stored.points and not is_ours:
            if self._policy is not UploadPolicy.REPLACE and not self.store.is_own():
                return Failed(_another(stored))
            self._replaced = stored
        if why_not := self._outside(self._wanted, "the mission's fence"):
            return why_not
        self.store.write(self._wanted)
        return UploadStep.UNFIT

    def compare(self) -> Failed | None:
        """Why the fence that was read back is a different one; None if it is the same."""
        stored = self.store.stored
        if not self.store.is_as_written() and not self._is_wanted(stored):
            return Failed(
                f"the autopilot has taken the mission's fence, but reports another one ({stored})"
            )
        self._silent_from_s = self._flight.now_s
        return None

    def listen(self) -> UploadStep | Failed | None:
        """Rules 2 and 4; the autopilot's home may have become known meanwhile."""
        fence, now_s = self.store, self._flight.now_s
        if objections := fence.objections:
            return Failed(
                f"the autopilot has taken the mission's fence, and leaves a part of it out: "
                f"{'; '.join(objections)}\n    set its home where the vehicle stands"
            )
        if now_s - self._silent_from_s < LISTEN_S:
            return None
        if why_not := self._outside(self._wanted, "the mission's fence"):
            return why_not
        fence.vouch()
        words = str(fence.stored)
        if self._replaced is not None:
            self._flight.report(FenceReplaced(words, str(self._replaced)))
        else:
            self._flight.report(FenceWritten(words))
        self._tell_if_near(self._wanted)
        return UploadStep.UNOPPOSED

    def _is_wanted(self, stored: StoredFence | None) -> bool:
        """Whether a fence is the mission's, as PX4 stores it."""
        return stored is not None and stored.consists_of(self._wanted)

    def _keep(self, stored: StoredFence) -> UploadStep | Failed:
        """Keeps the fence that is there, if the mission can be flown in it."""
        if stored.flaw is not None:
            return Failed(f"the vehicle's fence ({stored}) is not as it was meant: {stored.flaw}")
        if why_not := self._outside(stored.areas, "the vehicle's own fence"):
            return why_not
        if stored.points:
            is_ours = stored.consists_of(self._wanted)
            self.kept = None if is_ours else stored
            others = KeptFence.of(() if is_ours else stored.areas)
            within, keep_out = _rounded(others.within), _rounded(others.keep_out)
            self._flight.report(FenceKept(str(stored), within=within, keep_out=keep_out))
            self._tell_if_near(stored.areas)
        else:
            self._flight.report(FenceMissing("it has none, and none is asked for"))
        return UploadStep.KEPT

    def _tell_if_near(self, areas: Sequence[FenceArea]) -> None:
        """Rule 5."""
        state = self._flight.vehicle.state
        if state is None:
            return
        error_m = greatest_error_m(state.motion.accuracy_m)
        north_m, east_m, _ = state.motion.position
        angles = (math.tau * number / DIRECTIONS for number in range(DIRECTIONS))
        around = [
            (north_m + error_m * math.cos(angle), east_m + error_m * math.sin(angle))
            for angle in angles
        ]
        if not all(area.allows(point) for area in areas for point in around):
            self._flight.report(FenceNear(round(error_m, 1)))

    def _outside(self, areas: Sequence[FenceArea], whose: str) -> Failed | None:
        """Why the mission cannot be flown in a fence; rule 4. None if it can."""
        state, home = self._flight.vehicle.state, self._flight.vehicle.fence.home
        points: list[tuple[str, NorthEast]] = []
        if home is not None:
            points.append(("the autopilot's home", home))
        if state is not None:
            points.append(("the vehicle", state.motion.position[:2]))
        points += [(place.name, place.position[:2]) for place in self._places]
        for name, point in points:
            for number, area in enumerate(areas, 1):
                if not area.allows(point):
                    where = "outside" if area.is_inclusion else "inside a zone of"
                    return Failed(f"{name} lies {where} {whose} (area {number} of {len(areas)})")
        return None


def areas_of(limits: Limits) -> tuple[FenceArea, ...]:
    """The areas that a mission writes; none if only its map says how far it may fly."""
    zones = (FenceArea(FencePolygon(corners), False) for corners in limits.keep_out.values())
    fence = (FenceArea(FencePolygon(limits.fence), True),) if limits.is_fence_written else ()
    return (*fence, *zones)


def _another(stored: StoredFence) -> str:
    replaced = "\n    --autopilot-fence replace puts the mission's in its place"
    if stored.flaw is not None:
        return f"the vehicle has another fence ({stored}): {stored.flaw}{replaced}"
    kept = "\n    --autopilot-fence keep flies within it, beside the mission's own"
    return f"the vehicle has another fence ({stored}){kept}{replaced}"


def _rounded(polygons: Iterable[Sequence[NorthEast]]) -> tuple[tuple[NorthEast, ...], ...]:
    """Polygons with their corners rounded to a millimetre."""
    return tuple(
        tuple((round(north, 3), round(east, 3)) for north, east in corners) for corners in polygons
    )
