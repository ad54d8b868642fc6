"""The flight modes: what each requires, and how it starts.

`FLIGHT_MODES` says for each of PX4's mode names what the mode requires before it may be flown, and
how it starts. To add a mode, add a row.

    OFFBOARD      follow the companion's setpoint
    AUTO.TAKEOFF  climb over the present position, then AUTO.LOITER
    AUTO.LOITER   stop and hold
    AUTO.MISSION  fly the mission's items (mission_mode.py)
    AUTO.RTL      climb, fly home or to a nearer rally point, land there
    AUTO.LAND     descend over the present position
    POSCTL        without a pilot's sticks: hold horizontally, sink at 0.5 m/s (seen on PX4)
    ALTCTL        the same, but level: without a position it drifts with the wind
    DESCEND       land without a position, level; shown as AUTO.LAND

The autopilot decides when a mode is entered, and when the motors idle on the ground.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from sitl.autopilot.basic_modes import (
    DescendMode,
    HoldMode,
    LandMode,
    OffboardMode,
    PositionMode,
    TakeoffMode,
)
from sitl.autopilot.return_mode import ReturnMode
from sitl.autopilot.situation import FlightMode, Situation


class ModeRequirement(Enum):
    """What a mode may require besides a position; the value says what is missing."""

    SETPOINTS = "no offboard signal"
    PILOT = "no manual control input"
    MISSION = "no valid mission available"


@dataclass(frozen=True, slots=True)
class ModeDefinition:
    """A row of `FLIGHT_MODES`.

    Attributes:
        requirement: without it, the mode is refused in the air, and arming is refused in the mode;
            None if only a position is needed.
        start: makes the mode in flight; a mode that the simulator does not fly descends.
        may_arm: whether PX4 allows arming; it does not in modes that would land at once.
    """

    requirement: ModeRequirement | None
    start: Callable[[Situation], FlightMode]
    may_arm: bool = True


FLIGHT_MODES: dict[str, ModeDefinition] = {
    "OFFBOARD": ModeDefinition(ModeRequirement.SETPOINTS, lambda now: OffboardMode()),
    "AUTO.TAKEOFF": ModeDefinition(None, TakeoffMode.start),
    "AUTO.LOITER": ModeDefinition(None, HoldMode.start),
    "AUTO.RTL": ModeDefinition(None, ReturnMode.start, may_arm=False),
    "AUTO.LAND": ModeDefinition(None, LandMode.start, may_arm=False),
    "AUTO.MISSION": ModeDefinition(ModeRequirement.MISSION, lambda now: now.mission.start(now)),
    "POSCTL": ModeDefinition(ModeRequirement.PILOT, PositionMode.start),
    "ALTCTL": ModeDefinition(ModeRequirement.PILOT, DescendMode.without_sticks),
    "MANUAL": ModeDefinition(ModeRequirement.PILOT, DescendMode.without_sticks),
    "STABILIZED": ModeDefinition(ModeRequirement.PILOT, DescendMode.without_sticks),
    "ACRO": ModeDefinition(ModeRequirement.PILOT, DescendMode.without_sticks),
    "DESCEND": ModeDefinition(None, DescendMode.to_land, may_arm=False),
}


def missing_requirement(
    mode: str, *, has_setpoints: bool, has_mission: bool, has_position: bool
) -> str | None:
    """The missing requirement of a mode, in words; None if nothing is missing."""
    requirement = FLIGHT_MODES[mode].requirement
    is_met = {
        ModeRequirement.SETPOINTS: has_setpoints,
        ModeRequirement.MISSION: has_mission,
        ModeRequirement.PILOT: False,
    }
    if requirement is not None and not is_met[requirement]:
        return str(requirement.value)
    return None if has_position else "GPS fix too low"
