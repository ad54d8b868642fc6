"""The vehicle of a hypothetical flight: in the air, at rest, and where the plan has it."""

from __future__ import annotations

from companion.geometry import Ned
from companion.vehicle.ports.state import Attitude, Heartbeat, MeasuredMotion, Mode, VehicleState


class HypotheticalVehicle:
    """A vehicle in the air, at rest; whoever decides on plans only asks it for its state."""

    def __init__(self, position: Ned) -> None:
        self.stand_at(position)

    def stand_at(self, position: Ned) -> None:
        """Moves it to another position."""
        self.state = VehicleState(
            MeasuredMotion(position, velocity=(0.0, 0.0, 0.0)),
            Attitude(yaw_rad=0.0),
            Heartbeat(Mode.OFFBOARD, is_armed=True, is_failsafe=False, received_s=0.0),
            is_landed=False,
        )
