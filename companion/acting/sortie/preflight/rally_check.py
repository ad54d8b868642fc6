"""Checks, before arming, that the autopilot's rally points are the mission's safe places.

If the companion fails, or a pilot or a failsafe chooses Return, the autopilot lands at the nearest
of them and home. upload_check.py says how they are read and written, and whose may be overwritten.

1. The places under `otherwise: {land_at: ...}`, other than where the mission begins, are written
   with the altitude of the ground, because an autopilot lands there. They replace those of this
   companion for another mission, which is reported. Points of others at the same positions are
   written again, because the frame in which they were sent cannot be read back, and PX4's Return
   may not know it.
2. A mission without such places writes none, and removes those that this companion wrote for
   another mission. Points of others are not examined, and an autopilot is not asked if this
   companion cannot have written any to it.
3. Points that are kept have to lie in the mission's fence, and outside all its zones.
4. Points that the autopilot's Return will not use are reported: PX4 uses none with RTL_TYPE 2 and
   4, and none near its home. The mission begins all the same, because its own landing uses them.

Source: PX4 1.16, src/modules/navigator/rtl.cpp (findRtlDestination).
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.sortie.preflight.arming_terms import UploadPolicy
from companion.acting.sortie.preflight.fence_check import areas_of
from companion.acting.sortie.preflight.upload_check import UploadStep
from companion.flight_events.rally import (
    RallyKept,
    RallyMissing,
    RallyRemoved,
    RallyReplaced,
    RallyUnused,
    RallyWritten,
)
from companion.geometry import horizontal_distance
from companion.mission.model import Mission
from companion.mission.otherwise import LandAtSafePlace
from companion.mission.places import Place
from companion.outcomes import Failed
from companion.rally_points import RallyPoint, StoredRally
from companion.vehicle.ports.stores import AutopilotRally

NEAR_HOME_M = 10.0
"""PX4 ignores a rally point that is no further than this from home."""
RETURN_TYPE, WITHOUT_RALLY, WITHOUT_HOME = "RTL_TYPE", (2.0, 4.0), 1.0
ANSWER_S = 3.0
"""How long the autopilot may take to send that parameter."""


class RallyJudge:
    """Implements `upload_check.UploadJudge` for the rally points.

    Args:
        flight: the flight whose autopilot is asked.
        policy: what the operator has decided.
        mission: the mission with the safe places.
    """

    def __init__(self, flight: Flight, policy: UploadPolicy, mission: Mission) -> None:
        self._flight, self._policy, self._home = flight, policy, mission.home
        self._safe = rally_places(mission)
        self._wanted = tuple(RallyPoint(place.position[:2]) for place in self._safe)
        self._names = ", ".join(place.name for place in self._safe)
        self._replaced: StoredRally | None = None
        self._asked_s: float | None = None

    @property
    def store(self) -> AutopilotRally:
        """The autopilot's store of rally points."""
        return self._flight.vehicle.rally

    @property
    def is_asked(self) -> bool:
        """Rule 2."""
        replaces = self._policy is UploadPolicy.REPLACE
        return bool(self._wanted) or replaces or self.store.has_written

    def nowhere(self, reason: str) -> None:
        """Reports that only the companion lands there."""
        if self._wanted:
            self._flight.report(RallyMissing(reason))

    def unanswered(self, failed: Failed) -> Failed | None:
        """Why the mission is refused; None if it has no rally points, so that none are needed."""
        if self._wanted:
            return _advised(failed.reason)
        self._flight.report(RallyMissing(failed.reason))
        return None

    def judge(self) -> UploadStep | Failed | None:
        """Keeps the points that are there, or writes the required ones; rules 1 and 2."""
        stored = self.store.stored
        if stored is None:
            return _advised("it is not known where on the earth the autopilot's rally points lie")
        if not self._wanted:
            return self._take_away(stored)
        if not self._knows_return_type:
            return None
        is_there = stored.consists_of(self._wanted)
        is_keeping = self._policy is UploadPolicy.KEEP
        if is_there and (is_keeping or self.store.is_own()):
            self._flight.report(RallyKept(f"its rally points at {self._names}"))
            self._tell_unused()
            return UploadStep.KEPT
        if is_keeping:
            return self._keep(stored)
        if stored.points and not is_there:
            if self._policy is not UploadPolicy.REPLACE and not self.store.is_own():
                return Failed(_others(stored))
            self._replaced = stored
        self.store.write(self._wanted)
        return UploadStep.UNFIT

    def compare(self) -> Failed | None:
        """Why the points that were read back are different; None if they are the same."""
        stored = self.store.stored
        is_wanted = stored is not None and stored.consists_of(self._wanted)
        if not self.store.is_as_written() and not is_wanted:
            return _advised(
                f"the autopilot has taken the mission's rally points, but reports others ({stored})"
            )
        return None

    def listen(self) -> UploadStep:
        """PX4 reports nothing about them; rule 4."""
        before = str(self._replaced)
        if not self._wanted:
            self._flight.report(RallyRemoved(before))
        elif self._replaced is not None:
            self._flight.report(RallyReplaced(self._names, before))
        else:
            self._flight.report(RallyWritten(self._names))
        self._tell_unused()
        return UploadStep.UNOPPOSED

    def _take_away(self, stored: StoredRally) -> UploadStep:
        """Rule 2."""
        is_ours = self._policy is UploadPolicy.REPLACE or self.store.is_own()
        if not stored.points or self._policy is UploadPolicy.KEEP or not is_ours:
            return UploadStep.KEPT
        self._replaced = stored
        self.store.write(())
        return UploadStep.UNFIT

    def _keep(self, stored: StoredRally) -> UploadStep | Failed:
        """Rule 3."""
        areas = areas_of(self._flight.limits)
        for number, point in enumerate(stored.points, 1):
            if not all(area.allows(point.position) for area in areas):
                count = len(stored.points)
                what = f"rally point {number} of {count} of the vehicle lies outside the mission's"
                return Failed(f"{what} fence, or in a zone{_REPLACED}{_LEFT_ALONE}")
        if stored.points:
            self._flight.report(RallyKept(str(stored)))
        else:
            self._flight.report(RallyMissing("it has none, and none are asked for"))
        return UploadStep.KEPT

    @property
    def _knows_return_type(self) -> bool:
        """Whether the autopilot has said where its Return goes, or has failed to answer."""
        if self._asked_s is None:
            self._asked_s = self._flight.now_s
        is_late = self._flight.now_s - self._asked_s > ANSWER_S
        return self._flight.vehicle.parameters.read(RETURN_TYPE) is not None or is_late

    def _tell_unused(self) -> None:
        """Rule 4."""
        value = self._flight.vehicle.parameters.read(RETURN_TYPE) if self._wanted else None
        if value in WITHOUT_RALLY:
            reason = f"{RETURN_TYPE} is {value:g}; set 0 for home and rally points"
            self._flight.report(RallyUnused(self._names, reason))
            return
        if value == WITHOUT_HOME:
            reason = f"{RETURN_TYPE} is 1, for rally points alone; set 0 for both"
            self._flight.report(RallyUnused(self._home.name, reason))
        home = self._home.position
        near = [p for p in self._safe if horizontal_distance(p.position, home) <= NEAR_HOME_M]
        if near:
            reason = f"PX4 ignores what lies within {NEAR_HOME_M:g} m of home"
            self._flight.report(RallyUnused(", ".join(p.name for p in near), reason))


def rally_places(mission: Mission) -> tuple[Place, ...]:
    """The safe places of a mission, except the one to which the autopilot returns anyway."""
    if not isinstance(mission.otherwise, LandAtSafePlace):
        return ()
    names = (name for name in mission.otherwise.places if name != mission.home.name)
    return tuple(mission.places[name] for name in names)


_REPLACED = "\n    --rally-points replace puts the mission's in their place"
_LEFT_ALONE = "\n    --rally-points none leaves them alone"


def _others(stored: StoredRally) -> str:
    kept = "\n    --rally-points keep flies with them; the companion lands at the mission's"
    flaw = f": {stored.flaw}" if stored.flaw is not None else ""
    return f"the vehicle has {stored} of somebody else{flaw}{kept}{_REPLACED}"


def _advised(reason: str) -> Failed:
    return Failed(f"{reason}{_LEFT_ALONE}")
