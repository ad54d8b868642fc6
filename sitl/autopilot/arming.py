"""May the motors start, and if not, why?

PX4's arming checks as a table: a check and the reason that is told when it fails. Disarmed, every
mode may be chosen; what the mode needs is checked here, when arming (seen on PX4). A new check is
a new line. Left out: checks of sensors other than GPS, which never fail in this simulator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sitl.autopilot.failsafes import LINK_SILENT_S, BatteryLevel, Conditions
from sitl.autopilot.modes import FLIGHT_MODES


@dataclass(frozen=True, slots=True)
class Readiness:
    """What the checks look at.

    Attributes:
        missing: what the mode needs and lacks, empty if nothing.
        is_crashed: the vehicle has hit something.
        refusal: why somebody else refuses, e.g. a scenario.
    """

    mode: str
    missing: str
    conditions: Conditions
    is_crashed: bool
    refusal: str | None


def _has_ground_station(now: Readiness) -> bool:
    is_needed = now.conditions.parameters["NAV_DLL_ACT"] > 0
    return not is_needed or now.conditions.ground_station_age_s <= LINK_SILENT_S


CHECKS: tuple[tuple[Callable[[Readiness], bool], Callable[[Readiness], str]], ...] = (
    (lambda now: not now.is_crashed, lambda now: "vehicle crashed"),
    (lambda now: FLIGHT_MODES[now.mode].may_arm, lambda now: f"not in {now.mode}"),
    (lambda now: not now.missing, lambda now: now.missing),
    (lambda now: now.conditions.battery < BatteryLevel.CRITICAL, lambda now: "low battery"),
    (lambda now: not now.conditions.is_position_lost, lambda now: "GPS fix too low"),
    (lambda now: not now.conditions.is_fence_breached, lambda now: "geofence violation"),
    (_has_ground_station, lambda now: "no connection to ground control"),
    (lambda now: now.refusal is None, lambda now: str(now.refusal)),
)
"""Passes? and the reason if not."""


def objection(readiness: Readiness) -> str | None:
    """Why arming is refused, None if it is allowed."""
    return next((reason(readiness) for passes, reason in CHECKS if not passes(readiness)), None)
