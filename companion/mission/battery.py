"""Reads and checks what a mission file says about its battery."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from companion.battery_profile import BatteryProfile, Points
from companion.documents import Document
from companion.errors import MissionError
from companion.geometry import NorthEast
from companion.mission.battery_schema import BatteryEntry
from companion.vehicle_profile import DEFAULT_VEHICLE, VehicleProfile

FEWEST_W = 1.0
LEAST_PERCENT = 1.0
"""A reserve between 0 and this was probably written as a share instead of in per cent."""


@dataclass(frozen=True, slots=True)
class MissionBattery:
    """The battery that plans reckon with.

    Attributes:
        profile: how much energy it holds, and how much power flying takes.
        reserve: the share of the energy that is kept for what nobody foresees.
        wind: the expected motion of the air, m/s.
    """

    profile: BatteryProfile
    reserve: float
    wind: NorthEast = (0.0, 0.0)

    def times(self, factor: float) -> MissionBattery:
        """The same battery for a vehicle that takes `factor` times the power."""
        level_w, climb_w = (
            tuple((speed_mps, factor * power_w) for speed_mps, power_w in points)
            for points in (self.profile.level_w, self.profile.climb_w)
        )
        return replace(self, profile=replace(self.profile, level_w=level_w, climb_w=climb_w))


def read_battery(
    entry: BatteryEntry | None, vehicle: VehicleProfile, document: Document
) -> MissionBattery | None:
    """The battery of a mission; None if the file has no battery.

    Raises:
        MissionError: the figures are impossible, or are missing for a vehicle other than the
            default.
    """
    if entry is None:
        return None
    if vehicle.name != DEFAULT_VEHICLE and (entry.capacity_wh is None or entry.power_w is None):
        raise MissionError(
            f"the battery of {vehicle.name} is not known",
            document.where("battery"),
            "add capacity_wh: Wh when full, and power_w: {level: [[0, W], [5, W]]}",
        )
    if 0 < entry.reserve < LEAST_PERCENT:
        hint = f"write {100 * entry.reserve:g} for {100 * entry.reserve:g} %"
        where = document.where("battery", "reserve")
        raise MissionError(
            f"the reserve is in percent, and {entry.reserve:g} % is none", where, hint
        )
    profile = BatteryProfile()
    if entry.curve is not None:
        profile = replace(profile, curve=_curve(entry.curve, document))
    elif entry.capacity_wh is not None:
        profile = replace(profile, curve=((0.0, 0.0), (1.0, 1.0)))
    if entry.capacity_wh is not None:
        profile = replace(profile, capacity_wh=entry.capacity_wh)
    if entry.power_w is not None:
        level = _powers(entry.power_w.level, "level", document)
        if level[0][0] != 0:
            where = document.where("battery", "power_w", "level", 0)
            raise MissionError("the power of a hover is missing", where, "begin with [0, WATTS]")
        climb: Points = ((0.0, level[0][1]), (1.0, level[0][1]))
        if entry.power_w.climb is not None:
            climb = _powers(entry.power_w.climb, "climb", document)
        profile = replace(profile, level_w=level, climb_w=climb)
    return MissionBattery(profile, entry.reserve / 100, (entry.wind.north_mps, entry.wind.east_mps))


def _curve(points: Sequence[tuple[float, float]], document: Document) -> Points:
    is_whole = tuple(points[0]) == (0, 0) and tuple(points[-1]) == (100, 100)
    is_rising = all(a < b and e < f for (a, e), (b, f) in pairwise(points))
    if not (is_whole and is_rising):
        raise MissionError(
            "the curve does not rise from [0, 0] to [100, 100]",
            document.where("battery", "curve"),
            "write pairs of charge and energy, both in percent, both greater than the pair before",
        )
    return tuple((charge / 100, energy / 100) for charge, energy in points)


def _powers(points: Sequence[tuple[float, float]], key: str, document: Document) -> Points:
    for index, ((at, _), (following, _)) in enumerate(pairwise(points), 1):
        if following <= at:
            where = document.where("battery", "power_w", key, index)
            raise MissionError("the speeds do not rise", where, "sort the pairs by their speed")
    for index, (_, power_w) in enumerate(points):
        if power_w < FEWEST_W:
            where = document.where("battery", "power_w", key, index)
            raise MissionError(f"{power_w:g} W fly no vehicle", where, "write watts, e.g. 190")
    return tuple(points)
