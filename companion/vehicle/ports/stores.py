"""The acting side's interface to what an autopilot stores for a mission: a fence, rally points.

It is read and written only on the ground, disarmed. `item_store.py`, and the services that use it,
implement the port over MAVLink.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from companion.geofence import FenceArea, StoredFence
from companion.geometry import NorthEast
from companion.outcomes import Outcome
from companion.rally_points import RallyPoint, StoredRally


class AutopilotStore(Protocol):
    """One kind of items that an autopilot stores."""

    @property
    def outcome(self) -> Outcome:
        """What became of the last `read` or `write`."""

    def locate(self) -> Outcome:
        """Ask where the autopilot's frame lies on the earth; call it every tick while RUNNING."""

    def read(self) -> None:
        """Begin to read the stored items."""

    def is_own(self) -> bool:
        """Whether this companion wrote the items that were read last, now or in another flight."""

    def is_as_written(self) -> bool:
        """Whether the items read last are those written last, wherever the frame is by now."""


class AutopilotFence(AutopilotStore, Protocol):
    """The fence of a vehicle's autopilot."""

    @property
    def stored(self) -> StoredFence | None:
        """The fence that was read last; None before that, or if its place is not known."""

    @property
    def home(self) -> NorthEast | None:
        """The autopilot's home in the mission's frame; None if not known."""

    @property
    def objections(self) -> Sequence[str]:
        """What the autopilot has said since the last `write` about areas that it does not
        enforce."""

    @property
    def number(self) -> int | None:
        """A number that differs for another fence, 0 for none; None if not known.

        An autopilot that numbers no fences always says 0.
        """

    def write(self, areas: Sequence[FenceArea]) -> None:
        """Begin to replace the stored fence."""

    def is_vouched_for(self) -> bool:
        """Whether the fence that was read last is known to be in force."""

    def vouch(self) -> None:
        """Note that the fence written last was read back, and that nothing was said against it."""


class AutopilotRally(AutopilotStore, Protocol):
    """The rally points of a vehicle's autopilot."""

    @property
    def stored(self) -> StoredRally | None:
        """The points that were read last; None before that, or if their place is not known."""

    @property
    def has_written(self) -> bool:
        """Whether this companion has ever written rally points, to any vehicle."""

    def write(self, points: Sequence[RallyPoint]) -> None:
        """Begin to replace the stored points by others, or by none."""
