"""Measures the distance down to what is below the vehicle, by a range finder that looks down.

The greater of two successive readings counts, so a single echo of dust or of a leg has no effect.
Below its minimum distance a range finder cannot measure; that minimum is then taken.

Source: common.xml, DISTANCE_SENSOR.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Message, dialect

DOWN = dialect.MAV_SENSOR_ROTATION_PITCH_270
INVALID = 1
"""DISTANCE_SENSOR.signal_quality of an invalid reading; 0 means that the quality is not known."""
FRESH_S = 0.5
"""Older readings are not used; a PX4 sends ten a second to a companion."""


class RangeBelow:
    """The newest readings."""

    def __init__(self) -> None:
        self._stamp_s = -math.inf
        self._readings_m = (math.inf, math.inf)

    def take(self, now_s: float, message: Message, tilt_rad: float) -> None:
        """Takes a DISTANCE_SENSOR; sensors that look elsewhere are ignored.

        Args:
            now_s: when it was heard.
            message: the reading.
            tilt_rad: of the vehicle's axis, along which the sensor measures.
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
        """Metres down; inf if nothing is within range, None without a fresh reading."""
        return max(self._readings_m) if now_s - self._stamp_s <= FRESH_S else None
