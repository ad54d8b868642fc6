"""Checks the failsafe parameters that an autopilot must have before the companion arms it.

PX4's defaults leave many failsafes off: without setpoints and without a pilot the vehicle descends
where it is, and an empty battery only causes a warning. If the companion dies in flight, these
parameters are all that protects the vehicle. So weak values are refused unless the operator accepts
them. The same holds for parameters that PX4 sets well by default but somebody has changed: its
fence action, and the loss of the pilot's radio.

1. A return first climbs to RTL_RETURN_ALT above home: 30 m by default, whatever is above the
   vehicle. If the offboard loss or the fence triggers a return, this altitude must not exceed the
   mission's ceiling.
2. Besides the fence that can be uploaded, PX4 has a cylinder around home, with a radius and a
   height. If the mission may leave it, the autopilot would end the flight there.
3. A take-off climbs at least to MIS_TAKEOFF_ALT, whatever altitude is requested. This must not
   exceed the ceiling either. PX4's home is where it was last armed, so on a roof both altitudes
   count from the roof.
4. If plans account for energy, the reserve that they leave must lie above the charge at which the
   autopilot acts.

Source: PX4 v1.16, parameter reference (COM_*, GF_*, RTL_*).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

IN_OFFBOARD = 4
"""The bit of COM_RCL_EXCEPT for OFFBOARD."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """A parameter, and when its value is strong enough."""

    parameter: str
    is_strong: Callable[[float], bool]
    advice: str


REQUIREMENTS: tuple[Requirement, ...] = (
    Requirement(
        "COM_OF_LOSS_T",
        lambda value: 0.0 < value <= 1.0,
        "set 1.0 or less: seconds without setpoints until the failsafe acts",
    ),
    Requirement(
        "COM_OBL_RC_ACT",
        lambda value: value in (3, 4, 5),
        "set 5 (hold), 4 (land) or 3 (return, at RTL_RETURN_ALT): what it does then",
    ),
    Requirement(
        "COM_LOW_BAT_ACT",
        lambda value: value in (2, 3),
        "set 3 (return at RTL_RETURN_ALT, then land) or 2 (land): what it does when the battery "
        "is low",
    ),
    Requirement(
        "GF_ACTION",
        lambda value: value in (2, 3, 5),
        "set 2 (hold), 3 (return, at RTL_RETURN_ALT) or 5 (land): what it does at its own fence",
    ),
    Requirement(
        "COM_RCL_EXCEPT",
        lambda value: value.is_integer() and not int(value) & IN_OFFBOARD,
        "clear bit 2 (4): with it the loss of the pilot's radio is ignored in OFFBOARD",
    ),
)


RETURN_ALTITUDE = "RTL_RETURN_ALT"
RETURN = 3.0
RETURNING = ("COM_OBL_RC_ACT", "GF_ACTION")
"""The failsafes by which the companion may cause a return."""

FENCE_RADIUS, FENCE_HEIGHT = "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST"
TAKEOFF_ALTITUDE = "MIS_TAKEOFF_ALT"
HEADROOM_M = 0.5
"""The vehicle may exceed its ceiling by this much for a moment."""

PARAMETERS = (
    *(requirement.parameter for requirement in REQUIREMENTS),
    RETURN_ALTITUDE,
    FENCE_RADIUS,
    FENCE_HEIGHT,
    TAKEOFF_ALTITUDE,
)
"""The parameters to request."""

CRITICAL_CHARGE = "BAT_CRIT_THR"
CHARGE_MARGIN = 0.02
"""The reserve must exceed the autopilot's threshold by this much: a gauge has whole percents."""


class FlownWithin(NamedTuple):
    """The space in which a mission is flown, as compared with the autopilot's own limits.

    Attributes:
        ceiling_m: greatest altitude above home.
        away_m: greatest horizontal distance from home.
        roof_m: altitude above home of the highest place where the vehicle is armed.
    """

    ceiling_m: float
    away_m: float
    roof_m: float = 0.0

    @property
    def climb_m(self) -> float:
        """How far the vehicle may climb from where it is armed, even from the highest such
        place."""
        return self.ceiling_m - self.roof_m

    @property
    def on_roof(self) -> str:
        """Words that name the roof; "" if the vehicle is armed only on the ground."""
        return f", also from a roof of {self.roof_m:g} m" if self.roof_m else ""


