"""A vehicle as the acting side sees it: its state, and a port for each thing that it can do.

Each port has a file of its own here. `companion/vehicle/offboard.py` implements them over MAVLink;
tests implement them with a kinematic fake.
"""

from __future__ import annotations

from typing import Protocol

from companion.vehicle.ports.cameras import Cameras
from companion.vehicle.ports.control import VehicleControl
from companion.vehicle.ports.frame import PlacedFrame
from companion.vehicle.ports.gimbals import Gimbals
from companion.vehicle.ports.goals import VehicleGoals
from companion.vehicle.ports.markers import Markers
from companion.vehicle.ports.parameters import AutopilotParameters
from companion.vehicle.ports.payloads import Payloads
from companion.vehicle.ports.setpoints import Setpoints
from companion.vehicle.ports.state import VehicleState
from companion.vehicle.ports.stores import AutopilotFence, AutopilotRally


class SteeredVehicle(Protocol):
    """A vehicle that follows setpoints."""

    @property
    def state(self) -> VehicleState | None:
        """The newest state; None until one has been heard."""

    @property
    def setpoints(self) -> Setpoints:
        """Its setpoints."""


class Vehicle(SteeredVehicle, Protocol):
    """A vehicle that the acting side flies."""

    @property
    def control(self) -> VehicleControl:
        """Who has control of it."""

    @property
    def goals(self) -> VehicleGoals:
        """What it is brought to do by commands: arm, climb, hold, land."""

    @property
    def frame(self) -> PlacedFrame:
        """Where the frame of the mission is."""

    @property
    def parameters(self) -> AutopilotParameters:
        """The parameters of its autopilot."""

    @property
    def fence(self) -> AutopilotFence:
        """The fence of its autopilot."""

    @property
    def rally(self) -> AutopilotRally:
        """The rally points of its autopilot."""

    @property
    def payloads(self) -> Payloads:
        """The payloads that skills command."""

    @property
    def markers(self) -> Markers:
        """Sightings of landing markers."""

    @property
    def cameras(self) -> Cameras:
        """Its cameras."""

    @property
    def gimbals(self) -> Gimbals:
        """Its gimbals."""

    def release(self) -> None:
        """Stop streaming, and stop all requests."""
