"""The energy that a mission's actions take, and the floors at its places."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from companion.mission.facts import HERE
from companion.mission.model import Mission
from companion.mission.skills import Skill
from companion.motion.departure import Departure, at_rest
from companion.motion.profile import SpeedLimits
from companion.planning.charger import UNITS_PER_WH, Charger
from companion.planning.domain import REST_S, Action
from companion.planning.energy.charge_source import ChargeSource, FullBattery
from companion.planning.energy.model import EnergyModel
from companion.planning.energy.ratio_estimate import KnownRatios, RatioEstimate
from companion.planning.energy_check import place_of
from companion.planning.flown_routes import FlownRoutes
from companion.planning.lasso import Energy
from companion.planning.step_times import waits_s

MOVING_MPS = 0.5
WAITS_END_S = 5.0
"""A wait ends this long before the charge is needed to reach a safe place."""


class MissionEnergy:
    """The energy of a mission; fulfils `Drains`.

    Args:
        mission: a mission with a battery.
        flown_routes: the routes to its places.
        limits: tells how fast it may fly now.

    Attributes:
        model: the figures for computing energy.
        here: tells where the vehicle is, and how it moves, between places.
        charge: tells the present charge; a full battery before a flight.
        known: the ratios of energy used to predicted energy, from flights so far.
        percents: by level, the charge of the battery.
    """

    def __init__(
        self,
        mission: Mission,
        flown_routes: FlownRoutes,
        limits: Callable[[], SpeedLimits] | None = None,
    ) -> None:
        battery = mission.battery
        assert battery is not None
        self._mission, self._battery = mission, battery
        self._flown_routes, self._routes = flown_routes, flown_routes.routes
        self._limits = limits or (lambda: mission.speed_limits)
        self.model = EnergyModel(battery)
        self.here: Callable[[], Departure | None] = lambda: None
        self.charge: ChargeSource = FullBattery(self.model.full)
        self.known = KnownRatios()
        self._charging: dict[str, NDArray[np.int64]] = {}
        self._docks: dict[str, None] = {}
        self.percents = [100 * self.model.charge(level) for level in range(self.model.full + 1)]

    def follow(self, here: Callable[[], Departure | None], charge: ChargeSource) -> None:
        """From now on uses what a flight knows: where the vehicle is, and its charge."""
        self.here, self.charge = here, charge

    def of(
        self, skill: Skill, action: Action, flight: tuple[str, str] | None, place: str | None
    ) -> Action:
        """An action with its energy; see `Drains`."""
        drain = math.ceil(skill.energy_wh * UNITS_PER_WH)
        if flight is not None:
            drain += self.flight(*flight) or 0
            drain += self.model.hovering(waits_s(action.execute))
        else:
            drain += self.model.hovering(action.cost_ms / 1000)
        if skill.charge_rate is None or place is None:
            return action if action.drain == drain else replace(action, drain=drain)
        self._docks[place] = None
        charger = self._charger(skill, place, action.cost_ms if flight else 0, drain)
        return replace(action, cost_ms=charger.overhead_ms, charger=charger)

    def flight(self, origin: str, goal: str) -> int | None:
        """The energy of a flight; None without a route."""
        departure = self.here() if origin == HERE else at_rest(self._routes.goal(origin))
        return None if departure is None else self._flight(departure, goal)

    def left_to(self, goal: str, speed_mps: float) -> int | None:
        """The energy for the rest of a flight to a place; None without a route.

        Args:
            goal: where the flight leads.
            speed_mps: speed of the vehicle.
        """
        if (here := self.here()) is None:
            return None
        flight = self._flight(at_rest(here.now.position), goal)
        return None if flight is None else max(0, flight - self._of_speeding_up(speed_mps))

    def _flight(self, departure: Departure, goal: str) -> int | None:
        start, limits = departure.now.position, self._limits()
        passage = self._routes.passage(start, goal)
        flight_s = self._flown_routes.departure_s(departure, goal, limits)
        if math.isinf(flight_s):
            return None
        return self.model.flight(passage, start, self._routes.goal(goal), limits, flight_s)

    def _of_speeding_up(self, speed_mps: float) -> int:
        """The energy that a flight from rest takes more than one that already has a speed."""
        limits = self._limits()
        ramp_s = speed_mps / limits.acceleration_mps2 + limits.acceleration_mps2 / limits.jerk_mps3
        return self.model.hovering(ramp_s / 2) if speed_mps > MOVING_MPS else 0

    def now(self, is_en_route: bool) -> Energy:
        """The energy of a problem.

        Args:
            is_en_route: whether the vehicle is between places.
        """
        names = [*self._mission.places, *([HERE] if is_en_route else [])]
        landings = {name: self._landing(name) for name in self._mission.places}
        floors = {}
        for name in names:
            flights = [(0 if name == s else self.flight(name, s), landings[s]) for s in self.safe]
            least = [there + landing for there, landing in flights if there is not None]
            if least:
                floors[name] = self.model.reserve + min(least)
        rests = {name: self.model.reserve + landing for name, landing in landings.items()}
        rest = self.model.hovering(REST_S)
        return Energy(self.charge.least(), floors, rests, rest, self.percents)

    def with_reserve(self, energy: Energy, place: str, actions: Iterable[Action]) -> Energy:
        """The energy, if in the air nothing is left above the reserve, meant for the landing.

        The plan may use as much of the reserve as the landing at the safe place that takes the
        least, and charging there if it is a dock. So a plan leads there and goes on.

        Args:
            energy: the energy of a problem.
            place: where the vehicle is; "" for between places.
            actions: the actions of the problem.
        """
        floor = energy.floors.get(place := place or HERE)
        if floor is None or not self.charge.is_flown:
            return energy
        borrowed = max(floor, self._to_land_from(place, energy, actions)) - energy.level
        if energy.level >= floor:
            return replace(energy, borrowable=max(0, borrowed))
        if borrowed > self.model.reserve:
            return energy
        return replace(energy, level=energy.level + borrowed, borrowed=borrowed)

    def _to_land_from(self, place: str, energy: Energy, actions: Iterable[Action]) -> int:
        """The lowest level with which an action leads to a safe place, to charge there or to rest.

        It is taken from the actions, not from the route: the actions were computed at another
        moment, and the vehicle moves.
        """
        ends = {safe: energy.rests[safe] for safe in self.safe}
        charges: dict[str, int] = {}
        moves: dict[str, int] = {place: 0}
        for action in actions:
            start = place_of(action.requires)
            if action.charger is not None:
                floor = (action.charger.bare or action.charger).floor
                charges[start] = min(floor, charges.get(start, floor))
            elif start == place and (goal := action.destination) is not None:
                moves[goal] = action.drain
        ends |= charges
        return min((moves[safe] + ends[safe] for safe in ends if safe in moves), default=0)

    def recall(self, flying: RatioEstimate, gauge: RatioEstimate) -> None:
        """Makes plans use ratios that were learnt before."""
        self.known = KnownRatios(flying, gauge)
        self.use_known()

    def use_known(self) -> None:
        """Makes plans use the ratios that are known now."""
        self.model.factor = self.known.to_plan_with

    def assume(self, factor: float) -> None:
        """Computes everything with a multiple of what the mission says."""
        self.model = EnergyModel(self._battery.times(factor))

    @property
    def safe(self) -> tuple[str, ...]:
        """Where the vehicle may land: the mission's safe places or home, and its docks."""
        named = self._mission.safe_places or (self._mission.home.name,)
        return tuple(dict.fromkeys([*named, *self._docks]))

    def to_land_at(self, place: str) -> int | None:
        """The energy to fly to a place from here, and to land there; None without a route.

        It is called in each tick of a wait, so no route is made: the length of the path is used,
        with the bends of the route from the nearest place.
        """
        if (departure := self.here()) is None:
            return None
        here, limits = departure.now.position, self._limits()
        passage = self._routes.passage(here, place)
        if math.isinf(passage.over_ground_m):
            return None
        near = min(map(self._routes.goal, self._mission.places), key=lambda at: math.dist(at, here))
        flight_s = passage.duration_s(limits) + self._flown_routes.bends_s(near, place, limits)
        goal = self._routes.goal(place)
        return self.model.flight(passage, here, goal, limits, flight_s) + self._landing(place)

    @property
    def is_needed_to_land(self) -> bool:
        """Whether landing at a safe place needs all charge but the reserve, so that waits end."""
        needed = [drain for place in self.safe if (drain := self.to_land_at(place)) is not None]
        margin = self.model.reserve + self.model.hovering(WAITS_END_S)
        return bool(needed) and self.charge.least() < min(needed) + margin

    def to_take_off(self) -> int:
        """The energy to take off here, to the height of the nearest place."""
        if (here := self.here()) is None:
            return 0
        goals, position = map(self._routes.goal, self._mission.places), here.now.position
        nearest = min(goals, key=lambda goal: math.dist(goal[:2], position[:2]))
        return self.model.take_off(max(0.0, -nearest[2]), self._limits())

    def _landing(self, place: str) -> int:
        return self.model.landing(-self._routes.goal(place)[2])

    def _charger(self, skill: Skill, place: str, before_ms: int, before: int) -> Charger:
        rate = skill.charge_rate
        assert rate is not None
        times_ms = self._charging.get(skill.name)
        if times_ms is None:
            times_ms = self._charging[skill.name] = self.model.charging_ms(rate)
        up_m = -self._routes.goal(place)[2]
        return self.model.charger(up_m, self._limits(), times_ms, before_ms, before)
