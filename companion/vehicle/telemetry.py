"""Keeps what the autopilot was last heard to say, as a VehicleState.

1. Positions are converted to the mission's frame (mission_frame.py).
2. Numbers that are not finite, and values that mean "not known", are never used.
3. A message is dropped if a newer one of its kind has overtaken it on the way.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.geometry import GRAVITY_MPS2, GlobalOrigin, Ned, NorthEast
from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.px4_modes import mode_name
from companion.mavlink.sequence import SequenceTracker
from companion.outcomes import Refusal
from companion.vehicle.autopilot_words import SPOKEN, AutopilotWords
from companion.vehicle.battery_gauge import BatteryGauge
from companion.vehicle.boot_clock import BootClock
from companion.vehicle.control_watch import Heartbeat
from companion.vehicle.laid_frames import LaidFrames
from companion.vehicle.mission_frame import MissionFrame
from companion.vehicle.origin_watch import OriginWatch
from companion.vehicle.port import FrameLocation, Mode, VehicleState
from companion.vehicle.position_watch import PositionWatch
from companion.vehicle.range_below import RangeBelow
from companion.vehicle.restart_watch import RestartWatch
from companion.vehicle.velocity_bias import STILL, VelocityBias

KNOWN_MODES = {mode.value: mode for mode in Mode}
MOST_TILT_RAD = math.radians(60.0)  # beyond, the thrust does not carry the weight


class Telemetry:
    """The newest values of all parts of the state.

    Args:
        laid: where missions' frames were laid before; None if that is not remembered.

    Attributes:
        frame: of the mission.
        origins: where the autopilot's local frame is on the earth.
        clock: the autopilot's.
        boots: how often the autopilot has restarted.
        velocity_bias: the error of the autopilot's velocity.
        heartbeat_s: when the newest heartbeat was heard.
        accuracy_m: as in VehicleState.
        words: what the autopilot says in words.
    """

    def __init__(self, laid: LaidFrames | None = None) -> None:
        self.frame = MissionFrame()
        self._laid, self._system = laid, 0
        self.origins = OriginWatch()
        self.clock, self.boots = BootClock(), RestartWatch()
        self.velocity_bias = VelocityBias()
        self.words = AutopilotWords()
        self.heartbeat_s = -math.inf
        self.mode: Mode | None = None
        self._order = SequenceTracker()
        self.is_armed = self.is_failsafe = False
        self._is_landed: bool | None = None
        self._landed_since_s = -math.inf
        self._position: tuple[float, Ned, Ned] | None = None  # stamp, position, velocity
        self._yaw_rad: float | None = None
        self._position_s = self._yaw_s = -math.inf
        self._battery = BatteryGauge()
        self._measured_s = self._tilt_rad = self.accuracy_m = 0.0
        self._position_watch = PositionWatch()
        self._range_below = RangeBelow()
        self._thrust_mps2: NorthEast = (0.0, 0.0)
        self._state: VehicleState | None = None  # of what was heard so far, once it was asked for

    @property
    def state(self) -> VehicleState | None:
        """The state in the mission's frame; None until all parts of it were heard."""
        if self._state is None:
            self._state = self._put_together()
        return self._state

    @property
    def missing(self) -> str:
        """What still has to be heard of the vehicle before a mission can begin, in words."""
        if self.mode is None:
            return "no HEARTBEAT of an autopilot"
        if self._position is None:
            return "no position (LOCAL_POSITION_NED)"
        if not self.frame.is_known:
            is_home = self.frame.is_home_known
            return "no origin (GPS_GLOBAL_ORIGIN)" if is_home else "no home (HOME_POSITION)"
        if self._yaw_rad is None:
            return "no heading (ATTITUDE)"
        if self._is_landed is None:
            return "not whether it stands on the ground (EXTENDED_SYS_STATE)"
        return "not that it stands still, disarmed and on the ground"

    def _put_together(self) -> VehicleState | None:
        if (
            not self.frame.is_known
            or self.mode is None
            or self._position is None
            or self._yaw_rad is None
            or self._is_landed is None
        ):
            return None
        stamp_s, position, velocity = self._position
        battery = self._battery
        off = STILL if self._is_landed else self.velocity_bias.at(stamp_s)
        return VehicleState(
            stamp_s=stamp_s,
            position=self.frame.position(position),
            velocity=(velocity[0] - off[0], velocity[1] - off[1], velocity[2] - off[2]),
            yaw_rad=self._yaw_rad,
            mode=self.mode,
            is_armed=self.is_armed,
            is_landed=self._is_landed,
            is_failsafe=self.is_failsafe,
            battery_percent=battery.percent,
            mode_s=self.heartbeat_s,
            landed_since_s=self._landed_since_s,
            measured_s=self._measured_s,
            tilt_rad=self._tilt_rad,
            thrust_mps2=self._thrust_mps2,
            accuracy_m=self.accuracy_m,
            position_s=self._position_s,
            yaw_s=self._yaw_s,
            is_battery_critical=battery.is_critical,
            is_drifting=self._position_watch.is_drifting,
            battery_s=battery.percent_s,
            battery_low_since_s=battery.low_since_s,
            power_w=battery.power_w,
            below_m=self.below_m(stamp_s),
        )

    def below_m(self, now_s: float) -> float | None:
        """Distance down to what is below the vehicle; None if not known (`range_below.py`)."""
        return self._range_below.at(now_s)

    def stand_at(self, place: Ned) -> None:
        """Lays the frame so that the vehicle stands at a place, before its first sortie."""
        self.frame.lay(place)
        if self._laid is not None:
            self._laid.note(self.frame, self._system, self._measured_s)
        self._state = None

    def move(self, by: NorthEast, most_m: float) -> None:
        """Moves the frame: the vehicle is that much further than its position says.

        Args:
            by: north and east.
            most_m: greatest distance by which the frame may be moved in all.
        """
        self.frame.move(by, most_m)
        self._state = None

    def anchor_at(self, anchor: GlobalOrigin | None) -> None:
        """Begins a mission with this origin; None if the mission begins where the vehicle
        stands."""
        self.frame.anchor_at(anchor)
        self._state = None

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame is on the earth; None while frames are not known."""
        is_known = self.frame.is_known and self.origins.residual_m is not None
        return self.frame.reference if is_known else None

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames are on the earth; None if not known."""
        frame, residual_m = self.frame, self.origins.residual_m
        if frame.reference is None or (zero := frame.zero) is None or residual_m is None:
            return None
        return FrameLocation(frame.reference, zero, frame.anchor is not None, residual_m)

    @property
    def is_flown(self) -> bool:
        """Whether the vehicle was heard to be armed or in the air."""
        return self.is_armed or self._is_landed is False

    @property
    def ground_amsl_m(self) -> float | None:
        """Altitude above mean sea level at which the vehicle stands disarmed; None if not known."""
        is_standing = self._is_landed is True and not self.is_armed
        return self.origins.altitude_m if is_standing else None

    @property
    def frame_doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is unknown or uncertain; None if it is
        certain."""
        watch = self.origins
        is_wanting = self.frame.anchor is not None and watch.origin is None
        if self._position is None or not (watch.is_doubted or is_wanting):
            return None
        if watch.residual_m is None:
            return Refusal("the autopilot does not say where its local frame lies on the earth")
        about = f"are {watch.residual_m:.1f} m apart, by its GPS_GLOBAL_ORIGIN"
        return Refusal(f"the autopilot's LOCAL_POSITION_NED and GLOBAL_POSITION_INT {about}")

    def is_news(self, now_s: float, message: Message) -> bool:
        """Whether no newer message of its kind has overtaken a message; call it once for each.

        Messages with words always count as news.
        """
        kind = message.get_type()
        is_overtaken = self._order.is_overtaken(now_s, kind, message.get_seq())
        return not is_overtaken or kind in SPOKEN

    def take(self, now_s: float, message: Message) -> None:
        """Takes a message of the autopilot that is news."""
        handler = _HANDLERS.get(message.get_type())
        if handler is not None:
            handler(self, now_s, message)
            self._state = None

    def _on_heartbeat(self, now_s: float, message: Message) -> None:
        self.heartbeat_s, heartbeat = now_s, heartbeat_of(message)
        self.mode, self.is_armed = heartbeat.mode, heartbeat.is_armed
        self.is_failsafe = heartbeat.is_failsafe
        self.words.custom_mode = message.custom_mode

    def _on_position(self, now_s: float, message: Message) -> None:
        position = (message.x, message.y, message.z)
        velocity = (message.vx, message.vy, message.vz)
        if all(map(math.isfinite, (*position, *velocity))):
            self._position = (now_s, position, velocity)
            self._system, self._measured_s = source(message)[0], message.time_boot_ms / 1000
            self.origins.take_local(self._measured_s, position, velocity)
            self.velocity_bias.take(now_s, self._measured_s, position, velocity)
            self._follow_origin()
            self._position_s = self.clock.measured_s(now_s, self._measured_s)
            is_standing = self._is_landed is True and not self.is_armed
            self.frame.take_position(now_s, position, is_standing)
            if self._laid is not None:
                self._laid.recall(self.frame, self._system, self._measured_s)

    def _on_global_position(self, _: float, message: Message) -> None:
        self.origins.take_global(message)
        self._follow_origin()

    def _on_origin(self, _: float, message: Message) -> None:
        self.origins.take_origin(message)
        self._follow_origin()

    def _follow_origin(self) -> None:
        origin = self.origins.origin
        if origin is not None and origin != self.frame.reference:
            self.frame.take_reference(origin)

    def _on_attitude(self, now_s: float, message: Message) -> None:
        self.boots.take(now_s, message.time_boot_ms / 1000)
        if math.isfinite(message.yaw):
            self._yaw_rad = message.yaw
            self._yaw_s = self.clock.measured_s(now_s, message.time_boot_ms / 1000)
        if math.isfinite(message.roll) and math.isfinite(message.pitch):
            self._tilt_rad = math.acos(math.cos(message.roll) * math.cos(message.pitch))
            if math.isfinite(message.yaw) and self._tilt_rad < MOST_TILT_RAD:
                self._thrust_mps2 = _thrust(message.roll, message.pitch, message.yaw)

    def _on_home(self, _: float, message: Message) -> None:
        position = (message.x, message.y, message.z)
        if all(map(math.isfinite, position)):
            self.frame.take_home(position, message.altitude / 1000)

    def _on_landed(self, now_s: float, message: Message) -> None:
        if message.landed_state == dialect.MAV_LANDED_STATE_UNDEFINED:
            return
        is_landed = message.landed_state == dialect.MAV_LANDED_STATE_ON_GROUND
        if is_landed is not self._is_landed:
            self._is_landed, self._landed_since_s = is_landed, now_s

    def _on_battery(self, now_s: float, message: Message) -> None:
        self._battery.take(now_s, message)

    def _on_estimator(self, now_s: float, message: Message) -> None:
        if math.isfinite(message.pos_horiz_accuracy):
            self.accuracy_m = message.pos_horiz_accuracy
            self._position_watch.take(now_s, self.accuracy_m)

    def _on_range(self, now_s: float, message: Message) -> None:
        self._range_below.take(now_s, message, self._tilt_rad)

    def _on_time(self, now_s: float, message: Message) -> None:
        self.clock.take(now_s, message)

    def _on_words(self, now_s: float, message: Message) -> None:
        self.words.take(now_s, message)

    def questions(self, now_s: float, autopilot: tuple[int, int], is_ours: bool) -> list[Message]:
        """What to ask the autopilot now: its words, and where its frame is.

        Args:
            now_s: the time.
            autopilot: system and component id.
            is_ours: a goal was pursued, so the companion may ask where the frame is.
        """
        is_flown = self.is_armed or self._is_landed is not True
        is_needed = self.frame_doubt is not None
        origin = self.origins.due(now_s, autopilot, is_needed) if is_needed or is_ours else []
        return [*self.words.due(now_s, autopilot, is_flown), *origin]


def heartbeat_of(message: Message) -> Heartbeat:
    """The content of the autopilot's HEARTBEAT."""
    return Heartbeat(
        KNOWN_MODES.get(mode_name(message.custom_mode) or "", Mode.OTHER),
        bool(message.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED),
        message.system_status >= dialect.MAV_STATE_CRITICAL,
    )


