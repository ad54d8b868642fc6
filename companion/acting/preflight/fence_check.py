"""The autopilot's fence, before arming: it is the mission's, and it is in force.

The companion's gate keeps to the mission's fence and zones as long as the companion lives. The
autopilot's fence, along the same edges, is the net behind it: it holds the vehicle whoever flies.
How it is read and written, and whose may be overwritten, is in upload_check.py.

1. What the mission writes under `limits`, a fence and zones, is put into an autopilot that has no
   fence. One that is this companion's own, of another mission, gives way to it, which is told.
2. After one that has just been written was read back, what the autopilot says is listened to for
   LISTEN_S: PX4 takes a fence, reads it back whole, and leaves out an area that does not hold its
   home.
3. One that is there already is written again, once in each program: PX4 does not say whether a
   fence that it has is in force.
4. Whatever fence it is: the autopilot's home, the vehicle and each place of the mission lie in
   every area of it, or the mission is refused. What follows from one that is kept is for
   kept_fence.py.
5. A vehicle that stands nearer to an edge than its position may be off by is told of: its estimate
   may wander across in the climb, and the autopilot then ends the flight.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from companion.acting.flight import Flight
from companion.acting.preflight.arming_terms import UploadPolicy
from companion.acting.preflight.upload_check import UploadStep
from companion.flight_events.fence import (
    FenceKept,
    FenceMissing,
    FenceNear,
    FenceReplaced,
    FenceWritten,
)
from companion.geofence import FenceArea, FencePolygon, KeptFence, StoredFence, are_alike
from companion.geometry import NorthEast
from companion.mission.model import Limits, Place
from companion.motion.position_error import greatest_error_m
from companion.vehicle.port import Failed
from companion.vehicle.store_port import AutopilotFence

ALIKE_M = 0.2
"""Corners that are nearer to each other are the same; the protocol rounds to a centimetre."""
LISTEN_S = 2.0
DIRECTIONS = 16
"""In which it is looked how near an edge is."""


class FenceJudge:
    """Fulfils `upload_check.UploadJudge` for the fence.

    Args:
        flight: whose autopilot is asked.
        policy: what the operator has said.
        places: of the mission.

    Attributes:
        kept: the fence of somebody else that stays; None without one.
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
        """Where it is stored."""
        return self._flight.vehicle.fence

    def nowhere(self, reason: str) -> None:
        """The gate alone holds the vehicle inside."""
        self._flight.report(FenceMissing(reason))

    def unanswered(self, failed: Failed) -> Failed:
        """The mission is refused, with the way out."""
        return Failed(f"{failed.reason}\n    --autopilot-fence none leaves it alone")

    def judge(self) -> UploadStep | Failed:
        """What is there is kept, or what is wanted is written; rules 1 and 3."""
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
        """Why what was read back is another fence."""
        stored = self.store.stored
        if not self.store.is_as_written() and not self._is_wanted(stored):
            return Failed(
                f"the autopilot has taken the mission's fence, and tells another one ({stored})"
            )
        self._silent_from_s = self._flight.now_s
        return None

    def listen(self) -> UploadStep | Failed | None:
        """Rules 2 and 4; the autopilot's home may have come meanwhile."""
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
        """Whether a fence is the mission's, as PX4 takes it."""
        return (
            stored is not None
            and stored.flaw is None
            and are_alike(stored.areas, self._wanted, ALIKE_M)
        )

    def _keep(self, stored: StoredFence) -> UploadStep | Failed:
        """The fence that is there stays, if the mission can be flown in it."""
        if stored.flaw is not None:
            return Failed(f"the vehicle's fence ({stored}) is not as it was meant: {stored.flaw}")
        if why_not := self._outside(stored.areas, "the vehicle's own fence"):
            return why_not
        if stored.points:
            is_ours = are_alike(stored.areas, self._wanted, ALIKE_M)
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
        error_m, (north_m, east_m) = greatest_error_m(state.accuracy_m), state.position[:2]
        angles = (math.tau * number / DIRECTIONS for number in range(DIRECTIONS))
        around = [
            (north_m + error_m * math.cos(angle), east_m + error_m * math.sin(angle))
            for angle in angles
        ]
        if not all(area.allows(point) for area in areas for point in around):
            self._flight.report(FenceNear(round(error_m, 1)))

    def _outside(self, areas: Sequence[FenceArea], whose: str) -> Failed | None:
        """Why the mission cannot be flown in a fence; rule 4."""
        state, home = self._flight.vehicle.state, self._flight.vehicle.fence.home
        points: list[tuple[str, NorthEast]] = []
        if home is not None:
            points.append(("the autopilot's home", home))
        if state is not None:
            points.append(("the vehicle", state.position[:2]))
        points += [(place.name, place.position[:2]) for place in self._places]
        for name, point in points:
            for number, area in enumerate(areas, 1):
                if not area.allows(point):
                    where = "outside" if area.is_inclusion else "inside a zone of"
                    return Failed(f"{name} lies {where} {whose} (area {number} of {len(areas)})")
        return None


def areas_of(limits: Limits) -> tuple[FenceArea, ...]:
    """The areas that a mission writes; none where its map alone says how far it may fly."""
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
    """To a millimetre."""
    return tuple(
        tuple((round(north, 3), round(east, 3)) for north, east in corners) for corners in polygons
    )
