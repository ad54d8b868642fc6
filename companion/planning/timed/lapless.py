"""Components in which earlier searches found no lap: they are not searched again for that.

Whether a component has a lap does not depend on where the vehicle is, nor on what clocks and
battery show now. So what was found for one problem holds for another one: for one from a later
position, with other lines of the task, or with less kept in hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from companion.planning.timed.component import TimedComponent

MOST_LAPLESS = 200


class Lapless(NamedTuple):
    """What is known of a component without a known lap.

    Attributes:
        labels: that the search could use; None if it is proved that there is no lap.
        bound_ms: no lap costs less.
    """

    labels: int | None
    bound_ms: int

    @property
    def is_proved(self) -> bool:
        """Whether it is proved that there is no lap."""
        return self.labels is None


class LaplessComponents:
    """The components of one mission in which no lap was found."""

    def __init__(self, found: dict[bytes, Lapless] | None = None) -> None:
        self._found = found or {}

    def copied(self) -> LaplessComponents:
        """Others, the same."""
        return LaplessComponents({**self._found})

    def keep(self, part: TimedComponent, known: Lapless) -> None:
        """No lap was found in a component."""
        self._found.pop(part.fingerprint, None)
        self._found[part.fingerprint] = known
        if len(self._found) > MOST_LAPLESS:
            del self._found[next(iter(self._found))]

    def without_proved(self, parts: Sequence[TimedComponent]) -> list[TimedComponent]:
        """Some components, without those that have no lap."""
        if not self._found:
            return [*parts]
        return [part for part in parts if not self._is_proved(part)]

    def of(self, part: TimedComponent, labels: int) -> Lapless | None:
        """What is known of a component from a search that could use as many labels, or more."""
        known = self._found.get(part.fingerprint) if self._found else None
        if known is None or known.labels is None or known.labels >= labels:
            return known
        return None

    def _is_proved(self, part: TimedComponent) -> bool:
        known = self._found.get(part.fingerprint)
        return known is not None and known.is_proved
