"""The record of flights, and the automatic disarming at their end.

The vehicle disarms by itself after COM_DISARM_LAND on the ground after a landing, or after
COM_DISARM_PRFLT without a take-off; 0 or less means never (PX4 user guide, "Safety Configuration",
auto-disarming).
"""

from __future__ import annotations

from sitl.autopilot.parameters import Parameters


class FlightRecord:
    """The flights of one vehicle.

    Attributes:
        count: number of armings.
        armed_s: time of the last arming; 0 if never.
        in_air_s: time of the take-off after it; 0 if none.
    """

    def __init__(self) -> None:
        self.count = 0
        self.armed_s = self.in_air_s = 0.0
        self._has_flown = False
        self._on_ground_s = 0.0

    def arm(self, now_s: float) -> None:
        """Notes an arming."""
        self.count += 1
        self.armed_s, self.in_air_s = now_s, 0.0
        self._has_flown = False
        self._on_ground_s = now_s

    def take_off(self, now_s: float) -> None:
        """Notes a take-off."""
        self._has_flown = True
        self.in_air_s = self.in_air_s or now_s

    def land(self, now_s: float) -> None:
        """Notes a landing."""
        self._has_flown = True
        self._on_ground_s = now_s

    def disarming_reason(self, now_s: float, parameters: Parameters) -> str | None:
        """The reason why a vehicle on the ground disarms now; None if it does not."""
        name, text = (
            ("COM_DISARM_LAND", "Disarmed by landing")
            if self._has_flown
            else ("COM_DISARM_PRFLT", "Disarmed by auto preflight disarming")
        )
        limit_s = parameters[name]
        return text if 0 < limit_s <= now_s - self._on_ground_s else None
