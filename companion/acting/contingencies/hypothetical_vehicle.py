"""The vehicle of a hypothetical flight: in the air, at rest, and where the plan has it."""

from __future__ import annotations

from companion.geometry import Ned
from companion.vehicle.port import Mode, VehicleState


class HypotheticalVehicle:
    """A vehicle in the air, at rest; whoever decides on plans only asks it for its state."""

    def __init__(self, position: Ned) -> None:
        self.stand_at(position)

    def stand_at(self, position: Ned) -> None:
        """Moves it to another position."""
        self.state = VehicleState(
            stamp_s=0.0,
            position=position,
            velocity=(0.0, 0.0, 0.0),
            yaw_rad=0.0,
            mode=Mode.OFFBOARD,
            is_armed=True,
            is_landed=False,
            is_failsafe=False,
            battery_percent=None,
        )
