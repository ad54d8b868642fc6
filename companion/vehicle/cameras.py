"""Drives the vehicle's cameras over MAVLink: which are present, their counts, one photo at a time.

Messages of cameras are evaluated even while no photo is under way. Each camera makes its photos one
after the other (`photo_shot.py`).
"""

from __future__ import annotations

from companion.mavlink.framing import Message, source
from companion.vehicle.known_camera import KnownCamera
from companion.vehicle.photo_shot import PHOTO_S, SHOOT, PhotoShot
from companion.vehicle.ports.cameras import IntendedShot, ShotOutcome, ShotOwner
from companion.vehicle.services import Moment
from companion.vehicle.wire import COMPONENT, Wire

IMAGE, CAPTURE_STATUS, STORAGE = (
    "CAMERA_IMAGE_CAPTURED",
    "CAMERA_CAPTURE_STATUS",
    "STORAGE_INFORMATION",
)


class MavlinkCameras:
    """Implements `ports.cameras.Cameras`; a service of the vehicle.

    Args:
        wire: of the system that the cameras belong to.
    """

    wanted = frozenset({"HEARTBEAT", "COMMAND_ACK", IMAGE, CAPTURE_STATUS, STORAGE})
    needs_control = True

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._cameras: dict[int, KnownCamera] = {}
        self._shots: dict[int, PhotoShot] = {}
        self._tickets = 0
        self._heard_s = 0.0

    # -- ports.cameras -------------------------------------------------------------------------

    def prepare(
        self,
        component: int,
        owner: ShotOwner,
        timeout_s: float | None,
        may_repeat: bool = False,
    ) -> int:
        """Begins with a photo; returns its ticket."""
        self._tickets += 1
        camera = self._camera(component)
        self._shots[self._tickets] = PhotoShot(camera, owner, timeout_s, may_repeat)
        return self._tickets

    def shoot(self, ticket: int) -> None:
        """Asks for a photo that is ready."""
        self._shots[ticket].shoot(self._heard_s)

    def outcome(self, ticket: int) -> ShotOutcome:
        """What became of the photo."""
        return self._shots[ticket].outcome

    def forget(self, ticket: int) -> None:
        """Stops asking for the photo."""
        self._shots.pop(ticket, None)

    def recall(self, shot: IntendedShot) -> None:
        """Another process was about to ask for this photo."""
        camera = self._camera(shot.component)
        camera.sequence = max(camera.sequence, shot.sequence)
        camera.mark(shot.owner, shot.image_count, self._heard_s, PHOTO_S)

    # -- services.Service ----------------------------------------------------------------------

    def step(self, moment: Moment) -> None:
        """Advances the oldest photo of each camera, with what was received in the tick before."""
        self._heard_s = moment.heard_s
        for shot in self._first_ones():
            shot.step(moment.heard_s)

    def take(self, moment: Moment, message: Message) -> None:
        """Takes a camera's message; any component may turn out to be a camera."""
        _, component = source(message)
        kind, now_s = message.get_type(), moment.heard_s
        camera = self._camera(component)
        camera.heard_s = now_s
        shots = [shot for shot in self._first_ones() if shot.camera is camera]
        if kind == CAPTURE_STATUS:
            camera.take_status(now_s, message)
        elif kind == IMAGE:
            for shot in shots:
                shot.take_image(now_s, message)
            camera.take_image(message.image_index, message.capture_result == 1)
        elif kind == STORAGE:
            for shot in shots:
                shot.take_storage(message)
        elif kind == "COMMAND_ACK" and message.command == SHOOT:
            if message.target_component in (0, COMPONENT):
                for shot in shots:
                    shot.take_answer(now_s, message)

    def due(self, moment: Moment) -> list[Message]:
        """What to ask the cameras now."""
        if moment.is_quiet:
            return []
        now_s, system = moment.heard_s, self._wire.system
        return [message for shot in self._first_ones() for message in shot.due(now_s, system)]

    def release(self) -> None:
        """Drops all photos; what is known of the cameras is kept."""
        self._shots.clear()

    def _camera(self, component: int) -> KnownCamera:
        return self._cameras.setdefault(component, KnownCamera(component))

    def _first_ones(self) -> list[PhotoShot]:
        """The oldest photo of each camera."""
        return list(
            {shot.camera.component: shot for shot in reversed(self._shots.values())}.values()
        )
