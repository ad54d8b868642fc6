"""Where the autopilot's local frame lies on the earth, and whether that is still true.

GPS_GLOBAL_ORIGIN tells it, when it changes and when it is asked for. PX4 takes another origin from
anybody, also in flight: LOCAL_POSITION_NED jumps at once, and the message comes up to a second
later, or never. What holds is seen by what the autopilot says of one position in both ways, there
and in GLOBAL_POSITION_INT.

1. The newest origin heard is in force from the moment on when both agree in it within AGREES_M.
2. While they do not agree in the one in force, the position on the earth is not known: doubt.
3. Both are compared at one time of the autopilot's clock, to which the velocity carries one on.

A jump of both is no doubt: the estimate was corrected, and the frame is where it was.

Sources: https://mavlink.io/en/messages/common.html#GPS_GLOBAL_ORIGIN; PX4 1.16,
src/modules/ekf2/EKF/ekf_helper.cpp (setLatLonOrigin), src/modules/mavlink/streams.
"""

from __future__ import annotations

import math

from companion.geometry import GlobalOrigin, Ned, distance, moved
from companion.mavlink.framing import Message, dialect

AGREES_M = 1.0
"""Both positions are rounded to centimetres; more than this is another frame."""
APART_S = 0.2
"""Two positions further apart in time are not compared."""
ASK_S = 1.0
FEW = 5

GlobalPosition = tuple[float, float, float]
"""Latitude, longitude (degrees) and metres above mean sea level."""


class OriginWatch:
    """The origin of one autopilot's local frame.

    Attributes:
        origin: in force; None until both positions have agreed in one.
        residual_m: between both positions, in the newest origin heard, when last compared.
        is_doubted: rule 2.
    """

    def __init__(self) -> None:
        self.origin: GlobalOrigin | None = None
        self.residual_m: float | None = None
        self.is_doubted = False
        self._heard: GlobalOrigin | None = None
        self._local: tuple[float, Ned, Ned] | None = None  # seconds, position, velocity
        self._global: tuple[float, GlobalPosition] | None = None
        self._asked_s = -math.inf
        self._asked = 0

    @property
    def altitude_m(self) -> float | None:
        """Of the vehicle above mean sea level; None before it was heard."""
        return self._global[1][2] if self._global is not None else None

    def take_origin(self, message: Message) -> None:
        """A GPS_GLOBAL_ORIGIN."""
        self._heard = GlobalOrigin(
            latitude_deg=message.latitude / 1e7,
            longitude_deg=message.longitude / 1e7,
            altitude_m=message.altitude / 1e3,
        )
        self._compare()

    def take_local(self, measured_s: float, position: Ned, velocity: Ned) -> None:
        """A LOCAL_POSITION_NED, by the autopilot's clock."""
        self._local = (measured_s, position, velocity)
        self._compare()

    def take_global(self, message: Message) -> None:
        """A GLOBAL_POSITION_INT."""
        degrees = message.lat / 1e7, message.lon / 1e7
        self._global = (message.time_boot_ms / 1e3, (*degrees, message.alt / 1e3))
        self._compare()

    def due(self, now_s: float, address: tuple[int, int], is_needed: bool) -> list[Message]:
        """Asks for the origin, once in ASK_S.

        Args:
            now_s: the time.
            address: of the autopilot.
            is_needed: the flight cannot go on without it; else it is asked for a few times, where a
                global position is told, in case it moves in flight.
        """
        is_wanted = self.origin is None and self._global is not None and self._asked < FEW
        if now_s - self._asked_s < ASK_S or not (is_needed or is_wanted):
            return []
        self._asked_s = now_s
        self._asked += 1
        wanted = dialect.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN
        request = dialect.MAV_CMD_REQUEST_MESSAGE
        return [
            dialect.MAVLink_command_long_message(*address, request, 0, wanted, 0, 0, 0, 0, 0, 0)
        ]

    def _compare(self) -> None:
        if self._local is None or self._global is None or self._heard is None:
            return
        (local_s, position, velocity), (global_s, on_earth) = self._local, self._global
        ahead_s = global_s - local_s
        if abs(ahead_s) > APART_S:
            return
        there = moved(position, velocity, ahead_s)
        self.residual_m = distance(self._heard.to_local(*on_earth), there)
        if self.residual_m <= AGREES_M:
            self.origin, self.is_doubted = self._heard, False
        elif self.origin is not None:
            self.is_doubted = distance(self.origin.to_local(*on_earth), there) > AGREES_M
