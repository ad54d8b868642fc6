"""How strongly each factor is related to the score of the rows and to their failures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from companion.campaigns.outcomes import FlownRow
from companion.campaigns.statistics import rank_correlation

if TYPE_CHECKING:
    from companion.flights.simulated_world import Factor

QUARTERS = 4


@dataclass(frozen=True, slots=True)
class FactorEffect:
    """The effect of a factor.

    Attributes:
        correlation: rank correlation with the score; None for values that are no numbers.
        groups: for each value, or quarter of the rows by value: its name, failures, rows.
    """

    path: str
    correlation: float | None
    groups: tuple[tuple[str, int, int], ...]

    @property
    def strength(self) -> float:
        """How much the factor matters, 0 to 1: its correlation, or the spread of failure rates."""
        shares = [failed / total for _, failed, total in self.groups if total]
        spread = max(shares, default=0.0) - min(shares, default=0.0)
        return abs(self.correlation) if self.correlation is not None else spread


def effects(factors: Sequence[Factor], valid: Sequence[FlownRow]) -> list[FactorEffect]:
    """The effect of each factor, the strongest first.

    Args:
        factors: that vary.
        valid: the rows that count.
    """
    found = [_effect(factor.path, valid) for factor in factors] if valid else []
    return sorted(found, key=lambda each: (-round(each.strength, 6), each.path))


def _effect(path: str, valid: Sequence[FlownRow]) -> FactorEffect:
    values = [each.row.values[path] for each in valid]
    if any(isinstance(value, str) for value in values):
        return FactorEffect(path, None, _by_value(path, valid))
    numbers = [float(value) for value in values]
    correlation = rank_correlation(numbers, [each.score for each in valid])
    if len(set(numbers)) <= QUARTERS:
        return FactorEffect(path, correlation, _by_value(path, valid))
    return FactorEffect(path, correlation, _by_quarter(path, valid))


def _by_value(path: str, valid: Sequence[FlownRow]) -> tuple[tuple[str, int, int], ...]:
    groups: dict[str, list[bool]] = {}
    for each in valid:
        value = each.row.values[path]
        name = str(value).lower() if isinstance(value, bool) else str(value)
        groups.setdefault(name, []).append(each.is_failure)
    return tuple((name, sum(failed), len(failed)) for name, failed in sorted(groups.items()))


def _by_quarter(path: str, valid: Sequence[FlownRow]) -> tuple[tuple[str, int, int], ...]:
    ordered = sorted(valid, key=lambda each: (float(each.row.values[path]), each.row.index))
    groups = []
    for quarter in range(QUARTERS):
        first, last = (len(ordered) * end // QUARTERS for end in (quarter, quarter + 1))
        if rows := ordered[first:last]:
            low, high = rows[0].row.values[path], rows[-1].row.values[path]
            name = f"{float(low):.3g} to {float(high):.3g}"
            groups.append((name, sum(each.is_failure for each in rows), len(rows)))
    return tuple(groups)
