"""What the acting side knows of a vehicle: a state it can read, goals it can set.

Positions are in the mission's frame: local NED with its origin at the home position. Time is
the vehicle's own scaled monotonic time, in seconds. `offboard.py` fulfils the port over
MAVLink; tests fulfil it with a kinematic fake.
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
from companion.outcomes import Refusal
from companion.vehicle.camera_port import Cameras
from companion.vehicle.gimbal_port import Gimbals
from companion.vehicle.outcome import Failed as Failed
from companion.vehicle.outcome import Outcome as Outcome
from companion.vehicle.outcome import Progress as Progress
from companion.vehicle.store_port import AutopilotFence, AutopilotRally

MODE_KNOWN_S = 1.5
"""Age of the newest heartbeat, sent once a second, up to which its mode is taken for the present
one. With an older one no goal is reached, no mode is asked for, and no control is taken back."""


class Mode(StrEnum):
    """Flight modes of PX4 that matter here; the value is how people know them."""

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
    """What decides where the origin of the mission's frame, and so home, lies."""

    BY_VEHICLE = "where the vehicle stands when its first sortie begins"
    FIXED = "the mission, or an earlier sortie of this program"
    RECALLED = "the earlier flights of another program"


@dataclass(frozen=True, slots=True)
class VehicleState:
    """The vehicle as last heard.

    Attributes:
        stamp_s: when the position was received.
        position: in the mission's frame.
        velocity: NED, metres per second, by what the position does (`velocity_bias.py`).
        yaw_rad: heading, 0 is north, positive to the east.
        is_failsafe: the autopilot reports a critical system status.
        battery_percent: remaining charge, None while unknown.
        mode_s: when the mode was received; an old one is not known any more.
        landed_since_s: since when it is, or is not, landed.
        measured_s: when the position and the velocity were measured, by the autopilot's clock.
        tilt_rad: angle between the body's axis and the vertical.
        thrust_mps2: horizontal acceleration, north and east, that the tilt of a vehicle stands for
            whose thrust carries its weight.
        accuracy_m: standard deviation of the horizontal position, as the autopilot estimates it; 0
            while it says nothing of that.
        position_s: when the position was measured, by our clock; where the autopilot does not tell
            its own, when it was received.
        yaw_s: the same of the heading.
        is_battery_critical: the charge is critical, or worse, by the autopilot's own word.
        is_drifting: the autopilot is losing its position (`position_watch.py`).
        battery_s: when the charge was told last; for a charge that is None of no account.
        battery_low_since_s: since when the charge is low, or worse, by the autopilot's own word;
            inf while it is not.
        power_w: what the battery gives, by voltage and current; None while one is not known.
        below_m: from the vehicle down to what is below it, by a range finder; inf where nothing is
            within its range, None while none is heard.
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
        """Whether the mode is that of a recent heartbeat."""
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
    """Where the frames lie on the earth.

    Attributes:
        origin: of the autopilot's local frame.
        zero: the origin of the mission's frame.
        is_asked_for: the mission says where it lies; else it lies where the vehicle began.
        residual_m: between what the autopilot says of its position in both ways.
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
    """Somebody else controls the vehicle.

    Attributes:
        mode: the mode that was chosen.
        is_failsafe: a failsafe of the autopilot has chosen it; else it was the pilot.

    >>> print(Takeover(Mode.POSCTL, is_failsafe=False))
    the pilot has control, in POSCTL
    """

    mode: Mode
    is_failsafe: bool

    def __str__(self) -> str:
        who = "a failsafe of the autopilot" if self.is_failsafe else "the pilot"
        return f"{who} has control, in {self.mode.value}"


class Payloads(Protocol):
    """The payloads of a vehicle: what skills command."""

    def number(self, command: str) -> int | None:
        """The number of a MAV_CMD; None if there is no command of that name."""

    def send(
        self, component: int, command: int, parameters: tuple[float, ...], timeout_s: float | None
    ) -> int:
        """Start a MAVLink command to a component; returns a ticket for `outcome`.

        Without a final answer within `timeout_s` the command has failed; without `timeout_s` the
        command protocol says how long to wait.
        """

    def outcome(self, ticket: int) -> Outcome:
        """How far the command of a ticket has come."""

    def leave(self, ticket: int) -> None:
        """Send a command no more for now; its answer still counts."""

    def come_back(self, ticket: int) -> None:
        """Wait again for a command that was left."""

    def forget(self, ticket: int) -> None:
        """Do not ask for a command any longer.

        While its component is at work on it, no other one with its number is sent there.
        """


@dataclass(frozen=True, slots=True)
class MarkerSighting:
    """A landing marker, as it was seen once.

    Attributes:
        seen_s: when.
        component: by whom.
        number: that was read off it.
        position: where, in the mission's frame.
    """

    seen_s: float
    component: int
    number: int
    position: Ned


class Markers(Protocol):
    """What is seen of landing markers."""

    @property
    def seen(self) -> Sequence[MarkerSighting]:
        """Sightings since the tick before, in order."""

    @property
    def refused(self) -> Sequence[Refusal]:
        """Why others were not taken, in the same time."""


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
        """What skills command."""

    @property
    def markers(self) -> Markers:
        """What is seen of landing markers."""

    @property
    def cameras(self) -> Cameras:
        """Its cameras."""

    @property
    def gimbals(self) -> Gimbals:
        """Its gimbals."""

    @property
    def state(self) -> VehicleState | None:
        """The newest state, None until one has been heard."""

    @property
    def scans(self) -> Sequence[RangeScan]:
        """What was heard of the surroundings since the tick before, in order."""

    @property
    def takeover(self) -> Takeover | None:
        """Who has taken control from us (the pilot wins); None while it is ours."""

    @property
    def is_doubted(self) -> bool:
        """Whether control may just have been taken from us; nothing is sent until that is known."""

    @property
    def has_restarted(self) -> bool:
        """Whether the autopilot has restarted since its first goal."""

    @property
    def frame_doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is not known or not certain; None if it is."""

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame lies on the earth; None where frames are not known."""

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames lie on the earth; None where that is not known."""

    @property
    def refusal(self) -> Refusal | None:
        """Why the vehicle is sent a hold in place of the setpoint; None while it is not."""

    @property
    def anchoring(self) -> Anchoring:
        """What decides where home lies."""

    def gap_m(self, place: Ned) -> float | None:
        """How far from a place the vehicle stands on the ground; None until that is certain."""

    @property
    def is_settling(self) -> bool:
        """Whether it is measured where the vehicle stands: its position is averaged."""

    def stand_at(self, place: Ned) -> None:
        """The vehicle stands at a place, where the mission's map begins to be true."""

    def parameter(self, name: str) -> float | None:
        """A parameter of the autopilot; asks for it, and is None until it was answered."""

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        """Work towards a goal; call it every tick while the outcome is RUNNING.

        A take-off leads to an altitude above home, the mission's own if none is said.
        """

    def fly(self, setpoint: Setpoint, is_for_task: bool = False, is_landing: bool = False) -> None:
        """The setpoint to stream from now on.

        It may be of the task's plan; and of the way down to a marker, or up from there.
        """

    def keep_within(self, fence: KeptFence) -> None:
        """Fly nowhere outside a fence from now on, whatever is asked for."""

    def release(self) -> None:
        """Stream nothing and ask for nothing any longer."""

    def regain(self) -> None:
        """The operator has given control back after it was lost."""
