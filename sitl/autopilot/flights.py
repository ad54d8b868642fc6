"""How often was the vehicle armed, has it flown since, and when does it disarm by itself?

COM_DISARM_LAND after a landing, or COM_DISARM_PRFLT after arming without a take-off; 0 or less is
never (PX4 user guide, "Safety Configuration", auto-disarming).
"""

from __future__ import annotations

from sitl.autopilot.parameters import Parameters


class Flights:
    """The flights of one vehicle.

    Attributes:
        count: how often it was armed.
        armed_s: when last; 0 for never.
        in_air_s: when it took off on that flight; 0 for never.
    """

    def __init__(self) -> None:
        self.count = 0
        self.armed_s = self.in_air_s = 0.0
        self._has_flown = False
        self._on_ground_s = 0.0

    def begin(self, now_s: float) -> None:
        """It was armed."""
        self.count += 1
        self.armed_s, self.in_air_s = now_s, 0.0
        self._has_flown = False
        self._on_ground_s = now_s

    def take_off(self, now_s: float) -> None:
        """It has left the ground."""
        self._has_flown = True
        self.in_air_s = self.in_air_s or now_s

    def land(self, now_s: float) -> None:
        """It has come to rest on the ground."""
        self._has_flown = True
        self._on_ground_s = now_s

    def over(self, now_s: float, parameters: Parameters) -> str:
        """Why the motors are to stop now, of a vehicle on the ground; empty if they are not."""
        name, text = (
            ("COM_DISARM_LAND", "Disarmed by landing")
            if self._has_flown
            else ("COM_DISARM_PRFLT", "Disarmed by auto preflight disarming")
        )
        limit_s = parameters[name]
        return text if 0 < limit_s <= now_s - self._on_ground_s else ""
