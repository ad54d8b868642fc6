"""How far below the vehicle the next thing is, by a range finder that looks down.

Source: common.xml, DISTANCE_SENSOR. Of two readings in a row the greater one counts: a single echo
of dust, or of a leg, is none. Below its least distance a range finder knows no more than that.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Message, dialect

DOWN = dialect.MAV_SENSOR_ROTATION_PITCH_270
INVALID = 1
"""DISTANCE_SENSOR.signal_quality of a reading that is none; 0 says nothing of that."""
FRESH_S = 0.5
"""Older readings say nothing of now; a PX4 sends ten a second to a companion."""


class RangeBelow:
    """The newest readings."""

    def __init__(self) -> None:
        self._stamp_s = -math.inf
        self._readings_m = (math.inf, math.inf)

    def take(self, now_s: float, message: Message, tilt_rad: float) -> None:
        """Takes a DISTANCE_SENSOR, of whatever looks down.

        Args:
            now_s: when it was heard.
            message: the reading.
            tilt_rad: of the vehicle's axis, along which it was measured.
        """
        measured_cm = message.current_distance
        is_reading = measured_cm > 0 and message.signal_quality != INVALID
        if message.orientation != DOWN or not is_reading:
            return
        is_near = measured_cm <= message.max_distance
        along_m = max(measured_cm, message.min_distance) / 100 if is_near else math.inf
        is_new = now_s - self._stamp_s > FRESH_S
        before_m = math.inf if is_new else self._readings_m[1]
        self._stamp_s = now_s
        self._readings_m = (before_m, along_m * math.cos(tilt_rad))

    def at(self, now_s: float) -> float | None:
        """Metres, inf where nothing is within its range; None while no fresh reading is known."""
        return max(self._readings_m) if now_s - self._stamp_s <= FRESH_S else None
