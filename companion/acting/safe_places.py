"""Chooses where to land when the task has no plan: at the safe place that is reached soonest.

With `return_home`, home is the only safe place; with `land` and `hold` there is none. The flight
times are the planner's, over clear routes of the present map; the vehicle holds until they are
known. A place whose way turns out to be blocked is not tried again as long as the task has no plan.

If the mission has a battery, a place that the charge is not enough for is chosen only if there is
no other one, docks included; then it is the place for which the least is missing.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from companion.acting.flight import Flight
from companion.geometry import horizontal_distance
from companion.mission.facts import HERE, at
from companion.motion.distance_maps import CELL_US
from companion.motion.position_error import greatest_error_m
from companion.motion.routes import CELLS_PER_TICK
from companion.planning.domain import WAIT
from companion.planning.en_route import AT_HERE
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.lasso import Lasso
from companion.planning.planner import Planner
from companion.slices import Answered, Question, spent

MAX_PARTS = 200
"""The most parts of the search for routes to a place, on a map that keeps changing."""
NO_WAY = 1 << 40


@dataclass(frozen=True, slots=True)
class AtSafePlace:
    """The plan has landed the vehicle on a safe place, so it stays there."""

    place: str


@dataclass(frozen=True, slots=True)
class WayToSafePlace:
    """The vehicle flies to a safe place.

    Attributes:
        place: its name.
        lasso: a plan that flies there and rests.
    """

    place: str
    lasso: Lasso


@dataclass(frozen=True, slots=True)
class NoSafePlace:
    """No safe place is left that can be reached."""


SafePlaceDecision = AtSafePlace | WayToSafePlace | NoSafePlace


class SafePlaces:
    """The safe places of a mission, and which of them were tried.

    Attributes:
        place: the place to which the vehicle flies; None before, and once it has been left.

    Args:
        flight: the flight.
        planner: knows how long flights take.
        places: by name.
    """

    def __init__(self, flight: Flight, planner: Planner, places: Sequence[str]) -> None:
        self.place: str | None = None
        self._flight, self._planner, self._places = flight, planner, places
        self._tried: set[str] = set()
        self._choosing = Question[str | None]()

    def forget(self) -> None:
        """Allows all places to be tried again, because the task had a plan meanwhile."""
        self._tried.clear()
        self.place = None
        self._choosing.abandon()

    def leave_way(self, is_blocked: bool) -> None:
        """Flies no longer to the present place, which may be chosen again if it is not blocked."""
        if self.place is not None and not is_blocked:
            self._tried.discard(self.place)
        self.place = None

    def decide(self) -> SafePlaceDecision | None:
        """What a vehicle without a plan does now; None while that is not known."""
        if (landed_at := self.landed_at) is not None:
            return AtSafePlace(landed_at)
        chosen = self.choose()
        if chosen is None:
            return None
        if chosen.answer is None:
            return NoSafePlace()
        lasso = flight_to(self._planner, chosen.answer)
        if lasso is None:
            return None  # the next one is chosen
        self.place = chosen.answer
        return WayToSafePlace(chosen.answer, lasso)

    @property
    def landed_at(self) -> str | None:
        """The safe place on which the plan has landed the vehicle; None if it has not.

        A dock is one where the charge lasts for none of the mission's.
        """
        energy = self._planner.energy
        if not self._flight.progress.is_landed_by_plan:
            return None
        named = next(filter(self._stands_at, self._places), None)
        if named is not None or energy is None:
            return named
        if any(self._missing(energy, place) <= 0 for place in self._places):
            return None
        return next(filter(self._stands_at, energy.safe), None)

    def _stands_at(self, name: str) -> bool:
        """Whether the vehicle stands at a place.

        The task has a vehicle between places whose skill flies to a place itself and has failed
        there. Then its position decides, with the margins that a mission has to begin at home.
        """
        facts, state = self._flight.task.facts, self._flight.vehicle.state
        if AT_HERE not in facts or state is None:
            return at(name) in facts
        place = self._planner.mission.places[name]
        near_m = place.inner_m + greatest_error_m(state.motion.accuracy_m)
        there = self._flight.symbols[name].position
        return horizontal_distance(there, state.motion.position) <= near_m

    def choose(self) -> Answered[str | None] | None:
        """The next place to fly to, or that none can be reached; None while that is not known.

        It is not chosen again.
        """
        left = [place for place in self._places if place not in self._tried]
        if not left:
            return Answered(None)
        answered = self._choosing.ask(tuple(left), lambda: self._soonest(left))
        if answered is not None and answered.answer is not None:
            self._tried.add(answered.answer)
        return answered

    def _soonest(self, places: Collection[str]) -> str | None:
        times_s = self._times_s(places)
        energy = self._planner.energy
        if energy is None or not places:
            return min(times_s, key=times_s.__getitem__, default=None)  # the first of equals
        if lasting := [place for place in times_s if self._missing(energy, place) <= 0]:
            return min(lasting, key=times_s.__getitem__)
        docks = [dock for dock in energy.safe if dock not in self._tried]
        times_s |= self._times_s(docks)
        if lasting := [place for place in times_s if self._missing(energy, place) <= 0]:
            return min(lasting, key=times_s.__getitem__)
        return min(times_s, key=lambda place: self._missing(energy, place), default=None)

    def _times_s(self, places: Collection[str]) -> dict[str, float]:
        """How long it takes to each of some places that can be reached."""
        state, routes = self._flight.vehicle.state, self._flight.routes
        if state is None:
            return {}
        found: dict[str, float] = {}
        for place in places:
            for _ in range(MAX_PARTS):
                if routes.search(state.motion.position, place, CELLS_PER_TICK):
                    break
                spent(CELL_US * CELLS_PER_TICK)
            found[place] = self._planner.actions.flight_time(HERE, place)
        return {place: time_s for place, time_s in found.items() if math.isfinite(time_s)}

    def missing(self, place: str) -> int:
        """The energy missing to land at a place with the reserve left; 0 if none is missing."""
        energy = self._planner.energy
        return max(0, self._missing(energy, place)) if energy is not None else 0

    def _missing(self, energy: MissionEnergy, place: str) -> int:
        """The energy missing to land at a place with the reserve left; at most 0 for none."""
        needed, reserve = energy.to_land_at(place), energy.model.reserve
        return (NO_WAY if needed is None else needed) + reserve - energy.charge.least()


def flight_to(planner: Planner, place: str) -> Lasso | None:
    """A plan that flies to a place from where the vehicle is, and rests; None without a route.

    It ignores what the skill that flies there would otherwise require.
    """
    move = planner.actions.move_to(place)
    return None if move is None else Lasso((move,), (WAIT,))
