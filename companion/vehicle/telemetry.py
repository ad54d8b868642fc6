"""Keeps what the autopilot was last heard to say, as a VehicleState.

1. Positions are converted to the mission's frame (mission_frame.py).
2. Numbers that are not finite, and values that mean "not known", are never used.
3. A message is dropped if a newer one of its kind has overtaken it on the way.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.geometry import GRAVITY_MPS2, NorthEast
from companion.mavlink.framing import Message, dialect
from companion.mavlink.px4_modes import mode_name
from companion.mavlink.sequence import SequenceTracker
from companion.vehicle.autopilot_words import SPOKEN, AutopilotWords
from companion.vehicle.battery_gauge import battery_after
from companion.vehicle.boot_clock import BootClock
from companion.vehicle.heard_frame import HeardFrame
from companion.vehicle.laid_frames import LaidFrames
from companion.vehicle.mission_frame import MissionFrame
from companion.vehicle.ports.state import (
    Attitude,
    BatteryState,
    Heartbeat,
    MeasuredMotion,
    Mode,
    VehicleState,
)
from companion.vehicle.position_watch import PositionWatch
from companion.vehicle.range_below import RangeBelow
from companion.vehicle.restart_watch import RestartWatch
from companion.vehicle.velocity_bias import STILL, VelocityBias

PASSING = frozenset({*SPOKEN, "TIMESYNC"})
"""Names of messages that say nothing about the state."""
KNOWN_MODES = {mode.value: mode for mode in Mode}
MOST_TILT_RAD = math.radians(60.0)  # beyond, the thrust does not carry the weight


class Telemetry:
    """The newest values of all parts of the state.

    Args:
        laid: where missions' frames were laid before; None if that is not remembered.

    Attributes:
        frame: of the mission.
        placed: where that frame is, and whether that is certain.
        clock: the autopilot's.
        boots: how often the autopilot has restarted.
        velocity_bias: the error of the autopilot's velocity.
        accuracy_m: as in `MeasuredMotion`.
        words: what the autopilot says in words.
        wanted: names of the messages that are read.
        newest: the newest message of each kind that is part of the state, as received, by name.
    """

    def __init__(self, laid: LaidFrames | None = None) -> None:
        self.frame = MissionFrame()
        self.placed = HeardFrame(self.frame, laid, on_move=self._forget_state)
        self.clock, self.boots = BootClock(), RestartWatch()
        self.velocity_bias = VelocityBias()
        self.words = AutopilotWords()
        self.accuracy_m = 0.0
        self._order = SequenceTracker()
        self._heartbeat: Heartbeat | None = None
        self._is_landed: bool | None = None
        self._landed_since_s = -math.inf
        self._motion: MeasuredMotion | None = None  # in the autopilot's frame, as it says
        self._attitude: Attitude | None = None
        self._battery = BatteryState()
        self._position_watch = PositionWatch()
        self._range_below = RangeBelow()
        self._state: VehicleState | None = None  # of what was heard so far, once it was asked for
        self._readers: dict[str, Callable[[float, Message], None]] = {
            "HEARTBEAT": self._on_heartbeat,
            "LOCAL_POSITION_NED": self._on_position,
            "GLOBAL_POSITION_INT": self.placed.take_global,
            "GPS_GLOBAL_ORIGIN": self.placed.take_origin,
            "ATTITUDE": self._on_attitude,
            "HOME_POSITION": self.placed.take_home,
            "EXTENDED_SYS_STATE": self._on_landed,
            "BATTERY_STATUS": self._on_battery,
            "ESTIMATOR_STATUS": self._on_estimator,
            "DISTANCE_SENSOR": self._on_range,
            "TIMESYNC": self.clock.take,
            **dict.fromkeys(SPOKEN, self.words.take),
        }
        self.wanted = frozenset(self._readers)
        self.newest: dict[str, bytes] = {}

    @property
    def state(self) -> VehicleState | None:
        """The state in the mission's frame; None until all parts of it were heard."""
        if self._state is None:
            self._state = self._put_together()
        return self._state

    def _forget_state(self) -> None:
        self._state = None

    @property
    def missing(self) -> str:
        """What still has to be heard of the vehicle before a mission can begin, in words."""
        if self._heartbeat is None:
            return "no HEARTBEAT of an autopilot"
        if self._motion is None:
            return "no position (LOCAL_POSITION_NED)"
        if not self.frame.is_known:
            is_home = self.frame.is_home_known
            return "no origin (GPS_GLOBAL_ORIGIN)" if is_home else "no home (HOME_POSITION)"
        if self._attitude is None:
            return "no heading (ATTITUDE)"
        if self._is_landed is None:
            return "not whether it stands on the ground (EXTENDED_SYS_STATE)"
        return "not that it stands still, disarmed and on the ground"

    def _put_together(self) -> VehicleState | None:
        local, attitude, heartbeat = self._motion, self._attitude, self._heartbeat
        is_known = self.frame.is_known and self._is_landed is not None
        if not is_known or local is None or attitude is None or heartbeat is None:
            return None
        return VehicleState(
            self._in_mission_frame(local),
            attitude,
            heartbeat,
            self._is_landed is True,
            self._landed_since_s,
            self._battery,
            self.below_m(local.received_s),
        )

    def _in_mission_frame(self, local: MeasuredMotion) -> MeasuredMotion:
        """The motion in the mission's frame, without the error of its velocity."""
        off = STILL if self._is_landed else self.velocity_bias.at(local.received_s)
        north, east, down = local.velocity
        return MeasuredMotion(
            self.frame.position(local.position),
            (north - off[0], east - off[1], down - off[2]),
            local.received_s,
            local.measured_s,
            local.boot_s,
            self.accuracy_m,
            self._position_watch.is_drifting,
        )

    def below_m(self, now_s: float) -> float | None:
        """Distance down to what is below the vehicle; None if not known (`range_below.py`)."""
        return self._range_below.at(now_s)

    @property
    def is_flown(self) -> bool:
        """Whether the vehicle was heard to be armed or in the air."""
        return self._is_armed or self._is_landed is False

    @property
    def ground_amsl_m(self) -> float | None:
        """Altitude above mean sea level at which the vehicle stands disarmed; None if not known."""
        return self.placed.origins.altitude_m if self._is_standing else None

    @property
    def _is_armed(self) -> bool:
        return self._heartbeat is not None and self._heartbeat.is_armed

    @property
    def _is_standing(self) -> bool:
        return self._is_landed is True and not self._is_armed

    def is_news(self, now_s: float, message: Message) -> bool:
        """Whether no newer message of its kind has overtaken a message; call it once for each.

        Messages with words always count as news.
        """
        kind = message.get_type()
        is_overtaken = self._order.is_overtaken(now_s, kind, message.get_seq())
        return not is_overtaken or kind in SPOKEN

    def take(self, now_s: float, message: Message) -> None:
        """Takes a message of the autopilot that is news."""
        reader = self._readers.get(message.get_type())
        if reader is not None:
            reader(now_s, message)
            self._forget_state()
            if (kind := message.get_type()) not in PASSING:
                self.newest.pop(kind, None)  # so that they stay in the order of their arrival
                self.newest[kind] = message.get_msgbuf()

    def _on_heartbeat(self, now_s: float, message: Message) -> None:
        self._heartbeat = heartbeat_of(now_s, message)
        self.words.custom_mode = message.custom_mode

    def _on_position(self, now_s: float, message: Message) -> None:
        position = (message.x, message.y, message.z)
        velocity = (message.vx, message.vy, message.vz)
        if all(map(math.isfinite, (*position, *velocity))):
            boot_s = message.time_boot_ms / 1000
            self.velocity_bias.take(now_s, boot_s, position, velocity)
            measured_s = self.clock.measured_s(now_s, boot_s)
            self._motion = MeasuredMotion(position, velocity, now_s, measured_s, boot_s)
            self.placed.take_local(now_s, message, self._is_standing)

    def _on_attitude(self, now_s: float, message: Message) -> None:
        boot_s, angles = message.time_boot_ms / 1000, (message.roll, message.pitch, message.yaw)
        self.boots.take(now_s, boot_s)
        if not all(map(math.isfinite, angles)):
            return
        roll, pitch, yaw = angles
        tilt_rad = math.acos(math.cos(roll) * math.cos(pitch))
        thrust_mps2 = (0.0, 0.0) if self._attitude is None else self._attitude.thrust_mps2
        if tilt_rad < MOST_TILT_RAD:
            thrust_mps2 = _thrust(roll, pitch, yaw)
        measured_s = self.clock.measured_s(now_s, boot_s)
        self._attitude = Attitude(yaw, measured_s, tilt_rad, thrust_mps2)

    def _on_landed(self, now_s: float, message: Message) -> None:
        if message.landed_state == dialect.MAV_LANDED_STATE_UNDEFINED:
            return
        is_landed = message.landed_state == dialect.MAV_LANDED_STATE_ON_GROUND
        if is_landed is not self._is_landed:
            self._is_landed, self._landed_since_s = is_landed, now_s

    def _on_battery(self, now_s: float, message: Message) -> None:
        self._battery = battery_after(self._battery, now_s, message)

    def _on_estimator(self, now_s: float, message: Message) -> None:
        if math.isfinite(message.pos_horiz_accuracy):
            self.accuracy_m = message.pos_horiz_accuracy
            self._position_watch.take(now_s, self.accuracy_m)

    def _on_range(self, now_s: float, message: Message) -> None:
        tilt_rad = 0.0 if self._attitude is None else self._attitude.tilt_rad
        self._range_below.take(now_s, message, tilt_rad)

    def questions(self, now_s: float, autopilot: tuple[int, int], is_ours: bool) -> list[Message]:
        """What to ask the autopilot now: its words, and where its frame is.

        Args:
            now_s: the time.
            autopilot: system and component id.
            is_ours: a goal was pursued, so the companion may ask where the frame is.
        """
        is_flown = self._is_armed or self._is_landed is not True
        is_needed, origins = self.placed.doubt is not None, self.placed.origins
        origin = origins.due(now_s, autopilot, is_needed) if is_needed or is_ours else []
        return [*self.words.due(now_s, autopilot, is_flown), *origin]


def heartbeat_of(now_s: float, message: Message) -> Heartbeat:
    """Reads the autopilot's HEARTBEAT, received now."""
    return Heartbeat(
        KNOWN_MODES.get(mode_name(message.custom_mode) or "", Mode.OTHER),
        bool(message.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED),
        message.system_status >= dialect.MAV_STATE_CRITICAL,
        received_s=now_s,
    )


def _thrust(roll: float, pitch: float, yaw: float) -> NorthEast:
    """Horizontal acceleration of a vehicle whose thrust carries its weight: g tan(tilt)."""
    forward = -math.tan(pitch)
    right = math.tan(roll) / math.cos(pitch)
    north = forward * math.cos(yaw) - right * math.sin(yaw)
    east = forward * math.sin(yaw) + right * math.cos(yaw)
    return (GRAVITY_MPS2 * north, GRAVITY_MPS2 * east)
