"""What the flights, skills and docks of a mission take, in whole units of usable energy.

A unit is a hundredth of a watt-hour. What is taken is rounded up, and what is there down. A flight
takes the power of its speed through the air and of its climb for as long as it lasts; all else the
power of a hover.
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
"""Gusts, and what a profile does not know: plans reckon with so much more than it says, until a
flight knows better."""
LANDING_MPS = 0.7
"""PX4's MPC_LAND_SPEED."""
TOUCHING_DOWN_S = 3.0
"""Until the autopilot says that it has landed, and disarms."""
RUNNING_UP_S = 3.0
"""From arming into the air."""


class EnergyModel:
    """The energy of one mission.

    Args:
        battery: of the mission.

    Attributes:
        full: units of a full battery.
        reserve: units kept for what nobody foresees.
        factor: plans reckon with so much more than the battery's figures; a flight sets it.
    """

    def __init__(self, battery: MissionBattery) -> None:
        self.factor = FACTOR
        self._profile, self._wind = battery.profile, battery.wind
        self.full = math.floor(battery.profile.capacity_wh * UNITS_PER_WH)
        self.reserve = math.ceil(battery.reserve * battery.profile.capacity_wh * UNITS_PER_WH)

    def level(self, charge: float) -> int:
        """The units that are there at a charge, 0 to 1."""
        return math.floor(self._profile.energy_wh(charge) * UNITS_PER_WH)

    def charge(self, level: int) -> float:
        """The charge, 0 to 1, at which so many units are there."""
        return self._profile.charge(level / UNITS_PER_WH)

    def hovering(self, seconds: float) -> int:
        """What a hover takes."""
        return self._units(self._profile.power_w(0.0) * seconds)

    def flight(
        self, passage: Passage, start: Ned, goal: Ned, limits: SpeedLimits, flight_s: float
    ) -> int:
        """What a flight takes from rest to rest.

        Args:
            passage: the way.
            start: where it begins.
            goal: where it ends.
            limits: how fast it is flown.
            flight_s: how long that lasts, with the bends of the way.
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
        """Of one part, level, sloped or on the spot."""
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
        """What landing takes from a height above the ground."""
        return self.hovering(up_m / LANDING_MPS + TOUCHING_DOWN_S)

    def landing_s(self, up_m: float) -> float:
        """How long that lasts."""
        return up_m / LANDING_MPS + TOUCHING_DOWN_S

    def take_off_s(self, up_m: float, limits: SpeedLimits) -> float:
        """How long taking off to a height lasts."""
        return Passage(0.0, -up_m).duration_s(limits) + RUNNING_UP_S

    def take_off(self, up_m: float, limits: SpeedLimits) -> int:
        """What that takes."""
        climb_s = Passage(0.0, -up_m).duration_s(limits)
        climb_w = self._profile.power_w(0.0, up_m / climb_s if climb_s else 0.0)
        return self._units(climb_w * climb_s) + self.hovering(RUNNING_UP_S)

    def charging_ms(self, rate: Sequence[tuple[float, float]]) -> NDArray[np.int64]:
        """(full + 1,) time from empty to each level; convex.

        Where a curve makes it bend the other way, as a percent of charge is more energy the fuller
        the battery is, it is the highest convex function that is nowhere above.

        Args:
            rate: pairs of the charge and of its rise a second, both as shares; falling.
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
        """A dock.

        Args:
            up_m: height above the ground from which it is landed on, and to which it is taken off.
            limits: how fast the vehicle climbs.
            times_ms: time from empty to each level.
            before_ms: of a flight to there, if that belongs to the skill.
            before: what this takes.
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
    """What it takes at least from each place to land at a safe one; none for one without a way.

    Args:
        places: by name.
        safe: those at which the vehicle can land.
        flight: what a flight takes from one to another; None without a way.
        landing: what landing takes at a place.
    """
    found = {}
    for place in places:
        ways = [(flight(place, each) if each != place else 0, landing(each)) for each in safe]
        open_ = [way + down for way, down in ways if way is not None]
        if open_:
            found[place] = min(open_)
    return found