def _thrust(roll: float, pitch: float, yaw: float) -> NorthEast:
    """Horizontal acceleration of a vehicle whose thrust carries its weight: g tan(tilt)."""
    forward = -math.tan(pitch)
    right = math.tan(roll) / math.cos(pitch)
    north = forward * math.cos(yaw) - right * math.sin(yaw)
    east = forward * math.sin(yaw) + right * math.cos(yaw)
    return (GRAVITY_MPS2 * north, GRAVITY_MPS2 * east)


_HANDLERS: dict[str, Callable[[Telemetry, float, Message], None]] = {
    "HEARTBEAT": Telemetry._on_heartbeat,
    "LOCAL_POSITION_NED": Telemetry._on_position,
    "GLOBAL_POSITION_INT": Telemetry._on_global_position,
    "GPS_GLOBAL_ORIGIN": Telemetry._on_origin,
    "ATTITUDE": Telemetry._on_attitude,
    "HOME_POSITION": Telemetry._on_home,
    "EXTENDED_SYS_STATE": Telemetry._on_landed,
    "BATTERY_STATUS": Telemetry._on_battery,
    "ESTIMATOR_STATUS": Telemetry._on_estimator,
    "DISTANCE_SENSOR": Telemetry._on_range,
    "TIMESYNC": Telemetry._on_time,
    **dict.fromkeys(SPOKEN, Telemetry._on_words),
}

TELEMETRY = frozenset(_HANDLERS)
"""Messages that contain the state, its ages, or words."""
