"""The beginning of a sortie: checks that the vehicle stands at home, and that there is a plan.

Usually the plan is made before the run. If an event has come since then, a new plan is searched in
slices, so that heartbeats and answers continue meanwhile. Functions that the mission calls are
loaded first, because their packages may take seconds.
"""

from __future__ import annotations

from companion.acting.executive import Executive
from companion.acting.flight import Flight
from companion.acting.replanning.replanner import PlanFailure
from companion.acting.sortie.authority import not_at_home
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import SortieEvent
from companion.errors import Aborted, CompanionError
from companion.flight_events.frames import FrameLocated, HomeMeasured, HomeRecalled
from companion.flight_events.skills import FunctionsAwaited
from companion.geometry import horizontal_distance
from companion.mission.places import Place
from companion.outcomes import Failed, Progress
from companion.slices import InSlices
from companion.vehicle.mission_frame import SETTLING_S
from companion.vehicle.ports.frame import Anchoring
from companion.vehicle.ports.state import VehicleState

GROUND_SLICE_US = 30_000
"""Work per tick on the ground, where no setpoints are sent."""


class Beginning:
    """The beginning of one sortie.

    Args:
        flight: the flight.
        executive: makes the plan.
        home: where the vehicle has to stand.
    """

    def __init__(self, flight: Flight, executive: Executive, home: Place) -> None:
        self._flight = flight
        self._home = home
        self._executive = executive
        self._planning: InSlices[PlanFailure | None] | None = None
        self._is_loading = self._is_settling = False

    @property
    def is_planning(self) -> bool:
        """Whether the vehicle stands at home and a plan is being searched."""
        return self._planning is not None

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """Ends when there is a plan, or the mission cannot begin."""
        outcome = self._begin(state)
        if isinstance(outcome, CompanionError):
            return PhaseEnd(SortieEvent.GIVEN_UP, outcome)
        return PhaseEnd(SortieEvent.PLANNED) if outcome is Progress.DONE else None

    def _begin(self, state: VehicleState) -> Progress | CompanionError:
        """DONE when there is a plan; an error if the mission cannot begin."""
        if self._planning is None:
            vehicle, home = self._flight.vehicle, self._home
            gap_m = vehicle.frame.gap_m(home.position, state.motion.accuracy_m)
            if gap_m is None:
                self._tell_settling(state)
                return Progress.RUNNING
            anchoring, location = vehicle.frame.anchoring, vehicle.frame.location
            if elsewhere := not_at_home(gap_m, state, home, anchoring, location):
                return elsewhere
            if (loaded := self._load()) is not Progress.DONE:
                return loaded
            vehicle.frame.stand_at(home.position)
            self._tell_location()
            if anchoring is Anchoring.RECALLED:
                self._flight.report(HomeRecalled(home.name, round(gap_m, 1)))
            self._planning = InSlices(self._executive.plan, GROUND_SLICE_US)
        if not self._planning.step():
            return Progress.RUNNING
        return self._planning.result or Progress.DONE

    def _tell_settling(self, state: VehicleState) -> None:
        """Reports once that nothing will happen for some seconds."""
        if self._flight.vehicle.frame.is_settling and not self._is_settling:
            self._is_settling = True
            self._flight.report(
                HomeMeasured(self._home.name, SETTLING_S, round(state.motion.accuracy_m, 2))
            )

    def _load(self) -> Progress | CompanionError:
        """DONE when all functions are loaded; an error if one cannot be loaded."""
        match self._flight.functions.awaited():
            case Failed(reason):
                hint = "companion check says whether it can be called, and with what"
                return Aborted(f"a function of the mission cannot be called: {reason}\n    {hint}")
            case ():
                return Progress.DONE
            case names:
                if not self._is_loading:
                    self._is_loading = True
                    self._flight.report(FunctionsAwaited(names))
                return Progress.RUNNING

    def _tell_location(self) -> None:
        """Reports where on the earth the mission begins, if it says so."""
        location, home = self._flight.vehicle.frame.location, self._home
        if location is None or not location.is_asked_for:
            return
        zero, origin = location.zero, location.origin
        there = origin.to_local(zero.latitude_deg, zero.longitude_deg, zero.altitude_m)
        self._flight.report(
            FrameLocated(
                home.name,
                round(origin.latitude_deg, 7),
                round(origin.longitude_deg, 7),
                round(horizontal_distance(there, (0.0, 0.0)), 2),
                round(zero.altitude_m, 2),
                round(location.residual_m, 3),
            )
        )
