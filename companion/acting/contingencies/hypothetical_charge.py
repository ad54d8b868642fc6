"""The charge of a hypothetical flight."""

from __future__ import annotations

from companion.acting.flight import Flight


class HypotheticalCharge:
    """A charge that is known exactly; fulfils `ChargeSource`.

    Attributes:
        level: the present level, in units of energy.

    Args:
        flight: tells whether its plan has landed the vehicle.
        level: the level at first.
    """

    def __init__(self, flight: Flight, level: int) -> None:
        self._flight, self.level = flight, level

    def least(self) -> int:
        """The level."""
        return self.level

    most = middle = least

    @property
    def is_flown(self) -> bool:
        """Whether the vehicle is in the air, by the plan."""
        return not self._flight.progress.is_landed_by_plan
