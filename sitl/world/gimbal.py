"""A gimbal on board with its own manager: who controls it, where it points, how fast it turns.

1. It turns only for the component that has primary control; all others are DENIED.
2. It ACCEPTS a direction at once; the turn takes as long as the gimbal's rate requires.
3. With the yaw in the earth's frame, it keeps its direction when the vehicle turns; otherwise it
   turns with the vehicle. Roll and pitch always refer to the horizon.

Source: https://mavlink.io/en/services/gimbal_v2.html.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.geometry import wrap_angle
from sitl.results import MavResult
from sitl.world.payload import CommandAck, Requester

NOBODY: Requester = (0, 0)
UNCHANGED, ITSELF, NO_LONGER = -1, -2, -3
YAW_LOCK, IN_VEHICLE_FRAME, IN_EARTH_FRAME = 16, 32, 64


@dataclass(frozen=True, slots=True)
class GimbalSpec:
    """The properties of a gimbal.

    Attributes:
        rate_radps: its angular rate.
        pitch_rad: from the lowest to the highest.
    """

    component: int
    rate_radps: float = math.radians(60.0)
    pitch_rad: tuple[float, float] = (-math.pi / 2, math.radians(30.0))


@dataclass(frozen=True, slots=True)
class GimbalChange:
    """A change of a gimbal; None leaves a property as it is.

    Attributes:
        is_stuck: it does not turn.
        is_taken: another component takes control.
        is_silent: it sends nothing and receives nothing.
    """

    is_stuck: bool | None = None
    is_taken: bool = False
    is_silent: bool | None = None


class Gimbal:
    """One gimbal, which points forward at the start.

    Attributes:
        control: system and component that have primary control.
        pitch_rad: positive upwards.
        yaw_rad: clockwise from the vehicle's heading.
        is_in_earth_frame: it keeps its direction when the vehicle turns.
        is_silent: it sends nothing.
    """

    SOMEBODY: Requester = (255, 190)

    def __init__(self, spec: GimbalSpec) -> None:
        self.spec = spec
        self.control = NOBODY
        self.pitch_rad = self.yaw_rad = 0.0
        self.is_in_earth_frame = self.is_silent = False
        self._is_stuck = False
        self._wanted = (0.0, 0.0)  # pitch, yaw in its frame
        self._stepped_s = self._heading_rad = 0.0

    def change(self, change: GimbalChange) -> None:
        """Applies a change of the scenario."""
        if change.is_stuck is not None:
            self._is_stuck = change.is_stuck
        if change.is_silent is not None:
            self.is_silent = change.is_silent
        if change.is_taken:
            self.control = self.SOMEBODY

    def configure(self, requester: Requester, system: float, component: float) -> CommandAck:
        """The answer to MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE."""
        if system == NO_LONGER:
            self.control = NOBODY if self.control == requester else self.control
        elif system == ITSELF:
            self.control = requester
        elif system != UNCHANGED:
            self.control = (int(system), int(component))
        return CommandAck(requester, MavResult.ACCEPTED)

    def turn(
        self, requester: Requester, pitch_deg: float, yaw_deg: float, flags: float
    ) -> CommandAck:
        """The answer to MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW."""
        if requester != self.control or not math.isfinite(pitch_deg + yaw_deg):
            return CommandAck(requester, MavResult.DENIED)
        self.is_in_earth_frame = bool(int(flags) & (IN_EARTH_FRAME | YAW_LOCK))
        lowest, highest = self.spec.pitch_rad
        pitch_rad = min(max(math.radians(pitch_deg), lowest), highest)
        self._wanted = (pitch_rad, math.radians(yaw_deg))
        return CommandAck(requester, MavResult.ACCEPTED)

    def step(self, heading_rad: float, now_s: float) -> None:
        """Turns the gimbal, given the time and the vehicle's heading."""
        most_rad = self.spec.rate_radps * (now_s - self._stepped_s)
        if self.is_in_earth_frame:
            self.yaw_rad = wrap_angle(self.yaw_rad - wrap_angle(heading_rad - self._heading_rad))
        self._stepped_s, self._heading_rad = now_s, heading_rad
        if self._is_stuck:
            return
        pitch_rad, yaw_rad = self._wanted
        if self.is_in_earth_frame:
            yaw_rad -= heading_rad
        self.pitch_rad += _bounded(pitch_rad - self.pitch_rad, most_rad)
        turn_rad = _bounded(wrap_angle(yaw_rad - self.yaw_rad), most_rad)
        self.yaw_rad = wrap_angle(self.yaw_rad + turn_rad)


def _bounded(value: float, most: float) -> float:
    return max(-most, min(most, value))
