"""The camera for landing markers, as a MAVLink component.

It sends LANDING_TARGET for each marker in each look, stamped with the autopilot's time since boot,
like a detector that follows TIMESYNC. A position in LOCAL_NED is computed as such a program does:
from the measured direction and distance, and from the vehicle's estimated position.
"""

from __future__ import annotations

import math

from companion.geometry import Ned
from companion.mavlink.framing import Message, dialect
from sitl.flight.physics import FlightState
from sitl.link.component_sender import ComponentSender, PackedMessage
from sitl.link.vehicle import SimulatedVehicle
from sitl.world.markers import MarkerCamera, MarkerReport, Sighting

_FRAMES = {
    MarkerReport.LOCAL_NED: dialect.MAV_FRAME_LOCAL_NED,
    MarkerReport.BODY_FRD: dialect.MAV_FRAME_BODY_FRD,
    MarkerReport.LOCAL_FRD: dialect.MAV_FRAME_LOCAL_FRD,
    MarkerReport.ANGLES: dialect.MAV_FRAME_BODY_FRD,
}


class MarkerCameraComponent:
    """The camera as a component.

    Args:
        system: the system id of the vehicle.
        camera: makes the sightings.
        vehicle: has the estimate and the time since boot.
    """

    def __init__(self, system: int, camera: MarkerCamera, vehicle: SimulatedVehicle) -> None:
        self.address = (system, camera.spec.component)
        self._camera = camera
        self._vehicle = vehicle
        self._sender = ComponentSender(self.address)

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """The camera has no commands."""
        return self._sender.refuse(message, self.address)

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT, and a LANDING_TARGET for each sighting."""
        sent = self._sender.heartbeat(state.time_s)
        if self._sender.is_due(1 / self._camera.spec.rate_hz, state.time_s):
            sent += [self._sender.pack(self._report(s)) for s in self._camera.look(state)]
        return sent

    def _report(self, seen: Sighting) -> Message:
        form = self._camera.spec.reports
        forward, right, down = seen.in_body
        distance_m = math.hypot(*seen.in_body)
        is_position = form is not MarkerReport.ANGLES
        return dialect.MAVLink_landing_target_message(
            self._vehicle.boot_us,
            seen.number,
            _FRAMES[form],
            math.atan2(right, down),
            math.atan2(-forward, down),
            distance_m,
            0.0,
            0.0,
            *(self._position(form, seen) if is_position else (0.0, 0.0, 0.0)),
            (1.0, 0.0, 0.0, 0.0),
            dialect.LANDING_TARGET_TYPE_VISION_FIDUCIAL,
            int(is_position),
        )

    def _position(self, form: MarkerReport, seen: Sighting) -> Ned:
        north, east, down = seen.offset
        if form is MarkerReport.BODY_FRD:
            return seen.in_body
        if form is MarkerReport.LOCAL_FRD:
            yaw = self._vehicle.state.euler[2]
            cos, sin = math.cos(yaw), math.sin(yaw)
            return (cos * north + sin * east, -sin * north + cos * east, down)
        n, e, d = self._vehicle.state.position
        return (n + north, e + east, d + down)
