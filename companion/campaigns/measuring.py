"""Flies one row in lockstep and measures it; writes nothing.

Measurements use the true position. After each tick, the module checks what changes under way: the
walls, the setpoint, the battery, the phase. The fence and the altitude band are compared with the
whole track afterwards. A flight ends early if its row proves to be unfair, or at the campaign's
limit of simulated time; the reported reason then says what the true vehicle was doing.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from companion.acting.sortie.authority import loss_of_link
from companion.api.simulating import flight_of
from companion.campaigns.novelty import signature
from companion.campaigns.outcomes import FlownRow, Margins, RowOutcome, rounded
from companion.campaigns.rows import Row
from companion.campaigns.tracks import simplified
from companion.errors import CompanionError, LinkError
from companion.flight_events.plans import NoPlanFound, PlanReplaced
from companion.flight_events.sortie import Phase, PhaseEntered, TaskSatisfied
from companion.flight_events.word import ConjunctViolated
from companion.flights.simulated_world import verdict
from companion.mission.model import Mission
from companion.mission.steps import Charge, Land, LandOn
from companion.motion.polygons import are_inside, distance_to_edges
from companion.record.audit import audit
from companion.record.events import record_of

if TYPE_CHECKING:
    from companion.api.results import Recording
    from companion.flights.simulated_world import LockstepFlight, World

SET_DOWN_M = 2.0
"""An obstacle that appears nearer to the vehicle than this leaves it no chance."""


class FlightWatch:
    """Measures a flight, tick by tick.

    Args:
        mission: with its limits.
        radius_m: the radius of the true vehicle.
        flight: to be measured.
        recorder: has the flight's events.

    Attributes:
        phase: present phase of the sortie.
        clearance_m, carrot_m, speed_mps, charge: least margins so far.
        airborne: for each tick, whether the vehicle is in the air for its task.
        failed: time and phase of the first failure; None while there is none.
    """

    def __init__(
        self, mission: Mission, radius_m: float, flight: LockstepFlight, recorder: Recording
    ) -> None:
        self._flight, self._recorder = flight, recorder
        self._radius_m, self._carrot_m = radius_m, mission.vehicle.carrot_m
        self._speed_mps = mission.speed_limits.speed_mps
        self._read = 0
        self.phase = Phase.WAITING
        self.clearance_m = self.carrot_m = self.speed_mps = math.inf
        self.charge = 1.0
        self.airborne: list[bool] = []
        self.failed: tuple[float, Phase] | None = None

    def look(self) -> None:
        """Measures after a tick."""
        simulation = self._flight.simulation
        state = simulation.flight
        events = self._recorder.events
        for stamped in events[self._read :]:
            if isinstance(stamped.event, PhaseEntered):
                self.phase = stamped.event.phase
            elif isinstance(stamped.event, ConjunctViolated) and not stamped.event.optional:
                self._fail(stamped.time_s)
        self._read = len(events)
        if simulation.is_damaged:
            self._fail(state.time_s)
        self.airborne.append(simulation.is_armed and self.phase is Phase.TASK)
        self.charge = min(self.charge, state.charge)
        if not simulation.is_armed:
            return
        if (walls := simulation.walls_beside) is not None:
            here = state.position[:2]
            if walls.is_within(here, self.clearance_m + self._radius_m):
                self.clearance_m = walls.clearance_m(here) - self._radius_m
        if (gap_m := simulation.setpoint_gap_m) is not None:
            self.carrot_m = min(self.carrot_m, self._carrot_m - gap_m)
        speed_mps = math.hypot(*state.velocity[:2])
        self.speed_mps = min(self.speed_mps, self._speed_mps - speed_mps)

    def _fail(self, time_s: float) -> None:
        if self.failed is None:
            self.failed = time_s, self.phase


def fly(mission: Mission, world: World, row: Row, limit_s: float) -> FlownRow:
    """Flies a row.

    Args:
        mission: the mission to fly.
        world: the world of the row.
        row: the row to fly.
        limit_s: simulated seconds after which the flight is cut off.
    """
    with flight_of(mission, world, row.seed) as (flight, recorder):
        watch = FlightWatch(mission, world[0].vehicle.radius_m, flight, recorder)
        failure: CompanionError | None = None
        try:
            for _ in flight.ticks():
                watch.look()
                if flight.simulation.set_down_m < SET_DOWN_M:
                    return FlownRow(row, RowOutcome.INVALID, reason="an obstacle on the vehicle")
                if flight.now_s >= limit_s:
                    failure = _lost_for_good(flight)
                    break
            else:
                flight.simulation.settle()
                watch.look()
        except CompanionError as error:
            failure = error
        failure = failure or verdict(flight.companion.failure, flight.simulation.is_damaged)
        return _measured(mission, flight, recorder, watch, row, failure, limit_s)


def _lost_for_good(flight: LockstepFlight) -> LinkError | None:
    """The error that ends a flight whose vehicle is down, while the companion cannot hear this.

    The companion waits for a vehicle that it believes to be in the air; this one is not armed
    again.
    """
    state = flight.companion.telemetry.state
    if state is None or flight.simulation.is_armed:
        return None
    disarmed = replace(state.heartbeat, is_armed=False)
    return loss_of_link(replace(state, heartbeat=disarmed, is_landed=True), flight.now_s)


def _stance(flight: LockstepFlight) -> str:
    """The true state of the vehicle, in words."""
    if not flight.simulation.flight.is_on_ground:
        return "in the air"
    return f"on the ground, {'' if flight.simulation.is_armed else 'not '}armed"


def _measured(
    mission: Mission,
    flight: LockstepFlight,
    recorder: Recording,
    watch: FlightWatch,
    row: Row,
    failure: CompanionError | None,
    limit_s: float,
) -> FlownRow:
    is_cut = not flight.companion.has_ended and failure is None
    outcome, conjunct = _outcome(flight, recorder, failure, is_cut)
    at_s, phase = watch.failed or (flight.now_s, _last_phase(recorder))
    moment = min(range(len(flight.truth)), key=lambda i: abs(flight.truth[i][0] - at_s))
    north_m, east_m, _ = flight.truth[moment][1]
    nearest = min(
        mission.places.values(), key=lambda place: math.dist(place.position[:2], (north_m, east_m))
    )
    events = [stamped.event for stamped in recorder.events]
    reason = f"cut off at the limit, {_stance(flight)}" if is_cut else str(failure or "")
    return FlownRow(
        row,
        outcome,
        conjunct=conjunct,
        exit_code=None if is_cut else failure.exit_code if failure else 0,
        reason=reason.partition("\n")[0],
        margins=_margins(mission, flight, watch, limit_s),
        replans=sum(isinstance(event, PlanReplaced | NoPlanFound) for event in events),
        duration_s=rounded(flight.now_s),
        phase=phase.value,
        place=nearest.name,
        east_m=rounded(east_m),
        north_m=rounded(north_m),
        signature=signature(events),
        track=simplified([(east, north) for _, (north, east, _) in flight.truth]),
    )


def _outcome(
    flight: LockstepFlight, recorder: Recording, failure: CompanionError | None, is_cut: bool
) -> tuple[RowOutcome, str]:
    """How a flight ended, and the line of the task that it violated."""
    if flight.simulation.is_damaged or flight.simulation.collisions:
        return RowOutcome.CRASH, ""
    if violated := _violated(recorder):
        return RowOutcome.VIOLATED, violated
    if is_cut:
        return RowOutcome.LIMIT, ""
    if failure is None:
        is_satisfied = any(isinstance(each.event, TaskSatisfied) for each in recorder.events)
        return (RowOutcome.SATISFIED if is_satisfied else RowOutcome.HOLDS_SO_FAR), ""
    return (RowOutcome.NO_PLAN if failure.exit_code in (3, 7) else RowOutcome.ABORTED), ""


def _violated(recorder: Recording) -> str:
    """The line of the task that the audit finds violated or unfulfilled; "" if none."""
    try:
        findings = audit(record_of(recorder.events)).findings
    except CompanionError:  # there is no plan, or the monitor would be too large
        told = (e.event for e in recorder.events if isinstance(e.event, ConjunctViolated))
        return next((event.conjunct for event in told if not event.optional), "")
    return next((finding.name for finding in findings if finding.is_failure), "")


def _last_phase(recorder: Recording) -> Phase:
    entered = [e.event.phase for e in recorder.events if isinstance(e.event, PhaseEntered)]
    return next((phase for phase in reversed(entered) if phase is not Phase.ENDED), Phase.WAITING)


def _margins(
    mission: Mission, flight: LockstepFlight, watch: FlightWatch, limit_s: float
) -> Margins:
    truth = np.array([position for _, position in flight.truth])[: len(watch.airborne)]
    on_task = truth[np.array(watch.airborne, dtype=np.bool_)[: len(truth)]]
    fence_m = altitude_m = None
    if len(on_task):
        fence_m = _fence_margin_m(mission, on_task[:, :2])
        low_m, high_m = mission.limits.up_m
        altitude_m = high_m + float(on_task[:, 2].min())
        if not _lands_on_the_way(mission):
            altitude_m = min(altitude_m, -float(on_task[:, 2].max()) - low_m)
    return Margins(
        clearance_m=_finite(watch.clearance_m),
        fence_m=_finite(fence_m),
        altitude_m=_finite(altitude_m),
        carrot_m=_finite(watch.carrot_m),
        speed_mps=_finite(watch.speed_mps),
        charge=rounded(watch.charge),
        time_s=rounded(limit_s - flight.now_s),
    )


def _fence_margin_m(mission: Mission, points: npt.NDArray[np.float64]) -> float:
    areas = [(np.array(mission.limits.fence), True)]
    areas += [(np.array(zone), False) for zone in mission.limits.keep_out.values()]
    margins = []
    for corners, is_within in areas:
        away_m = distance_to_edges(points, corners)
        is_kept = are_inside(points, corners) == is_within
        margins.append(float(np.where(is_kept, away_m, -away_m).min()))
    return min(margins)


def _lands_on_the_way(mission: Mission) -> bool:
    steps = [step for skill in mission.skills.values() for step in skill.execute]
    return any(isinstance(step, Land | LandOn | Charge) for step in steps)


def _finite(number: float | None) -> float | None:
    return rounded(number) if number is not None and math.isfinite(number) else None