def parameters_of(reserve: float | None) -> tuple[str, ...]:
    """The parameters to request.

    Args:
        reserve: the charge, 0 to 1, that plans leave; None if plans do not account for energy.
    """
    return PARAMETERS if reserve is None else (*PARAMETERS, CRITICAL_CHARGE)


def weaknesses(
    values: Mapping[str, float | None], flown: FlownWithin, reserve: float | None = None
) -> list[str]:
    """Describes each parameter that is too weak: one line each, with what to do.

    Args:
        values: the values of `parameters_of`; None for one that was not answered.
        flown: the space in which the mission stays.
        reserve: the charge, 0 to 1, that plans leave; None if plans do not account for energy.
    """
    lines = _return_above(values, flown) + _take_off_above(values, flown)
    lines += _fenced_in(values, flown)
    if reserve is not None:
        lines += _acts_before(values[CRITICAL_CHARGE], reserve)
    for requirement in REQUIREMENTS:
        value = values[requirement.parameter]
        if value is None or not requirement.is_strong(value):
            lines.append(f"{requirement.parameter} {_is_now(value)}; {requirement.advice}")
    return lines


def _return_above(values: Mapping[str, float | None], flown: FlownWithin) -> list[str]:
    """A line if a return would leave the mission's limits."""
    height_m, why = values[RETURN_ALTITUDE], [p for p in RETURNING if values[p] == RETURN]
    if not why or (height_m is not None and height_m <= flown.climb_m):
        return []
    return [
        f"{RETURN_ALTITUDE} {_is_now(height_m)}; set {flown.climb_m:g} or less: "
        f"{' and '.join(why)} 3 returns, and climbs so high first{flown.on_roof}, where the "
        f"mission stays below {flown.ceiling_m:g} m"
    ]


def _take_off_above(values: Mapping[str, float | None], flown: FlownWithin) -> list[str]:
    """A line if a take-off would leave the mission's limits."""
    height_m = values[TAKEOFF_ALTITUDE]
    if height_m is not None and height_m <= flown.climb_m:
        return []
    return [
        f"{TAKEOFF_ALTITUDE} {_is_now(height_m)}; set {flown.climb_m:g} or less: a take-off climbs "
        f"so high at least{flown.on_roof}, and the mission stays below {flown.ceiling_m:g} m "
        "(limits.up_m)"
    ]


def _fenced_in(values: Mapping[str, float | None], flown: FlownWithin) -> list[str]:
    """Lines if the autopilot's cylinder around home is smaller than the mission's limits."""
    above_m = flown.ceiling_m + HEADROOM_M
    asked = (
        (FENCE_RADIUS, flown.away_m, f"is flown up to {flown.away_m:.1f} m away (limits.fence)"),
        (FENCE_HEIGHT, above_m, f"may climb to {flown.ceiling_m:g} m (limits.up_m)"),
    )
    return [
        f"{parameter} {_is_now(values[parameter])}; set 0 (no limit) or {_rounded_up(least_m):g} "
        f"or more: so far from home the autopilot ends a flight, and the mission {does}"
        for parameter, least_m, does in asked
        if not _allows(values[parameter], least_m)
    ]


def _allows(limit_m: float | None, needed_m: float) -> bool:
    return limit_m is not None and (limit_m <= 0.0 or limit_m >= needed_m)


def _rounded_up(distance_m: float) -> float:
    """To half a metre."""
    return math.ceil(2 * distance_m) / 2


def _is_now(value: float | None) -> str:
    return "was not answered" if value is None else f"is {value:g}"


def _acts_before(critical: float | None, reserve: float) -> list[str]:
    """A line if the autopilot would end a flight that the plan still continues."""
    if critical is not None and reserve >= critical + CHARGE_MARGIN:
        return []
    least = math.ceil(100 * ((critical or 0.0) + CHARGE_MARGIN))
    return [
        f"{CRITICAL_CHARGE} {_is_now(critical)}: the autopilot ends the flight at this charge, and "
        f"the mission's reserve is {100 * reserve:.0f} % of it; set battery: reserve so that it is "
        f"{least} % or more, or the parameter lower"
    ]
