"""The acting side's interface to a vehicle: a state to read, goals to set, setpoints to stream.

Positions are in the mission's frame: local NED with its origin at the home position. Time is the
vehicle's own scaled monotonic time, in seconds. `offboard.py` implements the port over MAVLink;
tests implement it with a kinematic fake.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, StrEnum
from typing import Protocol

from companion.geofence import KeptFence
from companion.geometry import GlobalOrigin, Ned, NorthEast
from companion.motion.range_scan import RangeScan
from companion.outcomes import Outcome, Refusal
from companion.vehicle.camera_port import Cameras
from companion.vehicle.gimbal_port import Gimbals
from companion.vehicle.store_port import AutopilotFence, AutopilotRally

MODE_KNOWN_S = 1.5
"""Greatest age of a heartbeat, sent once a second, at which its mode counts as the present one.
With an older one no goal is reached, no mode is requested, and no control is taken back."""


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


class Anchoring(Enum):
    """What determines where the origin of the mission's frame, and so home, is."""

    BY_VEHICLE = "where the vehicle stands when its first sortie begins"
    FIXED = "the mission, or an earlier sortie of this program"
    RECALLED = "the earlier flights of another program"


@dataclass(frozen=True, slots=True)
class VehicleState:
    """The vehicle as last heard.

    Attributes:
        stamp_s: when the position was received.
        position: in the mission's frame.
        velocity: NED, metres per second, corrected by the change of the position
            (`velocity_bias.py`).
        yaw_rad: heading, 0 is north, positive to the east.
        is_failsafe: the autopilot reports a critical system status.
        battery_percent: remaining charge, None while unknown.
        mode_s: when the mode was received; an old mode counts as unknown.
        landed_since_s: since when `is_landed` has its value.
        measured_s: when position and velocity were measured, by the autopilot's clock.
        tilt_rad: angle between the body's axis and the vertical.
        thrust_mps2: horizontal acceleration, north and east, that follows from the tilt if the
            thrust carries the vehicle's weight.
        accuracy_m: standard deviation of the horizontal position, as the autopilot estimates it; 0
            until it is reported.
        position_s: when the position was measured, by our clock; if the autopilot does not report
            its clock, when it was received.
        yaw_s: the same for the heading.
        is_battery_critical: the autopilot reports the charge as critical or worse.
        is_drifting: the autopilot is losing its position (`position_watch.py`).
        battery_s: when the charge was last reported; meaningless while it is None.
        battery_low_since_s: since when the autopilot reports the charge as low or worse; inf while
            it does not.
        power_w: power drawn, voltage times current; None while one of them is not known.
        below_m: distance down to what is below the vehicle, by a range finder; inf if nothing is
            within its range, None if no range finder is heard.
    """

    stamp_s: float
    position: Ned
    velocity: Ned
    yaw_rad: float
    mode: Mode
    is_armed: bool
    is_landed: bool
    is_failsafe: bool
    battery_percent: int | None
    mode_s: float = 0.0
    landed_since_s: float = 0.0
    measured_s: float = 0.0
    tilt_rad: float = 0.0
    thrust_mps2: NorthEast = (0.0, 0.0)
    accuracy_m: float = 0.0
    position_s: float = 0.0
    yaw_s: float = 0.0
    is_battery_critical: bool = False
    is_drifting: bool = False
    battery_s: float = math.inf
    battery_low_since_s: float = math.inf
    power_w: float | None = None
    below_m: float | None = None

    def is_mode_known(self, now_s: float) -> bool:
        """Whether the mode comes from a recent heartbeat."""
        return now_s - self.mode_s <= MODE_KNOWN_S


@dataclass(frozen=True, slots=True)
class Setpoint:
    """Where to be, how fast to move there, and how the speed changes.

    Attributes:
        velocity, acceleration: fed forward, so that the vehicle does not lag behind.
        yaw_rad: the heading to hold.
    """

    position: Ned
    velocity: Ned
    acceleration: Ned
    yaw_rad: float


def hold_at(position: Ned, yaw_rad: float) -> Setpoint:
    """The setpoint of a vehicle that stays where it is."""
    return Setpoint(position, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), yaw_rad)


@dataclass(frozen=True, slots=True)
class FrameLocation:
    """Where the frames are on the earth.

    Attributes:
        origin: that of the autopilot's local frame.
        zero: the origin of the mission's frame.
        is_asked_for: the mission gives its origin; otherwise it is where the vehicle began.
        residual_m: distance between the autopilot's local and global reports of its position.
    """

    origin: GlobalOrigin
    zero: GlobalOrigin
    is_asked_for: bool
    residual_m: float


class Goal(StrEnum):
    """A state of the vehicle to bring about; it is reached when it is observed."""

    ARMED = "armed"
    AIRBORNE = "airborne"
    OFFBOARD = "in OFFBOARD"
    HOLDING = "holding"
    LANDED = "landed and disarmed"


