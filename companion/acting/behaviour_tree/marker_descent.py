"""The way down to a marker by own setpoints: until the vehicle is low, still and over the marker.

The setpoints pass the gate like all others, and the mode stays OFFBOARD. So nobody has to tell one
of our modes from a pilot's. marker_states.py has the states and what ends them, marker_watch.py
says where the marker is seen.

If the marker is lost near the ground (BLIND_M), where no camera sees all of it, the vehicle lands
where it was last seen. After a descent that fails, the vehicle is at its place.
"""

from __future__ import annotations

import math

from companion.acting.behaviour_tree.marker_states import TRANSITIONS, MarkerCue, MarkerState
from companion.acting.behaviour_tree.marker_watch import MarkerWatch
from companion.acting.flight import Flight
from companion.flight_events.landing import MarkerAbandoned, MarkerLost, MarkerSeen
from companion.geometry import Ned, distance, horizontal_distance
from companion.mission.markers import LandingMarker
from companion.mission.places import Place
from companion.motion.glide import Glide
from companion.motion.marker_track import LAND_FROM_M
from companion.motion.position_error import greatest_error_m
from companion.outcomes import Failed, Outcome, Progress, Refusal
from companion.vehicle.ports.state import VehicleState

LOOK_S = 5.0
"""How long the marker is looked for from the place, before the search for it begins."""
WAIT_S = 3.0
"""How long a vehicle that has lost it holds before it climbs."""
LOSSES = 3
"""How often the marker may be lost."""
ALL_S = 120.0
"""The longest time of everything before the autopilot lands."""
SEARCH_M = 1.5
"""Half the edge of the square that is searched; limited by the region of the place."""
SPEED_MPS, SINK_MPS = 0.8, 1.0
SINK_PER_M, SLOWEST_MPS = 0.4, 0.3
"""Speed of the descent per metre above the marker, and its least value."""
BESIDE_M, BESIDE_PER_M = 0.15, 0.1
"""The vehicle sinks while it is at most so far from the vertical through the marker."""
SETTLED_M, SETTLED_MORE_M, SETTLED_MPS, SETTLED_S = 0.12, 0.05, 0.25, 0.5
"""Low over the marker it has to be this near (more with each second) and this slow, for so long."""
NEAR_M, STILL_MPS = 0.3, 0.05
LEAVE_S = 30.0


def why_not_from_here(place: Place, marker: LandingMarker, state: VehicleState) -> Refusal | None:
    """Why a descent cannot begin where the vehicle is; None if it can."""
    north, east, _ = state.motion.position
    away_m = place.region.away_m(place.position, (north, east, place.position[2]))
    if away_m > max(NEAR_M, greatest_error_m(state.motion.accuracy_m)):
        return Refusal(f"the vehicle is not above {place.name}")
    if -place.position[2] < marker.up_m + LAND_FROM_M:
        return Refusal(f"{place.name} is no higher than its marker")
    return None


