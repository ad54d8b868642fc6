"""The autopilot's status texts for people.

The wording is PX4's where it was seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from sitl.autopilot.failsafe_state import FailsafeStage, FailsafeState
from sitl.autopilot.failsafes import BatteryLevel
from sitl.autopilot.parameters import Parameters


class Severity(IntEnum):
    """The severity of a status text; the values are MAV_SEVERITY."""

    EMERGENCY = 0
    CRITICAL = 2
    WARNING = 4
    INFO = 6


@dataclass(frozen=True, slots=True)
class StatusText:
    """A line for people, sent as STATUSTEXT."""

    severity: Severity
    text: str


BATTERY_TEXTS = {
    BatteryLevel.LOW: StatusText(Severity.CRITICAL, "Low battery"),
    BatteryLevel.CRITICAL: StatusText(Severity.CRITICAL, "Critical battery"),
    BatteryLevel.EMERGENCY: StatusText(Severity.EMERGENCY, "Emergency battery level"),
}


def failsafe_texts(state: FailsafeState, parameters: Parameters) -> list[StatusText]:
    """The texts when another action is selected, or its stage changes."""
    selected = state.selected
    if selected is None:
        return []
    if state.stage is FailsafeStage.DELAYED:
        hold_s = parameters["COM_FAIL_ACT_T"]
        text = f"Failsafe activated: entering Hold for {hold_s:.0f} seconds"
    elif state.stage is FailsafeStage.WARNING:
        text = f"Failsafe warning: {selected.cause.value}"
    else:
        text = f"Failsafe activated: {selected.cause.value}"
    return [StatusText(Severity.CRITICAL, text)]
