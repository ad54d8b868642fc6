"""What the acting side knows of what an autopilot stores for a mission: a fence, rally points.

It is read and written on the ground alone, disarmed. `plan_store.py` and the services that use it
fulfil the port over MAVLink.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from companion.geofence import FenceArea, StoredFence
from companion.geometry import NorthEast
from companion.rally_points import RallyPoint, StoredRally
from companion.vehicle.outcome import Outcome


class AutopilotStore(Protocol):
    """One kind of what an autopilot stores."""

    @property
    def outcome(self) -> Outcome:
        """What has become of the last `read` or `write`."""

    def locate(self) -> Outcome:
        """Ask where the autopilot's frame lies on the earth; call it every tick while RUNNING."""

    def read(self) -> None:
        """Begin to ask for what is there."""

    def is_own(self) -> bool:
        """Whether what was read last was written by this companion, now or in another flight."""

    def is_as_written(self) -> bool:
        """Whether what was read last is what was written last, wherever the frame is by now."""


class AutopilotFence(AutopilotStore, Protocol):
    """The fence of a vehicle's autopilot."""

    @property
    def stored(self) -> StoredFence | None:
        """What was read last; None before, and where it is not known where it lies."""

    @property
    def home(self) -> NorthEast | None:
        """The autopilot's home in the mission's frame; None where that is not known."""

    @property
    def objections(self) -> Sequence[str]:
        """What the autopilot has said, since the last `write`, of areas that it leaves out."""

    def write(self, areas: Sequence[FenceArea]) -> None:
        """Begin to put a fence in the place of the one that is there."""

    def is_vouched_for(self) -> bool:
        """Whether what was read last is known to be in force."""

    def vouch(self) -> None:
        """What was written last was read back, and nothing was said against it."""


class AutopilotRally(AutopilotStore, Protocol):
    """The rally points of a vehicle's autopilot."""

    @property
    def stored(self) -> StoredRally | None:
        """Those that were read last; None before, and where it is not known where they lie."""

    @property
    def has_written(self) -> bool:
        """Whether this companion has ever written some, to whichever vehicle."""

    def write(self, points: Sequence[RallyPoint]) -> None:
        """Begin to put some, or none, in the place of those that are there."""
