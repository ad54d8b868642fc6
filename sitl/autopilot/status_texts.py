"""The autopilot's texts for people; some of them are also events.

The wording is PX4's where it was observed. An event is a template with arguments, `{1}` or
`{1:.0}`; `TEMPLATES` lists them all. Left out: events that are less than a warning.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from sitl.autopilot.failsafe_state import FailsafeStage, FailsafeState
from sitl.autopilot.failsafes import BatteryLevel
from sitl.autopilot.parameters import Parameters


class Severity(IntEnum):
    """The severity of a status text; the values are MAV_SEVERITY."""

    EMERGENCY = 0
    CRITICAL = 2
    WARNING = 4
    INFO = 6


class ToldEvent(NamedTuple):
    """A row of `TEMPLATES` with its arguments."""

    template: str
    arguments: tuple[str | float, ...] = ()

    @property
    def text(self) -> str:
        """The text of the event."""

        def filled(slot: re.Match[str]) -> str:
            argument = self.arguments[int(slot[1]) - 1]
            return argument if isinstance(argument, str) else f"{argument:{slot[2]}f}"

        return re.sub(r"\{(\d):?([^}]*)\}", filled, self.template)


@dataclass(frozen=True, slots=True)
class StatusText:
    """A text for people, sent as STATUSTEXT, and also as EVENT if it has one."""

    severity: Severity
    text: str
    event: ToldEvent | None = None


WORD, FLOAT = "word", "float"
TEMPLATES: dict[str, tuple[str, ...]] = {
    "Arming denied: {1}": (WORD,),
    "Low battery": (),
    "Critical battery": (),
    "Emergency battery level": (),
    "Failsafe activated: entering Hold for {1:.0} seconds": (FLOAT,),
    "Failsafe warning: {1}": (WORD,),
    "Failsafe activated: {1}": (WORD,),
    "Geofence invalid, doesn't contain Home position": (),
    "Geofence invalid, doesn't contain current vehicle position": (),
}
"""Template of an event -> the types of its arguments."""


def told(severity: Severity, template: str, *arguments: str | float) -> StatusText:
    """A text for people that is also an event."""
    event = ToldEvent(template, arguments)
    return StatusText(severity, event.text, event)


BATTERY_TEXTS = {
    BatteryLevel.LOW: told(Severity.CRITICAL, "Low battery"),
    BatteryLevel.CRITICAL: told(Severity.CRITICAL, "Critical battery"),
    BatteryLevel.EMERGENCY: told(Severity.EMERGENCY, "Emergency battery level"),
}


def failsafe_texts(state: FailsafeState, parameters: Parameters) -> list[StatusText]:
    """The texts when another failsafe action is selected, or when its stage changes."""
    selected = state.selected
    if selected is None:
        return []
    if state.stage is FailsafeStage.DELAYED:
        delayed = "Failsafe activated: entering Hold for {1:.0} seconds"
        return [told(Severity.CRITICAL, delayed, parameters["COM_FAIL_ACT_T"])]
    is_warning = state.stage is FailsafeStage.WARNING
    template = "Failsafe warning: {1}" if is_warning else "Failsafe activated: {1}"
    return [told(Severity.CRITICAL, template, selected.cause.value)]
