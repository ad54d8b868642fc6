"""What does the vehicle do in each flight mode?

`FLIGHT_MODES` says for each of PX4's mode names what the mode needs before it may be flown, and
how it starts. A new mode is a new line there.

    OFFBOARD      follow the companion's setpoint
    AUTO.TAKEOFF  climb over the present position, then AUTO.LOITER
    AUTO.LOITER   stop and hold
    AUTO.MISSION  fly the mission's items (mission.py)
    AUTO.RTL      climb, fly home, land there
    AUTO.LAND     descend over the present position
    POSCTL        without a pilot's sticks: hold horizontally, sink at 0.5 m/s (seen on PX4)
    ALTCTL        the same, but level: without a position it drifts with the wind
    DESCEND       land without a position, level; shown as AUTO.LAND

The autopilot decides when a mode is entered, and when motors idle on the ground.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from sitl.autopilot.basic_modes import Descend, Hold, Land, Offboard, SinkWithoutPilot, Takeoff
from sitl.autopilot.return_mode import Return
from sitl.autopilot.situation import FlightMode, Situation


class Need(Enum):
    """What a mode needs before it may be flown; the value says what is missing."""

    NOTHING = ""
    SETPOINTS = "no offboard signal"
    PILOT = "no manual control input"
    MISSION = "no valid mission available"


@dataclass(frozen=True, slots=True)
class ModeEntry:
    """A line of `FLIGHT_MODES`.

    Attributes:
        need: without it the mode is refused in the air, and arming in it.
        start: the mode in flight; a mode that cannot be flown here yet sinks.
        may_arm: PX4 refuses arming in modes that would land at once.
    """

    need: Need
    start: Callable[[Situation], FlightMode]
    may_arm: bool = True


FLIGHT_MODES: dict[str, ModeEntry] = {
    "OFFBOARD": ModeEntry(Need.SETPOINTS, lambda now: Offboard()),
    "AUTO.TAKEOFF": ModeEntry(Need.NOTHING, Takeoff.start),
    "AUTO.LOITER": ModeEntry(Need.NOTHING, Hold.start),
    "AUTO.RTL": ModeEntry(Need.NOTHING, Return.start, may_arm=False),
    "AUTO.LAND": ModeEntry(Need.NOTHING, Land.start, may_arm=False),
    "AUTO.MISSION": ModeEntry(Need.MISSION, lambda now: now.mission.start(now)),
    "POSCTL": ModeEntry(Need.PILOT, SinkWithoutPilot.start),
    "ALTCTL": ModeEntry(Need.PILOT, Descend.without_pilot),
    "MANUAL": ModeEntry(Need.PILOT, Descend.without_pilot),
    "STABILIZED": ModeEntry(Need.PILOT, Descend.without_pilot),
    "ACRO": ModeEntry(Need.PILOT, Descend.without_pilot),
    "DESCEND": ModeEntry(Need.NOTHING, Descend.to_land, may_arm=False),
}
