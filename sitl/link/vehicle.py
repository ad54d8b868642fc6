"""The parts of the vehicle that its MAVLink component reads and commands."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.geometry import GlobalOrigin
from sitl.autopilot.autopilot import Autopilot
from sitl.flight.battery import Battery
from sitl.flight.estimate import Estimator
from sitl.flight.physics import FlightState
from sitl.flight.sensors import Sensors
from sitl.link.mission_items import MissionType


@dataclass(slots=True)
class SimulatedVehicle:
    """One vehicle: its autopilot, its estimated state, its sensors.

    Attributes:
        state: the estimate; replaced every step.
        origin: the origin of the local frame.
        battery: with its gauge.
        estimator: makes the state, and reports its accuracy.
        booted_s: when the autopilot was last started.
        plan_numbers: of each stored plan, a number that differs for another plan; 0 for none.
    """

    autopilot: Autopilot
    state: FlightState
    origin: GlobalOrigin
    sensors: Sensors
    battery: Battery
    estimator: Estimator
    booted_s: float = 0.0
    plan_numbers: dict[MissionType, int] = field(
        default_factory=lambda: dict.fromkeys(MissionType, 0)
    )

    @property
    def boot_ms(self) -> int:
        """Time since the autopilot was started, ms."""
        return round((self.state.time_s - self.booted_s) * 1e3)

    @property
    def boot_us(self) -> int:
        """Time since the autopilot was started, us."""
        return round((self.state.time_s - self.booted_s) * 1e6)
