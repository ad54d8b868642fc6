"""PX4's arming checks as a table: each check, and the reason that is given when it fails.

Disarmed, every mode may be chosen; its requirement is checked here, on arming (as in PX4). To add a
check, add a row. Left out: checks of sensors other than GPS, which never fail in this simulator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sitl.autopilot.failsafes import LINK_SILENT_S, BatteryLevel, FailsafeInputs
from sitl.autopilot.modes import FLIGHT_MODES, ModeRequirement


@dataclass(frozen=True, slots=True)
class PreflightState:
    """The inputs of the checks.

    Attributes:
        missing: the requirement that the mode lacks; None if nothing is missing.
        is_crashed: the vehicle has hit something.
        refusal: the reason for which the scenario refuses arming; None if it does not.
    """

    mode: str
    missing: str | None
    inputs: FailsafeInputs
    is_crashed: bool
    refusal: str | None


def _has_ground_station(now: PreflightState) -> bool:
    is_needed = now.inputs.parameters["NAV_DLL_ACT"] > 0
    return not is_needed or now.inputs.ground_station_age_s <= LINK_SILENT_S


ArmingCheck = tuple[Callable[[PreflightState], bool], Callable[[PreflightState], str]]
"""A check, true if it passes, and the reason if it fails."""

ARMING_CHECKS: tuple[ArmingCheck, ...] = (
    (lambda now: not now.is_crashed, lambda now: "vehicle crashed"),
    (lambda now: FLIGHT_MODES[now.mode].may_arm, lambda now: f"not in {now.mode}"),
    (lambda now: now.missing is None, lambda now: str(now.missing)),
    (lambda now: now.inputs.battery < BatteryLevel.CRITICAL, lambda now: "low battery"),
    (lambda now: not now.inputs.is_position_lost, lambda now: "GPS fix too low"),
    (lambda now: not now.inputs.is_fence_breached, lambda now: "geofence violation"),
    (_has_ground_station, lambda now: "no connection to ground control"),
    (lambda now: now.refusal is None, lambda now: str(now.refusal)),
)


REASONS = (
    "vehicle crashed",
    *(f"not in {name}" for name, mode in FLIGHT_MODES.items() if not mode.may_arm),
    *(requirement.value for requirement in ModeRequirement),
    "low battery",
    "GPS fix too low",
    "geofence violation",
    "no connection to ground control",
)
"""All reasons but those of scenarios."""


def arming_denials(now: PreflightState) -> tuple[str, ...]:
    """The reasons why arming is denied, each once; empty if it is allowed."""
    failed = (reason(now) for passes, reason in ARMING_CHECKS if not passes(now))
    return tuple(dict.fromkeys(failed))
