"""May the motors start, and if not, why?

PX4's arming checks as a table: a check and the reason that is told when it fails. Disarmed, every
mode may be chosen; what the mode needs is checked here, when arming (seen on PX4). A new check is
a new line. Left out: checks of sensors and estimators, which never fail in this simulator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sitl.autopilot.failsafes import BatteryLevel
from sitl.autopilot.modes import FLIGHT_MODES


@dataclass(frozen=True, slots=True)
class Readiness:
    """What the checks look at.

    Attributes:
        missing: what the mode needs and lacks, empty if nothing.
        is_crashed: the vehicle has hit something.
    """

    mode: str
    missing: str
    battery: BatteryLevel
    is_crashed: bool


CHECKS: tuple[tuple[Callable[[Readiness], bool], Callable[[Readiness], str]], ...] = (
    (lambda now: not now.is_crashed, lambda now: "vehicle crashed"),
    (lambda now: FLIGHT_MODES[now.mode].may_arm, lambda now: f"not in {now.mode}"),
    (lambda now: not now.missing, lambda now: now.missing),
    (lambda now: now.battery < BatteryLevel.CRITICAL, lambda now: "low battery"),
)
"""Passes? and the reason if not."""


def objection(readiness: Readiness) -> str | None:
    """Why arming is refused, None if it is allowed."""
    return next((reason(readiness) for passes, reason in CHECKS if not passes(readiness)), None)
