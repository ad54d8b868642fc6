"""What tells how much charge there is, in units of energy: a full battery until a flight does."""

from __future__ import annotations

from typing import Protocol


class ChargeSource(Protocol):
    """Tells the charge that plans reckon with."""

    def least(self) -> int:
        """The least that there may be; on the ground without what taking off takes."""

    def most(self) -> int:
        """The most that there may be."""

    def middle(self) -> int:
        """What there is, about."""

    @property
    def is_flown(self) -> bool:
        """Whether the vehicle is in the air."""


class FullBattery:
    """That of plans which are made before a flight.

    Args:
        full: what it holds, in units.
    """

    is_flown = False

    def __init__(self, full: int) -> None:
        self._full = full

    def least(self) -> int:
        """All of it."""
        return self._full

    most = middle = least
