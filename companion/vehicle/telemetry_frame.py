"""Where the frame of the mission is, by telemetry."""

from __future__ import annotations

from companion.geometry import GlobalOrigin, Ned
from companion.outcomes import Refusal
from companion.vehicle.ports.frame import Anchoring, FrameLocation
from companion.vehicle.telemetry import Telemetry


class TelemetryFrame:
    """Implements `ports.frame.PlacedFrame`.

    Args:
        telemetry: of the vehicle.
    """

    def __init__(self, telemetry: Telemetry) -> None:
        self._telemetry = telemetry

    @property
    def doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is unknown or uncertain; None if it is
        certain."""
        return self._telemetry.frame_doubt

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame is on the earth; None while frames are not known."""
        return self._telemetry.origin

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames are on the earth; None if not known."""
        return self._telemetry.location

    @property
    def anchoring(self) -> Anchoring:
        """What determines where home is."""
        frame = self._telemetry.frame
        if frame.is_recalled:
            return Anchoring.RECALLED
        return Anchoring.FIXED if frame.is_fixed else Anchoring.BY_VEHICLE

    @property
    def is_settling(self) -> bool:
        """Whether the position of the standing vehicle is being averaged."""
        return self._telemetry.frame.is_known and self._telemetry.frame.is_settling

    def gap_m(self, place: Ned) -> float | None:
        """How far from a place the vehicle stands; None until that is certain."""
        return self._telemetry.frame.gap_m(place, self._telemetry.accuracy_m)

    def stand_at(self, place: Ned) -> None:
        """Lays the mission's frame so that the vehicle stands at a place, before the first
        sortie."""
        self._telemetry.stand_at(place)
