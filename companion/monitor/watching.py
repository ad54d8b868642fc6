"""Snapshots of the vehicle: the newest state that it and the companion sent over the link.

Frames of one time in flight.tlog belong to one tick. So the state and the map as sensed are read
here as in the companion itself, by the same code.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.geometry import GlobalOrigin, Ned, enu_from_ned
from companion.mavlink.framing import Message, choose, dialect, message_of, source
from companion.mavlink.px4_modes import mode_name
from companion.motion.grid import OccupancyGrid
from companion.vehicle.battery_gauge import voltage_v
from companion.vehicle.pose_messages import keep_pose
from companion.vehicle.poses import PoseHistory
from companion.vehicle.ranging import Ranging
from companion.vehicle.surroundings import Surroundings
from companion.vehicle.telemetry import Telemetry

AUTOPILOT = dialect.MAV_COMP_ID_AUTOPILOT1
COMPANION = dialect.MAV_COMP_ID_ONBOARD_COMPUTER
SCANNER = dialect.MAV_COMP_ID_OBSTACLE_AVOIDANCE
_CONTINUAL = frozenset(
    {
        dialect.MAVLINK_MSG_ID_ATTITUDE,
        dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        dialect.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    }
)
_SETPOINT = dialect.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED
_SCAN = dialect.MAVLINK_MSG_ID_OBSTACLE_DISTANCE
_WANTED = _CONTINUAL | {
    dialect.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN,
    _SETPOINT,
    _SCAN,
    dialect.MAVLINK_MSG_ID_HEARTBEAT,
    dialect.MAVLINK_MSG_ID_HOME_POSITION,
    dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
    dialect.MAVLINK_MSG_ID_BATTERY_STATUS,
    dialect.MAVLINK_MSG_ID_ESTIMATOR_STATUS,
    dialect.MAVLINK_MSG_ID_DISTANCE_SENSOR,
}
SETPOINT_OLD_S = 1.0
"""Age from which a setpoint is not shown, because none are streamed any more."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The vehicle at one time.

    Attributes:
        time_s: since the run began.
        setpoint: the last one; None if none are streamed.
        clearance_m: to the nearest obstacle at its altitude on the map as known; inf if none.
        link_age_s: time since the autopilot was heard.
    """

    time_s: float
    position: Ned
    velocity: Ned
    yaw_rad: float
    setpoint: Ned | None
    battery_percent: int | None
    voltage_v: float | None
    clearance_m: float
    mode: str
    is_armed: bool
    link_age_s: float

    def as_json(self) -> dict[str, object]:
        """East, north and up, metres; yaw in degrees from north to the east."""
        return {
            "t_s": round(self.time_s, 2),
            "enu": _rounded(self.position),
            "speed_mps": round(math.hypot(*self.velocity), 2),
            "yaw_deg": round(math.degrees(self.yaw_rad), 1),
            "setpoint": self.setpoint and _rounded(self.setpoint),
            "battery_percent": self.battery_percent,
            "voltage_v": self.voltage_v and round(self.voltage_v, 2),
            "clearance_m": round(self.clearance_m, 2) if math.isfinite(self.clearance_m) else None,
            "mode": self.mode,
            "armed": self.is_armed,
            "link_age_s": round(self.link_age_s, 2),
        }


def _rounded(ned: Ned) -> list[float]:
    return [round(x, 2) for x in enu_from_ned(ned)]


class Watcher:
    """Reads the recorded frames, tick by tick.

    Args:
        told: the map of the mission.
        anchor: where the mission lies on the earth, if it says so.
    """

    def __init__(self, told: OccupancyGrid, anchor: GlobalOrigin | None = None) -> None:
        self._telemetry = Telemetry()
        self._telemetry.placed.anchor_at(anchor)
        self._surroundings = Surroundings(told, self._telemetry)
        self._poses = PoseHistory()
        self._ranging = Ranging(self._poses)
        self._system = 0
        self._mode = ""
        self._voltage_v: float | None = None
        self._heard_s = -math.inf
        self._setpoint: tuple[float, Ned] | None = None

    @property
    def grid(self) -> OccupancyGrid:
        """The map as known now."""
        return self._surroundings.grid

    @property
    def position(self) -> Ned | None:
        """The vehicle's position, if known."""
        state = self._telemetry.state
        return state.motion.position if state else None

    def hear(self, now_s: float, frames: list[bytes]) -> None:
        """Reads the frames of one tick."""
        for frame in choose(frames, _WANTED, _CONTINUAL):
            self._take(now_s, message_of(frame))
        accuracy_m, below_m = self._telemetry.accuracy_m, self._telemetry.below_m(now_s)
        self._surroundings.take(self._ranging.scans(now_s, accuracy_m, below_m))

    def _take(self, now_s: float, message: Message) -> None:
        system, component = source(message)
        if component == AUTOPILOT and not self._system:
            self._system = system
        if system != self._system:
            return
        if component == AUTOPILOT:
            self._heard_s = now_s
            if self._telemetry.is_news(now_s, message):
                self._telemetry.take(now_s, message)
                keep_pose(self._poses, message, self._telemetry)
            if message.get_msgId() == dialect.MAVLINK_MSG_ID_BATTERY_STATUS:
                self._voltage_v = voltage_v(message)
            elif message.get_msgId() == dialect.MAVLINK_MSG_ID_HEARTBEAT:
                self._mode = mode_name(message.custom_mode) or "another mode"
        elif component == SCANNER and message.get_msgId() == _SCAN:
            self._ranging.take_scan(message)
        elif component == COMPANION and message.get_msgId() == _SETPOINT:
            self._setpoint = (now_s, (message.x, message.y, message.z))

    def snapshot(self, now_s: float) -> Snapshot | None:
        """The present snapshot; None until the vehicle's state is known."""
        state = self._telemetry.state
        if state is None:
            return None
        setpoint = None
        if self._setpoint is not None and now_s - self._setpoint[0] < SETPOINT_OLD_S:
            setpoint = self._telemetry.frame.position(self._setpoint[1])
        north, east, down = state.motion.position
        return Snapshot(
            time_s=now_s,
            position=state.motion.position,
            velocity=state.motion.velocity,
            yaw_rad=state.attitude.yaw_rad,
            setpoint=setpoint,
            battery_percent=state.battery.percent,
            voltage_v=self._voltage_v,
            clearance_m=self.grid.at(-down).clearance_m((north, east)),
            mode=self._mode,
            is_armed=state.heartbeat.is_armed,
            link_age_s=now_s - self._heard_s,
        )
