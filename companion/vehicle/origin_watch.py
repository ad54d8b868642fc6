"""Watches where the autopilot's local frame is on the earth, and whether that is still true.

GPS_GLOBAL_ORIGIN says where, when it changes and when it is requested. PX4 accepts another origin
from anybody, also in flight: LOCAL_POSITION_NED then jumps at once, but the message comes up to a
second later, or never. So the origin is checked against the two ways in which the autopilot reports
one position: LOCAL_POSITION_NED and GLOBAL_POSITION_INT.

1. The newest origin heard comes into force when both positions agree by it within AGREES_M.
2. While both do not agree by the origin in force, the position on the earth is in doubt.
3. Both are compared at the same time of the autopilot's clock; the velocity extrapolates one of
   them.

If both positions jump together, there is no doubt: the estimate was corrected, and the frame has
not moved.

Sources: https://mavlink.io/en/messages/common.html#GPS_GLOBAL_ORIGIN; PX4 1.16,
src/modules/ekf2/EKF/ekf_helper.cpp (setLatLonOrigin), src/modules/mavlink/streams.
"""

from __future__ import annotations

import math

from companion.geometry import GlobalOrigin, Ned, distance, moved
from companion.mavlink.framing import Message, dialect

AGREES_M = 1.0
"""Both positions are rounded to centimetres; a greater difference means another frame."""
APART_S = 0.2
"""Positions further apart in time are not compared."""
ASK_S = 1.0
FEW = 5

GlobalPosition = tuple[float, float, float]
"""Latitude, longitude (degrees) and metres above mean sea level."""


class OriginWatch:
    """The origin of one autopilot's local frame.

    Attributes:
        origin: the one in force; None until both positions have agreed by one.
        residual_m: distance between both positions by the newest origin heard, when last compared.
        is_doubted: by rule 2.
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
        """The vehicle's altitude above mean sea level; None before it was heard."""
        return self._global[1][2] if self._global is not None else None

    def take_origin(self, message: Message) -> None:
        """Takes a GPS_GLOBAL_ORIGIN."""
        self._heard = GlobalOrigin(
            latitude_deg=message.latitude / 1e7,
            longitude_deg=message.longitude / 1e7,
            altitude_m=message.altitude / 1e3,
        )
        self._compare()

    def take_local(self, measured_s: float, position: Ned, velocity: Ned) -> None:
        """Takes a LOCAL_POSITION_NED, measured at a time of the autopilot's clock."""
        self._local = (measured_s, position, velocity)
        self._compare()

    def take_global(self, message: Message) -> None:
        """Takes a GLOBAL_POSITION_INT."""
        degrees = message.lat / 1e7, message.lon / 1e7
        self._global = (message.time_boot_ms / 1e3, (*degrees, message.alt / 1e3))
        self._compare()

    def due(self, now_s: float, address: tuple[int, int], is_needed: bool) -> list[Message]:
        """The request for the origin, once in ASK_S.

        Args:
            now_s: the time.
            address: system and component of the autopilot.
            is_needed: the flight cannot continue without it. Otherwise it is requested a few times
                if a global position is heard, in case the origin moves in flight.
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
