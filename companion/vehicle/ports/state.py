"""The state of a vehicle as it was last heard: values, each with the time that it is from.

Positions are in the mission's frame: local NED with its origin at the home position. Times are the
flight's own monotonic time in seconds, unless said otherwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from companion.geometry import Ned, NorthEast, moved

MODE_KNOWN_S = 1.5
"""Greatest age of a heartbeat, sent once a second, at which its mode counts as the present one.
With an older one no goal is reached, no mode is requested, and no control is taken back."""
EXTRAPOLATED_S = 0.2
"""Greatest age for which a position is extrapolated: by then a braking vehicle is 0.1 m short."""


class Mode(StrEnum):
    """The flight modes of PX4 that matter here; the values are their usual names."""

    MANUAL = "MANUAL"
    ALTCTL = "ALTCTL"
    POSCTL = "POSCTL"
    TAKEOFF = "AUTO.TAKEOFF"
    LOITER = "AUTO.LOITER"
    MISSION = "AUTO.MISSION"
    RTL = "AUTO.RTL"
    LAND = "AUTO.LAND"
    OFFBOARD = "OFFBOARD"
    OTHER = "OTHER"


@dataclass(frozen=True, slots=True)
class MeasuredMotion:
    """Position and velocity of a vehicle, measured together.

    Attributes:
        velocity: NED, metres per second, corrected by the change of the position
            (`velocity_bias.py`).
        received_s: when both were received.
        measured_s: when they were measured; if the autopilot does not report its clock, when they
            were received.
        boot_s: when they were measured, by the autopilot's clock.
        accuracy_m: standard deviation of the horizontal position, as the autopilot estimates it; 0
            until it is reported.
        is_drifting: the autopilot is losing its position (`position_watch.py`).
    """

    position: Ned
    velocity: Ned
    received_s: float = 0.0
    measured_s: float = 0.0
    boot_s: float = 0.0
    accuracy_m: float = 0.0
    is_drifting: bool = False

    def age_s(self, now_s: float) -> float:
        """The time since it was measured."""
        return now_s - self.measured_s

    def position_at(self, now_s: float) -> Ned:
        """Where the vehicle is by now, if it flies on at its velocity."""
        passed_s = min(max(0.0, self.age_s(now_s)), EXTRAPOLATED_S)
        return moved(self.position, self.velocity, passed_s)

    def silence_s(self, now_s: float) -> float:
        """The time since it was received."""
        return now_s - self.received_s


@dataclass(frozen=True, slots=True)
class Attitude:
    """How a vehicle is turned.

    Attributes:
        yaw_rad: heading, 0 is north, positive to the east.
        measured_s: when it was measured; if the autopilot does not report its clock, when it was
            received.
        tilt_rad: angle between the body's axis and the vertical.
        thrust_mps2: horizontal acceleration, north and east, that follows from the tilt if the
            thrust carries the vehicle's weight.
    """

    yaw_rad: float
    measured_s: float = 0.0
    tilt_rad: float = 0.0
    thrust_mps2: NorthEast = (0.0, 0.0)

    def age_s(self, now_s: float) -> float:
        """The time since it was measured."""
        return now_s - self.measured_s


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """What an autopilot says of itself once a second.

    Attributes:
        is_failsafe: the system status is critical or worse.
        received_s: when it was received.
    """

    mode: Mode
    is_armed: bool
    is_failsafe: bool
    received_s: float

    def age_s(self, now_s: float) -> float:
        """The time since it was received."""
        return now_s - self.received_s

    def is_recent(self, now_s: float) -> bool:
        """Whether its mode counts as the present one; that of an old heartbeat is unknown."""
        return self.age_s(now_s) <= MODE_KNOWN_S


@dataclass(frozen=True, slots=True)
class BatteryState:
    """What an autopilot says of its battery.

    Attributes:
        percent: remaining charge; None while unknown.
        percent_s: when the charge was last reported; meaningless while it is None.
        is_critical: the autopilot reports the charge as critical or worse.
        low_since_s: since when it reports the charge as low or worse; None while it does not.
        power_w: power drawn, voltage times current; None while one of them is not known.
    """

    percent: int | None = None
    percent_s: float = math.inf
    is_critical: bool = False
    low_since_s: float | None = None
    power_w: float | None = None


@dataclass(frozen=True, slots=True)
class VehicleState:
    """The vehicle as last heard.

    Attributes:
        heartbeat: the newest one that is believed (`control_watch.py`).
        landed_since_s: since when `is_landed` has its value.
        below_m: distance down to what is below the vehicle, by a range finder; inf if nothing is
            within its range, None if no range finder is heard.
    """

    motion: MeasuredMotion
    attitude: Attitude
    heartbeat: Heartbeat
    is_landed: bool
    landed_since_s: float = 0.0
    battery: BatteryState = BatteryState()
    below_m: float | None = None

    @property
    def is_standing(self) -> bool:
        """Whether the vehicle is on the ground and disarmed."""
        return self.is_landed and not self.heartbeat.is_armed

    @property
    def is_flying(self) -> bool:
        """Whether the vehicle is in the air and armed."""
        return self.heartbeat.is_armed and not self.is_landed
