"""The ages of setpoints, heartbeats and the position, and the battery's warning level."""

from __future__ import annotations

import math

from sitl.autopilot.failsafes import (
    POSITION_LOST_S,
    BatteryLevel,
    FailsafeInputs,
    battery_level,
)
from sitl.autopilot.parameters import Parameters


class Health:
    """The health of one vehicle, from which its failsafes are selected.

    Args:
        parameters: the parameters of the autopilot.
        charge: state of charge at the start, 0 to 1.

    Attributes:
        battery: warning level.
        knows_battery: whether the gauge can be read; if not, the level stays.
        position_age_s: time since the position was last measured.
    """

    def __init__(self, parameters: Parameters, charge: float) -> None:
        self.battery = battery_level(charge, parameters)
        self.knows_battery = True
        self.position_age_s = 0.0
        self._parameters = parameters
        self._setpoint_s = self._ground_station_s = -math.inf

    def note_setpoint(self, now_s: float) -> None:
        """Notes a valid offboard setpoint."""
        self._setpoint_s = now_s

    def note_ground_station(self, now_s: float) -> None:
        """Notes a heartbeat of a ground station."""
        self._ground_station_s = now_s

    def update_battery(self, charge: float) -> BatteryLevel | None:
        """Takes a state of charge; returns the warning level if it has risen."""
        if not self.knows_battery:
            return None
        before, self.battery = self.battery, battery_level(charge, self._parameters)
        return self.battery if self.battery > before else None

    def has_setpoints(self, now_s: float) -> bool:
        """Whether the offboard stream is alive (COM_OF_LOSS_T)."""
        return now_s - self._setpoint_s <= self._parameters["COM_OF_LOSS_T"]

    @property
    def is_position_lost(self) -> bool:
        """Whether the position estimate cannot be trusted."""
        return self.position_age_s > POSITION_LOST_S

    def inputs(self, intended_mode: str, is_fence_breached: bool, now_s: float) -> FailsafeInputs:
        """The inputs of the failsafes."""
        return FailsafeInputs(
            intended_mode,
            now_s - self._setpoint_s,
            self.battery,
            self._parameters,
            now_s - self._ground_station_s,
            self.position_age_s,
            is_fence_breached,
        )
