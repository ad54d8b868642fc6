"""All checks before arming: charge, failsafes, fence, rally points.

Before them, a warning about docks is reported.
"""

from __future__ import annotations

from companion.acting.executive import Executive
from companion.acting.flight import Flight
from companion.acting.sortie.flight_limit import LimitWatch
from companion.acting.sortie.low_battery import why_not_armed
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import SortieEvent
from companion.acting.sortie.preflight.arming_terms import ArmingTerms
from companion.acting.sortie.preflight.dock_check import DockCheck, needs_docks
from companion.acting.sortie.preflight.failsafe_check import FailsafeCheck
from companion.acting.sortie.preflight.fence_check import FenceJudge
from companion.acting.sortie.preflight.gauge_check import GaugeCheck
from companion.acting.sortie.preflight.kept_fence import KeptFenceCheck
from companion.acting.sortie.preflight.rally_check import RallyJudge
from companion.acting.sortie.preflight.upload_check import UploadCheck
from companion.errors import Aborted
from companion.geometry import Ned
from companion.mission.model import Mission
from companion.mission.steps import TakeOff
from companion.outcomes import Failed, Outcome, Progress
from companion.vehicle.ports.state import VehicleState


class GroundChecks:
    """The checks of one sortie.

    Args:
        flight: the flight whose autopilot is asked.
        terms: what the operator has decided.
        mission: the mission to fly.
        executive: has its plan.
        limit: the limit of the flight, which counts from the end of the checks.
    """

    def __init__(
        self,
        flight: Flight,
        terms: ArmingTerms,
        mission: Mission,
        executive: Executive,
        limit: LimitWatch,
    ) -> None:
        self._flight, self._mission, self._limit = flight, mission, limit
        energy = executive.planner.energy
        reserve = None if energy is None else energy.model.charge(energy.model.reserve)
        homes = _other_homes(mission)
        failsafes = FailsafeCheck(flight, terms.accepts_weak_failsafes, reserve, homes)
        fence = FenceJudge(flight, terms.fence, tuple(mission.places.values()))
        kept = KeptFenceCheck(flight, executive, fence, mission.home.name)
        rally = RallyJudge(flight, terms.rally_points, mission)
        uploads = UploadCheck(fence, terms.fence), UploadCheck(rally, terms.rally_points)
        self._checks = [failsafes.tick, uploads[0].tick, kept.tick, uploads[1].tick]
        if energy is not None:
            self._checks.insert(0, GaugeCheck(flight).tick)
        if needs_docks(mission):
            self._checks.insert(0, DockCheck(flight).tick)

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """Ends when the vehicle may be armed, or may not."""
        outcome = self._check()
        if isinstance(outcome, Failed):
            return PhaseEnd(SortieEvent.GIVEN_UP, Aborted(outcome.reason))
        if outcome is not Progress.DONE:
            return None
        self._limit.begin(self._flight.now_s)
        return PhaseEnd(SortieEvent.CHECKED)

    def _check(self) -> Outcome:
        """DONE when the vehicle may be armed; or why it may not."""
        if (reason := why_not_armed(self._flight, self._mission)) is not None:
            return Failed(reason)
        outcome = self._checks[0]()
        if outcome is not Progress.DONE or len(self._checks) == 1:
            return outcome
        del self._checks[0]
        return Progress.RUNNING


def _other_homes(mission: Mission) -> tuple[Ned, ...]:
    """Where the vehicle may take off again, in addition to where it begins."""
    steps = (step for skill in mission.skills.values() for step in skill.execute)
    if not any(isinstance(step, TakeOff) for step in steps):
        return ()
    markers = ((place.position, place.marker) for place in mission.places.values())
    return tuple((at[0], at[1], -marker.up_m if marker else 0.0) for at, marker in markers)
