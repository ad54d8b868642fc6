"""The failsafe parameters that an autopilot must have before a companion arms it.

PX4's own defaults leave much of this off: without setpoints and without a pilot it sinks to the
ground where it is, and an empty battery only warns. A companion that dies in flight relies on
these parameters, so weak ones are refused unless the operator accepts them. So are others that PX4
sets well by default, where they were changed: its fence, and the loss of the pilot's radio.

A return climbs first, to RTL_RETURN_ALT above home: 30 m by default, whatever is above the vehicle.
Where the offboard loss or the fence makes it return, that must not be above the mission's ceiling.

Besides the fence that can be uploaded PX4 has a cylinder about home, of a radius and a height.
Where the mission may be flown beyond it, the autopilot would end the flight there.

A take-off climbs to MIS_TAKEOFF_ALT at least, whatever altitude is asked for: that must not be
above the ceiling either. A PX4's home is where it was armed last: on a roof both begin there.

Where plans know of energy, what they leave lies above the charge at which the autopilot acts.

Source: PX4 v1.16, parameter reference (COM_*, GF_*, RTL_*).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

IN_OFFBOARD = 4
"""The bit of COM_RCL_EXCEPT that stands for OFFBOARD."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """One parameter, and when it is strong enough."""

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
"""What may make the vehicle return because of the companion."""

FENCE_RADIUS, FENCE_HEIGHT = "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST"
TAKEOFF_ALTITUDE = "MIS_TAKEOFF_ALT"
HEADROOM_M = 0.5
"""So far above its ceiling a vehicle may climb for a moment."""

PARAMETERS = (
    *(requirement.parameter for requirement in REQUIREMENTS),
    RETURN_ALTITUDE,
    FENCE_RADIUS,
    FENCE_HEIGHT,
    TAKEOFF_ALTITUDE,
)
"""What has to be asked for."""

CRITICAL_CHARGE = "BAT_CRIT_THR"
CHARGE_MARGIN = 0.02
"""So much more than what the autopilot acts at a reserve has to be: a gauge has whole percents."""


class FlownWithin(NamedTuple):
    """What a mission is flown in, as far as the autopilot's own limits are compared with it.

    Attributes:
        ceiling_m: greatest altitude above home.
        away_m: how far it is flown away from home, over the ground.
        roof_m: altitude above home of the highest place where the vehicle is armed.
    """

    ceiling_m: float
    away_m: float
    roof_m: float = 0.0

    @property
    def climb_m(self) -> float:
        """So far the vehicle may climb straight up from where it is armed, wherever that is."""
        return self.ceiling_m - self.roof_m

    @property
    def on_roof(self) -> str:
        """From where that is, in words; "" from the ground."""
        return f", also from a roof of {self.roof_m:g} m" if self.roof_m else ""


def parameters_of(reserve: float | None) -> tuple[str, ...]:
    """What has to be asked for.

    Args:
        reserve: the charge, 0 to 1, that plans leave; None where they know of none.
    """
    return PARAMETERS if reserve is None else (*PARAMETERS, CRITICAL_CHARGE)


def weaknesses(
    values: Mapping[str, float | None], flown: FlownWithin, reserve: float | None = None
) -> list[str]:
    """What is too weak, a line each with what to do.

    Args:
        values: of `parameters_of`; None is one that was not answered.
        flown: in what the mission stays.
        reserve: the charge, 0 to 1, that plans leave; None where they know of none.
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
    """That a return would leave the mission's limits, if it would."""
    height_m, why = values[RETURN_ALTITUDE], [p for p in RETURNING if values[p] == RETURN]
    if not why or (height_m is not None and height_m <= flown.climb_m):
        return []
    return [
        f"{RETURN_ALTITUDE} {_is_now(height_m)}; set {flown.climb_m:g} or less: "
        f"{' and '.join(why)} 3 returns, and climbs so high first{flown.on_roof}, where the "
        f"mission stays below {flown.ceiling_m:g} m"
    ]


def _take_off_above(values: Mapping[str, float | None], flown: FlownWithin) -> list[str]:
    """That a take-off would leave the mission's limits, if it would."""
    height_m = values[TAKEOFF_ALTITUDE]
    if height_m is not None and height_m <= flown.climb_m:
        return []
    return [
        f"{TAKEOFF_ALTITUDE} {_is_now(height_m)}; set {flown.climb_m:g} or less: a take-off climbs "
        f"so high at least{flown.on_roof}, and the mission stays below {flown.ceiling_m:g} m "
        "(limits.up_m)"
    ]


def _fenced_in(values: Mapping[str, float | None], flown: FlownWithin) -> list[str]:
    """That the autopilot's own cylinder about home ends within the mission's limits, if it does."""
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
    """That the autopilot would end a flight that plans still go on with, if it would."""
    if critical is not None and reserve >= critical + CHARGE_MARGIN:
        return []
    least = math.ceil(100 * ((critical or 0.0) + CHARGE_MARGIN))
    return [
        f"{CRITICAL_CHARGE} {_is_now(critical)}: the autopilot ends the flight at this charge, and "
        f"the mission's reserve is {100 * reserve:.0f} % of it; set battery: reserve so that it is "
        f"{least} % or more, or the parameter lower"
    ]
