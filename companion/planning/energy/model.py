"""Computes the energy of a mission's flights, skills and docks, in whole units of usable energy.

A unit is a hundredth of a watt-hour. Energy that is taken is rounded up, and available energy is
rounded down. A flight takes the power of its airspeed and of its climb for its duration. Everything
else takes the power of a hover.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from companion.battery_profile import interpolated
from companion.geometry import Ned
from companion.mission.battery import MissionBattery
from companion.motion.passage import LEVEL_M, Passage
from companion.motion.profile import SpeedLimits
from companion.planning.charger import UNITS_PER_WH, Charger

_J_PER_UNIT = 3600 / UNITS_PER_WH
FACTOR = 1.05
"""Until a flight knows better, plans use this much more energy than the profile says: for gusts,
and for whatever the profile does not contain."""
LANDING_MPS = 0.7
"""PX4's MPC_LAND_SPEED."""
TOUCHING_DOWN_S = 3.0
"""From touchdown until the autopilot reports that it has landed, and disarms."""
RUNNING_UP_S = 3.0
"""From arming until the vehicle is in the air."""


class EnergyModel:
    """The energy of one mission.

    Args:
        battery: the mission's battery.

    Attributes:
        full: units of a full battery.
        reserve: units kept for what nobody foresees.
        factor: how much more plans use than the battery's figures say; a flight sets it.
    """

    def __init__(self, battery: MissionBattery) -> None:
        self.factor = FACTOR
        self._profile, self._wind = battery.profile, battery.wind
        self.full = math.floor(battery.profile.capacity_wh * UNITS_PER_WH)
        self.reserve = math.ceil(battery.reserve * battery.profile.capacity_wh * UNITS_PER_WH)

    def level(self, charge: float) -> int:
        """The level at a charge between 0 and 1."""
        return math.floor(self._profile.energy_wh(charge) * UNITS_PER_WH)

    def charge(self, level: int) -> float:
        """The charge, 0 to 1, at a level."""
        return self._profile.charge(level / UNITS_PER_WH)

    def hovering(self, seconds: float) -> int:
        """The energy of a hover."""
        return self._units(self._profile.power_w(0.0) * seconds)

    def flight(
        self, passage: Passage, start: Ned, goal: Ned, limits: SpeedLimits, flight_s: float
    ) -> int:
        """The energy of a flight from rest to rest.

        Args:
            passage: the lengths of its route.
            start: where it begins.
            goal: where it ends.
            limits: how fast it is flown.
            flight_s: how long it takes, including the bends of the route.
        """
        down_m, joules = passage.down_m, 0.0
        if passage.climb_m is not None:
            for upright_m in (-passage.climb_m, passage.down_m + passage.climb_m):
                seconds = Passage(0.0, upright_m).duration_s(limits)
                joules += self._joules(0.0, upright_m, start, goal, seconds)
                flight_s -= seconds
            down_m = 0.0
        return self._units(
            joules + self._joules(passage.over_ground_m, down_m, start, goal, flight_s)
        )

    def _joules(
        self, over_ground_m: float, down_m: float, start: Ned, goal: Ned, seconds: float
    ) -> float:
        """The energy of one part: level, sloped, or on the spot."""
        length_m = math.hypot(over_ground_m, down_m)
        if length_m < LEVEL_M or seconds <= 0.0:
            return 0.0
        speed_mps = length_m / seconds
        ahead = math.hypot(goal[0] - start[0], goal[1] - start[1])
        velocity = [
            0.0 if ahead < LEVEL_M else speed_mps * over_ground_m / length_m * (b - a) / ahead
            for a, b in zip(start[:2], goal[:2], strict=True)
        ]
        airspeed_mps = math.hypot(velocity[0] - self._wind[0], velocity[1] - self._wind[1])
        climb_mps = -speed_mps * down_m / length_m
        return self._profile.power_w(airspeed_mps, climb_mps) * seconds

    def landing(self, up_m: float) -> int:
        """The energy of landing from a height above the ground."""
        return self.hovering(up_m / LANDING_MPS + TOUCHING_DOWN_S)

    def landing_s(self, up_m: float) -> float:
        """The time of landing from a height above the ground."""
        return up_m / LANDING_MPS + TOUCHING_DOWN_S

    def take_off_s(self, up_m: float, limits: SpeedLimits) -> float:
        """The time of taking off to a height."""
        return Passage(0.0, -up_m).duration_s(limits) + RUNNING_UP_S

    def take_off(self, up_m: float, limits: SpeedLimits) -> int:
        """The energy of taking off to a height."""
        climb_s = Passage(0.0, -up_m).duration_s(limits)
        climb_w = self._profile.power_w(0.0, up_m / climb_s if climb_s else 0.0)
        return self._units(climb_w * climb_s) + self.hovering(RUNNING_UP_S)

    def charging_ms(self, rate: Sequence[tuple[float, float]]) -> NDArray[np.int64]:
        """(full + 1,) time to charge from empty to each level; convex.

        A curve may bend the other way, because a percent of charge is more energy the fuller the
        battery is. Then the result is the highest convex function that is nowhere above the curve.

        Args:
            rate: pairs of the charge and its rise per second, both as shares; falling.
        """
        from scipy.optimize import isotonic_regression  # 13 MB, which most missions do not need

        charges = np.array([self.charge(level) for level in range(self.full + 1)])
        middles = (charges[1:] + charges[:-1]) / 2
        rises = np.array([max(1e-9, interpolated(rate, float(c))) for c in middles])
        steps_ms = isotonic_regression(1000 * np.diff(charges) / rises).x
        return np.ceil(np.concatenate(([0.0], np.cumsum(steps_ms)))).astype(np.int64)

    def charger(
        self,
        up_m: float,
        limits: SpeedLimits,
        times_ms: NDArray[np.int64],
        before_ms: int = 0,
        before: int = 0,
    ) -> Charger:
        """A dock and its charger.

        Args:
            up_m: height above the ground from which the vehicle lands, and to which it takes off.
            limits: how fast the vehicle climbs.
            times_ms: time to charge from empty to each level.
            before_ms: time of a flight to the dock, if the skill includes one.
            before: energy of that flight.
        """
        landing = before + self.landing(up_m)
        seconds = self.landing_s(up_m) + self.take_off_s(up_m, limits)
        overhead_ms = before_ms + math.ceil(1000 * seconds)
        take_off = self.take_off(up_m, limits)
        return Charger(self.reserve + landing, landing, take_off, overhead_ms, times_ms)

    def _units(self, joules: float) -> int:
        return math.ceil(self.factor * joules / _J_PER_UNIT - 1e-9)


def needs(
    places: Mapping[str, Ned],
    safe: Sequence[str],
    flight: Callable[[str, str], int | None],
    landing: Callable[[str], int],
) -> dict[str, int]:
    """The least energy to land at a safe place, from each place; no entry if no route leads to one.

    Args:
        places: by name.
        safe: the places at which the vehicle can land.
        flight: the energy of a flight from one place to another; None without a route.
        landing: the energy of landing at a place.
    """
    found = {}
    for place in places:
        flights = [(flight(place, each) if each != place else 0, landing(each)) for each in safe]
        open_ = [there + down for there, down in flights if there is not None]
        if open_:
            found[place] = min(open_)
    return found
