"""A camera as a MAVLink component: heartbeat of type 30, and the messages of the camera protocol.

It answers photo commands and requests for its messages. Like MAVSDK's camera server, it denies
requests to send an image report again, and does not answer commands that are not for cameras.
Source: https://mavlink.io/en/services/camera.html.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.geometry import GlobalOrigin
from companion.mavlink.framing import Message, dialect, source
from sitl.flight.physics import FlightState
from sitl.link.component_sender import COMMANDS, ComponentSender, PackedMessage
from sitl.link.routing import target
from sitl.results import MavResult
from sitl.world.camera import SHOT_MIB, Camera, Image
from sitl.world.payload import CommandAck

_CAMERA = dialect.MAV_TYPE_CAMERA
_CAPTURES = dialect.CAMERA_CAP_FLAGS_CAPTURE_IMAGE
_IDLE, _SHOOTING = 0, 1
_OLD_REQUESTS = {
    dialect.MAV_CMD_REQUEST_CAMERA_INFORMATION: dialect.MAVLINK_MSG_ID_CAMERA_INFORMATION,
    dialect.MAV_CMD_REQUEST_STORAGE_INFORMATION: dialect.MAVLINK_MSG_ID_STORAGE_INFORMATION,
    dialect.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS: dialect.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS,
    dialect.MAV_CMD_REQUEST_CAMERA_SETTINGS: dialect.MAVLINK_MSG_ID_CAMERA_SETTINGS,
}


class CameraComponent:
    """The camera as a component.

    Args:
        system: the system id of the vehicle.
        camera: its shots and storage.
        home: where the world's origin lies on the earth.
    """

    def __init__(self, system: int, camera: Camera, home: GlobalOrigin) -> None:
        self.address = (system, camera.spec.component)
        self._camera = camera
        self._home = home
        self._sender = ComponentSender(self.address)
        self._messages: dict[int, Callable[[FlightState], Message]] = {
            dialect.MAVLINK_MSG_ID_CAMERA_INFORMATION: self._information,
            dialect.MAVLINK_MSG_ID_STORAGE_INFORMATION: self._storage,
            dialect.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS: self._status,
            dialect.MAVLINK_MSG_ID_CAMERA_SETTINGS: self._settings,
        }

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Handles a command to the camera."""
        is_ours = message.get_type() in COMMANDS and target(message) == self.address
        if not is_ours or self._camera.is_silent:
            return []
        command, asker = message.command, source(message)
        if command == dialect.MAV_CMD_IMAGE_START_CAPTURE:
            ack = self._camera.shoot(asker, message.param3, state.time_s)
            return [self._sender.acknowledge(command, ack)]
        if command != dialect.MAV_CMD_REQUEST_MESSAGE and command not in _OLD_REQUESTS:
            return []
        wanted = self._messages.get(_OLD_REQUESTS.get(command, int(message.param1)))
        if wanted is None:
            return [self._sender.acknowledge(command, CommandAck(asker, MavResult.DENIED))]
        ack = CommandAck(asker, MavResult.ACCEPTED)
        return [self._sender.acknowledge(command, ack), self._sender.pack(wanted(state))]

    def step(self, state: FlightState) -> list[PackedMessage]:
        """HEARTBEAT, and the photo that is done."""
        sent = self._sender.heartbeat(state.time_s, _CAMERA)
        if done := self._camera.step(state.position, state.time_s):
            ack, image = done
            shot = dialect.MAV_CMD_IMAGE_START_CAPTURE
            sent.append(self._sender.acknowledge(shot, ack))
            if not image.is_lost:
                sent.append(self._sender.pack(self._captured(image, state)))
                sent.append(self._sender.pack(self._status(state)))
        return [] if self._camera.is_silent else sent

    def _captured(self, image: Image, state: FlightState) -> Message:
        lat_deg, lon_deg, amsl_m = self._home.to_global(state.position)
        return dialect.MAVLink_camera_image_captured_message(
            _ms(state),
            0,
            0,
            round(lat_deg * 1e7),
            round(lon_deg * 1e7),
            round(amsl_m * 1e3),
            round(-state.position[2] * 1e3),
            (1.0, 0.0, 0.0, 0.0),
            image.index,
            int(image.is_good),
            b"",
        )

    def _status(self, state: FlightState) -> Message:
        left, shooting = self._camera.left, _SHOOTING if self._camera.is_shooting else _IDLE
        return dialect.MAVLink_camera_capture_status_message(
            _ms(state), shooting, 0, 0.0, 0, SHOT_MIB * left, self._camera.images
        )

    def _storage(self, state: FlightState) -> Message:
        left_mib = SHOT_MIB * self._camera.left
        total_mib = SHOT_MIB * self._camera.spec.capacity
        return dialect.MAVLink_storage_information_message(
            _ms(state),
            storage_id=1,
            storage_count=1,
            status=dialect.STORAGE_STATUS_READY,
            total_capacity=total_mib,
            used_capacity=total_mib - left_mib,
            available_capacity=left_mib,
            read_speed=20.0,
            write_speed=20.0,
        )

    def _information(self, state: FlightState) -> Message:
        return dialect.MAVLink_camera_information_message(
            _ms(state),
            vendor_name=list(b"sitl".ljust(32, b"\0")),
            model_name=list(b"camera".ljust(32, b"\0")),
            firmware_version=1,
            focal_length=8.0,  # like the sensor sizes, mm
            sensor_size_h=6.0,
            sensor_size_v=4.5,
            resolution_h=4000,
            resolution_v=3000,
            lens_id=0,
            flags=_CAPTURES,
            cam_definition_version=0,
            cam_definition_uri=b"",
        )

    def _settings(self, state: FlightState) -> Message:
        return dialect.MAVLink_camera_settings_message(_ms(state), dialect.CAMERA_MODE_IMAGE)


def _ms(state: FlightState) -> int:
    return round(state.time_s * 1e3)
