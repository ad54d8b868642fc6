"""The leaf that lands on a marker: own setpoints lead down over it, then the autopilot lands.

The setpoints pass the gate like all others, and the mode stays OFFBOARD until the vehicle is low,
still and over the marker. So nobody has to tell one of our modes from a pilot's. marker_states.py
has the states and what ends them, and motion/marker_track.py decides which sightings count. During
the descent the plan may be interrupted as in any flight; from the autopilot's landing on, it is as
on the ground (landing.py).

If the marker is lost near the ground (BLIND_M), where no camera sees all of it, the vehicle lands
where it was last seen. After a landing that fails, the vehicle is in the air, at its place.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from py_trees.common import Status

from companion.acting.behaviour_tree.landing import ReachGoals
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.behaviour_tree.marker_states import TRANSITIONS, MarkerCue, MarkerState
from companion.acting.flight import Flight
from companion.flight_events.landing import (
    LandedOnMarker,
    MarkerAbandoned,
    MarkerLost,
    MarkerSeen,
    SightingsRefused,
)
from companion.flight_events.sortie import VehicleLanded
from companion.flight_events.tree import LeafType
from companion.geometry import Ned, distance, horizontal_distance
from companion.motion.glide import Glide
from companion.motion.marker_track import LAND_FROM_M, ExpectedMarker, MarkerTrack
from companion.motion.position_error import greatest_error_m
from companion.outcomes import Refusal
from companion.vehicle.port import Goal, VehicleState

LOOK_S = 5.0
"""How long the marker is looked for from the place, before the search for it begins."""
LOST_S = 1.0
"""Without a sighting for so long the marker is lost;"""
BLIND_S, BLIND_M = 4.0, 1.0
"""nearer to it than this, it is lost only after this time."""
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


class LandOnMarker(ReachGoals):
    """Lands on the marker of a place, and disarms."""

    does = LeafType.LAND_ON

    goals = (Goal.LANDED,)

    def __init__(self, flight: Flight, place: str) -> None:
        Leaf.__init__(self, flight, f"land on {place}")
        self._place = flight.symbols.place(place)
        marker = self._place.marker
        assert marker is not None
        self._marker = marker
        self._expected = ExpectedMarker(self._place.position, self._place.region, marker.up_m)

    def initialise(self) -> None:
        """Begins to look for the marker, from where the vehicle is."""
        flight = self._flight
        self._state = MarkerState.LOOKING
        self._track = MarkerTrack(self._expected)
        self._glide: Glide | None = None
        self._begun_s = self._since_s = self._stepped_s = flight.now_s
        self._low_s: float | None = None
        self._settled_s: float | None = None
        self._losses = self._refused = self._told = 0
        self._last_refusal: Refusal | None = None
        self._seen_from: Ned | None = None
        self._corners: list[Ned] = []
        self._why = ""
        self._left = list(self.goals)
        flight.progress.begin_descent()

    def update(self) -> Status:
        """SUCCESS on the ground; FAILURE in the air, at the place."""
        flight, state = self._flight, self._flight.vehicle.state
        if flight.progress.is_landed_by_plan and not self._is_landing:
            return self.fail("the vehicle is on the ground already")
        if state is None or self._is_landing:
            return super().update()
        if flight.guidance.stop is not None:
            return Status.RUNNING  # it still brakes from the flight before
        if self._glide is None:
            if problem := self._not_above(state):
                return self.fail(problem)
            told = flight.guidance.setpoint
            self._glide = Glide(told.position if told else state.position)
        self._look(state)
        problem = self._problem(state)
        self._why = problem or self._why
        cue = MarkerCue.REFUSED if problem else _CUES[self._state](self, state)
        if cue is not None:
            self._enter(cue, state)
        if self._is_landing:
            return super().update()
        self._fly(state)
        if self._state is MarkerState.LEAVING and self._is_back(state):
            return self.fail(self._why)
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Holds the vehicle where it is when something above interrupts."""
        self._flight.progress.end_descent()
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._flight.guidance.hold()

    def reached(self) -> VehicleLanded:
        """Forgets the last setpoint: after taking off, the vehicle will hold where it then is."""
        flight, state, marker = self._flight, self._flight.vehicle.state, self._track.position
        flight.guidance.forget_setpoint()
        if state is not None and marker is not None:
            off_m = horizontal_distance(state.position, marker)
            flight.report(LandedOnMarker(self._place.name, round(off_m, 2)))
        return VehicleLanded()

    @property
    def _is_landing(self) -> bool:
        """Whether the autopilot is landing."""
        return self._state is MarkerState.LANDING

    # -- what is known -------------------------------------------------------------------------

    def _not_above(self, state: VehicleState) -> str:
        """Why the vehicle is not where the landing begins; empty if it is there."""
        name, place = self._place.name, self._place
        north, east, _ = state.position
        away_m = place.region.away_m(place.position, (north, east, place.position[2]))
        if away_m > max(NEAR_M, greatest_error_m(state.accuracy_m)):
            return f"the vehicle is not above {name}"
        if -place.position[2] < self._marker.up_m + LAND_FROM_M:
            return f"{name} is no higher than its marker"
        return ""

    def _look(self, state: VehicleState) -> None:
        """Takes the sightings of the tick."""
        flight, marker = self._flight, self._marker
        refused = list(flight.vehicle.markers.refused)
        for seen in flight.vehicle.markers.seen:
            if (seen.component, seen.number) == (marker.component, marker.number):
                refusal = self._track.take(seen.seen_s, seen.position, state.accuracy_m)
                refused += [refusal] if refusal else []
        self._refused += len(refused)
        if refused:
            self._last_refusal = refused[-1]
            if self._refused >= max(1, 2 * self._told):
                self._told = self._refused
                told = SightingsRefused(self._place.name, self._refused, refused[-1].reason)
                flight.report(told)

    def _problem(self, state: VehicleState) -> str:
        """Why the vehicle may not land there; empty if there is no reason."""
        marker = self._track.position
        if self._state is MarkerState.LEAVING:
            return ""
        if self._track.problem is not None:
            return self._track.problem.reason
        if self._flight.now_s - self._begun_s > ALL_S:
            return f"not down after {ALL_S:.0f} s"
        if self._losses > LOSSES:
            return f"the marker was lost {self._losses} times"
        if marker is not None:
            up_m = self._marker.up_m + self._flight.profile.clearance_m
            above = max(up_m, -state.position[2])
            if not self._flight.routes.is_free((*marker[:2], -above)):
                return "something stands beside the marker, or the fence is too near"
        return ""

    def _above_m(self, state: VehicleState) -> float:
        """Height of the vehicle above the marker, or above its place in the mission."""
        marker = self._track.position
        up_m = -marker[2] if marker is not None else self._marker.up_m
        return -state.position[2] - up_m

    def _is_seen(self, state: VehicleState) -> bool:
        for_s = BLIND_S if self._above_m(state) < BLIND_M else LOST_S
        return self._track.age_s(self._flight.now_s) <= for_s

    def _is_seen_now(self) -> bool:
        return self._track.age_s(self._flight.now_s) <= LOST_S / 2

    # -- what ends each state ------------------------------------------------------------------

    def _looking(self, state: VehicleState) -> MarkerCue | None:
        if self._is_seen_now():
            return MarkerCue.SEEN
        return MarkerCue.TIME_UP if self._for_s > LOOK_S else None

    def _descending(self, state: VehicleState) -> MarkerCue | None:
        if not self._is_seen(state):
            return MarkerCue.LOST
        return MarkerCue.LOW if self._is_settled(state) else None

    def _waiting(self, state: VehicleState) -> MarkerCue | None:
        if self._is_seen_now():
            return MarkerCue.SEEN
        return MarkerCue.TIME_UP if self._for_s > WAIT_S else None

    def _climbing(self, state: VehicleState) -> MarkerCue | None:
        if self._is_seen_now():
            return MarkerCue.SEEN
        is_back = distance(state.position, self._target(state)) <= NEAR_M
        return MarkerCue.ARRIVED if is_back else None

    def _searching(self, state: VehicleState) -> MarkerCue | None:
        if self._is_seen_now():
            return MarkerCue.SEEN
        if self._corners and distance(state.position, self._corners[0]) <= NEAR_M:
            self._corners.pop(0)
        if self._corners:
            return None
        self._why = self._not_seen()
        return MarkerCue.TIME_UP

    def _is_settled(self, state: VehicleState) -> bool:
        """Whether the vehicle has been low, above the marker, and still, for a while.
        If it is so low that the marker is no longer seen, it does not wait until it is still,
        because it then holds an estimated height, which drifts.
        """
        marker, now_s = self._track.position, self._flight.now_s
        assert marker is not None
        if self._above_m(state) > LAND_FROM_M + 0.1:
            self._settled_s = self._low_s = None
            return False
        self._low_s = now_s if self._low_s is None else self._low_s
        near_m = SETTLED_M + SETTLED_MORE_M * (now_s - self._low_s)
        is_still = math.hypot(*state.velocity) <= SETTLED_MPS or not self._is_seen_now()
        if horizontal_distance(state.position, marker) > near_m or not is_still:
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
        name, marker = self._place.name, self._track.position
        then = self._state = TRANSITIONS.next(self._state, cue)
        self._since_s = self._flight.now_s
        self._low_s = self._settled_s = None
        if then is MarkerState.DESCENDING and marker is not None:
            off_m = horizontal_distance(marker, self._place.position)
            self._flight.report(MarkerSeen(name, round(off_m, 1)))
        elif then is MarkerState.WAITING:
            self._losses += 1
            self._flight.report(MarkerLost(name, round(self._above_m(state), 1)))
        elif then is MarkerState.SEARCHING:
            self._corners = self._square()
        elif then is MarkerState.LEAVING:
            self._flight.report(MarkerAbandoned(name, self._why))
        elif then is MarkerState.LANDING:
            self._flight.progress.take_to_ground()

    def _square(self) -> list[Ned]:
        """The corners of the square that is searched, around the place, and its centre."""
        north, east, down = self._place.position
        half_m = min(SEARCH_M, self._place.inner_m / math.sqrt(2))
        corners = ((1, 1), (1, -1), (-1, -1), (-1, 1), (0, 0))
        found = [(north + n * half_m, east + e * half_m, down) for n, e in corners]
        return [corner for corner in found if self._flight.routes.is_free(corner)]

    def _target(self, state: VehicleState) -> Ned:
        """The target of the setpoint."""
        assert self._glide is not None
        marker, place = self._track.position, self._place.position
        match self._state:
            case MarkerState.DESCENDING if marker is not None:
                self._seen_from = state.position if self._is_seen_now() else self._seen_from
                beside_m = horizontal_distance(state.position, marker)
                is_over = beside_m <= BESIDE_M + BESIDE_PER_M * max(0.0, self._above_m(state))
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
        assert glide is not None
        dt_s, self._stepped_s = flight.elapsed_s(self._stepped_s), flight.now_s
        if distance(glide.position, state.position) > flight.profile.carrot_m / 2:
            flight.guidance.descend(glide.wait())
            return
        profile, limit_mps = flight.profile, flight.speed_limit.now_mps / 2
        sink_mps = max(SLOWEST_MPS, SINK_PER_M * (self._above_m(state) - LAND_FROM_M))
        sample = glide.step(
            self._target(state),
            dt_s,
            min(SPEED_MPS, limit_mps),
            min(profile.climb_mps, limit_mps),
            min(profile.descent_mps, SINK_MPS, sink_mps, limit_mps),
        )
        flight.guidance.descend(sample)

    def _is_back(self, state: VehicleState) -> bool:
        assert self._glide is not None
        is_there = distance(state.position, self._place.position) <= NEAR_M
        is_still = math.hypot(*self._glide.velocity) <= STILL_MPS
        return (is_there and is_still) or self._for_s > LEAVE_S

    def _not_seen(self) -> str:
        what = "its marker is not seen" if self._track.position is None else "its marker is lost"
        refusal = self._last_refusal
        return f"{what}; what was refused last: {refusal.reason}" if refusal else what


_CUES: dict[MarkerState, Callable[[LandOnMarker, VehicleState], MarkerCue | None]] = {
    MarkerState.LOOKING: LandOnMarker._looking,
    MarkerState.DESCENDING: LandOnMarker._descending,
    MarkerState.WAITING: LandOnMarker._waiting,
    MarkerState.CLIMBING: LandOnMarker._climbing,
    MarkerState.SEARCHING: LandOnMarker._searching,
    MarkerState.LEAVING: lambda leaf, state: None,
}
"""What may end each state in a tick."""
