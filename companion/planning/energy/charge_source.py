"""Tells plans how much charge there is: a full battery, unless a flight provides the charge."""

from __future__ import annotations

from typing import Protocol


class ChargeSource(Protocol):
    """Tells the charge that plans reckon with."""

    def least(self) -> int:
        """The lowest level that is possible; on the ground, without the energy for the take-off."""

    def most(self) -> int:
        """The highest level that is possible."""

    def middle(self) -> int:
        """The most likely level."""

    @property
    def is_flown(self) -> bool:
        """Whether the vehicle is in the air."""


class FullBattery:
    """The charge for plans that are made before a flight.

    Args:
        full: its level when full.
    """

    is_flown = False

    def __init__(self, full: int) -> None:
        self._full = full

    def least(self) -> int:
        """The full level."""
        return self._full

    most = middle = least
