"""Where the mission's frame is on the earth, and whether that is certain, by what is heard.

The autopilot says its position in its local frame and on the earth, and where the local frame's
origin is. `mission_frame.py` converts positions; `origin_watch.py` compares what is said.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.geometry import GlobalOrigin, Ned, NorthEast
from companion.mavlink.framing import Message, source
from companion.outcomes import Refusal
from companion.vehicle.laid_frames import LaidFrames
from companion.vehicle.mission_frame import MissionFrame
from companion.vehicle.origin_watch import OriginWatch
from companion.vehicle.ports.frame import Anchoring, FrameLocation


class HeardFrame:
    """Implements `ports.frame.PlacedFrame`.

    Args:
        mission: the frame of the mission, which is laid and moved here.
        laid: where missions' frames were laid before; None if that is not remembered.
        on_move: is called when all positions in the frame change.

    Attributes:
        origins: where the autopilot's local frame is on the earth.
    """

    def __init__(
        self, mission: MissionFrame, laid: LaidFrames | None, on_move: Callable[[], None]
    ) -> None:
        self.origins = OriginWatch()
        self._mission, self._laid, self._on_move = mission, laid, on_move
        self._system, self._boot_s = 0, 0.0
        self._has_position = False

    @property
    def doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is unknown or uncertain; None if it is
        certain."""
        watch = self.origins
        is_wanting = self._mission.anchor is not None and watch.origin is None
        if not self._has_position or not (watch.is_doubted or is_wanting):
            return None
        if watch.residual_m is None:
            return Refusal("the autopilot does not say where its local frame lies on the earth")
        about = f"are {watch.residual_m:.1f} m apart, by its GPS_GLOBAL_ORIGIN"
        return Refusal(f"the autopilot's LOCAL_POSITION_NED and GLOBAL_POSITION_INT {about}")

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame is on the earth; None while frames are not known."""
        is_known = self._mission.is_known and self.origins.residual_m is not None
        return self._mission.reference if is_known else None

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames are on the earth; None if not known."""
        frame, residual_m = self._mission, self.origins.residual_m
        if frame.reference is None or (zero := frame.zero) is None or residual_m is None:
            return None
        return FrameLocation(frame.reference, zero, frame.anchor is not None, residual_m)

    @property
    def anchoring(self) -> Anchoring:
        """What determines where home is."""
        if self._mission.is_recalled:
            return Anchoring.RECALLED
        return Anchoring.FIXED if self._mission.is_fixed else Anchoring.BY_VEHICLE

    @property
    def is_settling(self) -> bool:
        """Whether the position of the standing vehicle is being averaged."""
        return self._mission.is_known and self._mission.is_settling

    def gap_m(self, place: Ned, accuracy_m: float) -> float | None:
        """How far from a place the vehicle stands; None until that is certain."""
        return self._mission.gap_m(place, accuracy_m)

    def stand_at(self, place: Ned) -> None:
        """Lays the frame so that the vehicle stands at a place, before its first sortie."""
        self._mission.lay(place)
        if self._laid is not None:
            self._laid.note(self._mission, self._system, self._boot_s)
        self._on_move()

    def move(self, by: NorthEast, most_m: float) -> None:
        """Moves the frame: the vehicle is that much further than its position says.

        Args:
            by: north and east.
            most_m: greatest distance by which the frame may be moved in all.
        """
        self._mission.move(by, most_m)
        self._on_move()

    def anchor_at(self, anchor: GlobalOrigin | None) -> None:
        """Begins a mission with this origin; None if the mission begins where the vehicle
        stands."""
        self._mission.anchor_at(anchor)
        self._on_move()

    def take_local(self, now_s: float, message: Message, is_standing: bool) -> None:
        """Takes a LOCAL_POSITION_NED whose numbers are finite."""
        self._system, self._boot_s = source(message)[0], message.time_boot_ms / 1000
        position = (message.x, message.y, message.z)
        self.origins.take_local(self._boot_s, position, (message.vx, message.vy, message.vz))
        self._follow_origin()
        self._has_position = True
        self._mission.take_position(now_s, position, is_standing)
        if self._laid is not None:
            self._laid.recall(self._mission, self._system, self._boot_s)

    def take_global(self, _: float, message: Message) -> None:
        """Takes a GLOBAL_POSITION_INT."""
        self.origins.take_global(message)
        self._follow_origin()

    def take_origin(self, _: float, message: Message) -> None:
        """Takes a GPS_GLOBAL_ORIGIN."""
        self.origins.take_origin(message)
        self._follow_origin()

    def take_home(self, _: float, message: Message) -> None:
        """Takes a HOME_POSITION."""
        position = (message.x, message.y, message.z)
        if all(map(math.isfinite, position)):
            self._mission.take_home(position, message.altitude / 1000)

    def _follow_origin(self) -> None:
        origin = self.origins.origin
        if origin is not None and origin != self._mission.reference:
            self._mission.take_reference(origin)
