"""Pads on which a standing, disarmed vehicle gets energy: from a charger, or by another battery.

1. A charger gives its current while the vehicle stands on the pad.
2. A pad that exchanges batteries gives a full one after the vehicle has stood there for a given
   time, once at each visit. The autopilot stays powered meanwhile.
3. A pad that does not work does neither. The time for an exchange starts again when it works.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.geometry import Ned
from sitl.world.visits import Circle


@dataclass(frozen=True, slots=True)
class PadSpec:
    """A pad.

    Attributes:
        name: for events; may be empty.
        current_a: current of its charger.
        swap_s: duration of a battery exchange; None for a charger.
        works: whether it works at the start.
    """

    circle: Circle
    current_a: float = 5.0
    swap_s: float | None = None
    name: str = ""
    works: bool = True


@dataclass(frozen=True, slots=True)
class PadChange:
    """A change of a pad; None leaves a property as it is."""

    name: str
    works: bool | None = None
    current_a: float | None = None


class Pads:
    """All pads of a world.

    Args:
        specs: the first pad under the vehicle serves it.

    >>> pads = Pads([PadSpec(Circle((0.0, 0.0), 1.0), current_a=8.0)])
    >>> pads.step(0.0, (0.2, 0.0, 0.0)), pads.step(1.0, None)
    ((8.0, False), (0.0, False))
    """

    def __init__(self, specs: Sequence[PadSpec]) -> None:
        self._specs = specs
        self._works = [spec.works for spec in specs]
        self._current_a = [spec.current_a for spec in specs]
        self._since_s: float | None = None
        self._is_changed = False

    def change(self, change: PadChange) -> None:
        """Applies a change to all pads of its name."""
        for i, spec in enumerate(self._specs):
            if spec.name == change.name:
                if change.works is not None:
                    self._works[i] = change.works
                if change.current_a is not None:
                    self._current_a[i] = change.current_a

    def step(self, now_s: float, standing: Ned | None) -> tuple[float, bool]:
        """The charger's current, and whether the battery is exchanged in this step.

        Args:
            now_s: simulated time.
            standing: where the vehicle stands disarmed; None in all other cases.
        """
        found = None
        if standing is not None:
            found = next(
                (i for i, s in enumerate(self._specs) if s.circle.contains(standing)), None
            )
        if found is None:
            self._since_s, self._is_changed = None, False
            return 0.0, False
        if not self._works[found]:
            self._since_s = None
            return 0.0, False
        swap_s = self._specs[found].swap_s
        if swap_s is None:
            return self._current_a[found], False
        if self._since_s is None:
            self._since_s = now_s
        is_due = not self._is_changed and now_s - self._since_s >= swap_s
        self._is_changed = self._is_changed or is_due
        return 0.0, is_due

    def _below(self, position: Ned) -> int | None:
        return next((i for i, s in enumerate(self._specs) if s.circle.contains(position)), None)