class MarkerDescent:
    """One descent to the marker of a place.

    Args:
        flight: the flight.
        place: the place.
        marker: its marker.
        start: where the setpoint begins.
        begun_s: since when the time of the landing counts.
    """

    def __init__(
        self, flight: Flight, place: Place, marker: LandingMarker, start: Ned, begun_s: float
    ) -> None:
        self._flight, self._place, self._marker = flight, place, marker
        self._state = MarkerState.LOOKING
        self._watch = MarkerWatch(flight, place, marker)
        self._glide = Glide(start)
        self._begun_s = self._since_s = self._stepped_s = begun_s
        self._low_s: float | None = None
        self._settled_s: float | None = None
        self._losses = 0
        self._seen_from: Ned | None = None
        self._corners: list[Ned] = []
        self._why = ""

    @property
    def marker_at(self) -> Ned | None:
        """Where the marker is, as far as is known; None before it has been seen."""
        return self._watch.position

    def tick(self, state: VehicleState) -> Outcome:
        """Sends one setpoint; DONE low over the marker, a failure back at the place."""
        self._watch.look(state)
        problem = self._problem(state)
        self._why = problem.reason if problem is not None else self._why
        cue = MarkerCue.REFUSED if problem is not None else self._cue(state)
        if cue is not None:
            self._enter(cue, state)
        if self._state is MarkerState.LANDING:
            return Progress.DONE
        self._fly(state)
        if self._state is MarkerState.LEAVING and self._is_back(state):
            return Failed(self._why)
        return Progress.RUNNING

    # -- what ends each state ------------------------------------------------------------------

    def _problem(self, state: VehicleState) -> Refusal | None:
        """Why the vehicle may not land there; None if there is no reason."""
        marker = self._watch.position
        if self._state is MarkerState.LEAVING:
            return None
        if self._watch.problem is not None:
            return self._watch.problem
        if self._flight.now_s - self._begun_s > ALL_S:
            return Refusal(f"not down after {ALL_S:.0f} s")
        if self._losses > LOSSES:
            return Refusal(f"the marker was lost {self._losses} times")
        if marker is not None:
            up_m = self._marker.up_m + self._flight.profile.clearance_m
            above = max(up_m, -state.motion.position[2])
            if not self._flight.routes.is_free((*marker[:2], -above)):
                return Refusal("something stands beside the marker, or the fence is too near")
        return None

    def _cue(self, state: VehicleState) -> MarkerCue | None:
        """What ends the present state in this tick; None if nothing does."""
        watch = self._watch
        match self._state:
            case MarkerState.DESCENDING:
                if not watch.is_seen(state):
                    return MarkerCue.LOST
                return MarkerCue.LOW if self._is_settled(state) else None
            case MarkerState.LEAVING | MarkerState.LANDING:
                return None
            case _ if watch.is_seen_now:
                return MarkerCue.SEEN
            case MarkerState.LOOKING:
                return MarkerCue.TIME_UP if self._for_s > LOOK_S else None
            case MarkerState.WAITING:
                return MarkerCue.TIME_UP if self._for_s > WAIT_S else None
            case MarkerState.CLIMBING:
                is_back = distance(state.motion.position, self._target(state)) <= NEAR_M
                return MarkerCue.ARRIVED if is_back else None
            case MarkerState.SEARCHING:
                return None if self._is_searching(state) else MarkerCue.TIME_UP

    def _is_searching(self, state: VehicleState) -> bool:
        """Whether a corner is left to search from; notes the failure if none is."""
        if self._corners and distance(state.motion.position, self._corners[0]) <= NEAR_M:
            self._corners.pop(0)
        if not self._corners:
            self._why = self._watch.why_not_seen
        return bool(self._corners)

    def _is_settled(self, state: VehicleState) -> bool:
        """Whether the vehicle has been low, above the marker, and still, for a while.
        If it is so low that the marker is no longer seen, it does not wait until it is still,
        because it then holds an estimated height, which drifts.
        """
        marker, now_s = self._watch.position, self._flight.now_s
        assert marker is not None
        if self._watch.above_m(state) > LAND_FROM_M + 0.1:
            self._settled_s = self._low_s = None
            return False
        self._low_s = now_s if self._low_s is None else self._low_s
        near_m = SETTLED_M + SETTLED_MORE_M * (now_s - self._low_s)
        speed_mps = math.hypot(*state.motion.velocity)
        is_still = speed_mps <= SETTLED_MPS or not self._watch.is_seen_now
        if horizontal_distance(state.motion.position, marker) > near_m or not is_still:
            self._settled_s = None
            return False
        self._settled_s = now_s if self._settled_s is None else self._settled_s
        return now_s - self._settled_s >= SETTLED_S

    # -- what is done --------------------------------------------------------------------------

    @property
    def _for_s(self) -> float:
        """The time in the present state."""
        return self._flight.now_s - self._since_s

    def _enter(self, cue: MarkerCue, state: VehicleState) -> None:
        name, marker = self._place.name, self._watch.position
        then = self._state = TRANSITIONS.next(self._state, cue)
        self._since_s = self._flight.now_s
        self._low_s = self._settled_s = None
        if then is MarkerState.DESCENDING and marker is not None:
            off_m = horizontal_distance(marker, self._place.position)
            self._flight.report(MarkerSeen(name, round(off_m, 1)))
        elif then is MarkerState.WAITING:
            self._losses += 1
            self._flight.report(MarkerLost(name, round(self._watch.above_m(state), 1)))
        elif then is MarkerState.SEARCHING:
            self._corners = self._square()
        elif then is MarkerState.LEAVING:
            self._flight.report(MarkerAbandoned(name, self._why))

    def _square(self) -> list[Ned]:
        """The corners of the square that is searched, around the place, and its centre."""
        north, east, down = self._place.position
        half_m = min(SEARCH_M, self._place.inner_m / math.sqrt(2))
        corners = ((1, 1), (1, -1), (-1, -1), (-1, 1), (0, 0))
        found = [(north + n * half_m, east + e * half_m, down) for n, e in corners]
        return [corner for corner in found if self._flight.routes.is_free(corner)]

    def _target(self, state: VehicleState) -> Ned:
        """The target of the setpoint."""
        marker, place = self._watch.position, self._place.position
        match self._state:
            case MarkerState.DESCENDING if marker is not None:
                beside_m = horizontal_distance(state.motion.position, marker)
                above_m = max(0.0, self._watch.above_m(state))
                is_over = beside_m <= BESIDE_M + BESIDE_PER_M * above_m
                down = marker[2] - LAND_FROM_M
                return (*marker[:2], down if is_over else min(down, self._glide.position[2]))
            case MarkerState.CLIMBING:
                north, east, down = self._seen_from or place
                return (north, east, max(place[2], down - 1.0))
            case MarkerState.SEARCHING if self._corners:
                return self._corners[0]
            case MarkerState.LEAVING:
                return place
        return self._glide.position

    def _fly(self, state: VehicleState) -> None:
        """Sends one setpoint, which waits for a vehicle that falls behind."""
        flight, glide = self._flight, self._glide
        dt_s, self._stepped_s = flight.elapsed_s(self._stepped_s), flight.now_s
        if distance(glide.position, state.motion.position) > flight.profile.carrot_m / 2:
            flight.guidance.descend(glide.wait())
            return
        if self._state is MarkerState.DESCENDING and self._watch.is_seen_now:
            self._seen_from = state.motion.position
        profile, limit_mps = flight.profile, flight.speed_limit.now_mps / 2
        sink_mps = max(SLOWEST_MPS, SINK_PER_M * (self._watch.above_m(state) - LAND_FROM_M))
        sample = glide.step(
            self._target(state),
            dt_s,
            min(SPEED_MPS, limit_mps),
            min(profile.climb_mps, limit_mps),
            min(profile.descent_mps, SINK_MPS, sink_mps, limit_mps),
        )
        flight.guidance.descend(sample)

    def _is_back(self, state: VehicleState) -> bool:
        is_there = distance(state.motion.position, self._place.position) <= NEAR_M
        is_still = math.hypot(*self._glide.velocity) <= STILL_MPS
        return (is_there and is_still) or self._for_s > LEAVE_S
