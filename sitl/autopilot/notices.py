"""What does the autopilot tell people?

The wording is PX4's where it was seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from sitl.autopilot.failsafe_state import FailsafeState
from sitl.autopilot.failsafes import Action, BatteryLevel
from sitl.autopilot.parameters import Parameters


class Severity(IntEnum):
    """Of a notice; the values are MAV_SEVERITY."""

    EMERGENCY = 0
    CRITICAL = 2
    WARNING = 4
    INFO = 6


@dataclass(frozen=True, slots=True)
class Notice:
    """A line for people."""

    severity: Severity
    text: str


BATTERY_NOTICES = {
    BatteryLevel.LOW: Notice(Severity.CRITICAL, "Low battery"),
    BatteryLevel.CRITICAL: Notice(Severity.CRITICAL, "Critical battery"),
    BatteryLevel.EMERGENCY: Notice(Severity.EMERGENCY, "Emergency battery level"),
}


def failsafe_notices(state: FailsafeState, parameters: Parameters) -> list[Notice]:
    """What is told when another failsafe acts, or the same one in another way."""
    active = state.active
    if active is None:
        return []
    if state.is_waiting:
        hold_s = parameters["COM_FAIL_ACT_T"]
        text = f"Failsafe activated: entering Hold for {hold_s:.0f} seconds"
    elif active.action is Action.WARN:
        text = f"Failsafe warning: {active.cause.value}"
    else:
        text = f"Failsafe activated: {active.cause.value}"
    return [Notice(Severity.CRITICAL, text)]