@dataclass(frozen=True, slots=True)
class Takeover:
    """Somebody else has control of the vehicle.

    Attributes:
        mode: the mode that they chose.
        is_failsafe: a failsafe of the autopilot chose it; otherwise it was the pilot.

    >>> print(Takeover(Mode.POSCTL, is_failsafe=False))
    the pilot has control, in POSCTL
    """

    mode: Mode
    is_failsafe: bool

    def __str__(self) -> str:
        who = "a failsafe of the autopilot" if self.is_failsafe else "the pilot"
        return f"{who} has control, in {self.mode.value}"


class Payloads(Protocol):
    """The payloads of a vehicle, which skills command."""

    def number(self, command: str) -> int | None:
        """The number of a MAV_CMD; None if there is no command of that name."""

    def send(
        self, component: int, command: int, parameters: tuple[float, ...], timeout_s: float | None
    ) -> int:
        """Start a MAVLink command to a component; returns a ticket for `outcome`.

        The command fails without a final answer within `timeout_s`; if that is None, the command
        protocol determines how long to wait.
        """

    def outcome(self, ticket: int) -> Outcome:
        """How far the command of a ticket has come."""

    def leave(self, ticket: int) -> None:
        """Stop sending a command for now; its answer still counts."""

    def come_back(self, ticket: int) -> None:
        """Resume a command that was left."""

    def forget(self, ticket: int) -> None:
        """Drop a command.

        While its component still works on it, no other command with its number is sent there.
        """


@dataclass(frozen=True, slots=True)
class MarkerSighting:
    """One sighting of a landing marker.

    Attributes:
        seen_s: when it was seen.
        component: the component that saw it.
        number: the number on the marker.
        position: of the marker, in the mission's frame.
    """

    seen_s: float
    component: int
    number: int
    position: Ned


class Markers(Protocol):
    """Sightings of landing markers."""

    @property
    def seen(self) -> Sequence[MarkerSighting]:
        """Sightings since the previous tick, in order."""

    @property
    def refused(self) -> Sequence[Refusal]:
        """Why others were refused in the same time."""


class Vehicle(Protocol):
    """A vehicle that the acting side flies."""

    @property
    def fence(self) -> AutopilotFence:
        """The fence of its autopilot."""

    @property
    def rally(self) -> AutopilotRally:
        """The rally points of its autopilot."""

    @property
    def payloads(self) -> Payloads:
        """The payloads that skills command."""

    @property
    def markers(self) -> Markers:
        """Sightings of landing markers."""

    @property
    def cameras(self) -> Cameras:
        """Its cameras."""

    @property
    def gimbals(self) -> Gimbals:
        """Its gimbals."""

    @property
    def state(self) -> VehicleState | None:
        """The newest state; None until one has been heard."""

    @property
    def scans(self) -> Sequence[RangeScan]:
        """Range scans heard since the previous tick, in order."""

    @property
    def takeover(self) -> Takeover | None:
        """Who has taken control from us (the pilot wins); None while it is ours."""

    @property
    def is_doubted(self) -> bool:
        """Whether control may just have been taken from us; nothing is sent until that is
        decided."""

    @property
    def has_restarted(self) -> bool:
        """Whether the autopilot has restarted since the first goal."""

    @property
    def frame_doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is unknown or uncertain; None if it is
        certain."""

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame is on the earth; None while frames are not known."""

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames are on the earth; None if not known."""

    @property
    def refusal(self) -> Refusal | None:
        """Why a hold is sent in place of the setpoint; None if none is."""

    @property
    def anchoring(self) -> Anchoring:
        """What determines where home is."""

    def gap_m(self, place: Ned) -> float | None:
        """How far from a place the vehicle stands on the ground; None until that is certain."""

    @property
    def is_settling(self) -> bool:
        """Whether the position of the standing vehicle is being averaged."""

    def stand_at(self, place: Ned) -> None:
        """Declare that the vehicle stands at a place, from where the mission's map is valid."""

    def parameter(self, name: str) -> float | None:
        """A parameter of the autopilot; requests it, and returns None until it was answered."""

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        """Work towards a goal; call it every tick while the outcome is RUNNING.

        A take-off leads to `takeoff_up_m` above home; None stands for the mission's own altitude.
        """

    def fly(
        self, setpoint: Setpoint, *, is_for_task: bool = False, is_landing: bool = False
    ) -> None:
        """Stream a setpoint from now on.

        The flags say whether it belongs to the task's plan, and to the descent to a marker or the
        climb from it.
        """

    def keep_within(self, fence: KeptFence) -> None:
        """Refuse every setpoint outside a fence from now on."""

    def release(self) -> None:
        """Stop streaming, and stop all requests."""

    def regain(self) -> None:
        """Take back control, which the operator has given back after it was lost."""
