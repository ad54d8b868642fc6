"""The vehicle of a hypothetical flight: in the air, at rest, and where the plan has it."""

from __future__ import annotations

from typing import Never

from companion.geometry import Ned
from companion.vehicle.ports.state import Attitude, Heartbeat, MeasuredMotion, Mode, VehicleState


class UnusedPort:
    """A port of a vehicle that nothing commands: whoever decides on plans only asks for its state.

    Raises:
        RuntimeError: the port is used.
    """

    def __get__(self, vehicle: object, owner: type | None = None) -> Never:
        raise RuntimeError("a hypothetical vehicle is asked for its state, and for nothing else")


class HypotheticalVehicle:
    """A vehicle in the air, at rest; fulfils `Vehicle`, but has its state alone."""

    setpoints, control, goals, frame = UnusedPort(), UnusedPort(), UnusedPort(), UnusedPort()
    parameters, fence, rally = UnusedPort(), UnusedPort(), UnusedPort()
    payloads, markers, cameras, gimbals = UnusedPort(), UnusedPort(), UnusedPort(), UnusedPort()

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

    def release(self) -> None:
        """Nothing is streamed or requested."""
