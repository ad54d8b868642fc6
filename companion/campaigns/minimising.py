"""Minimises failures: the fewest and smallest changes of a scenario with the same failure.

Factor by factor, the value of the file is tried instead (delta debugging, Zeller, 2002). Numbers
that have to differ are brought nearer to it by bisection. Events are left out; seed 0 is tried. A
change is kept if the flight still fails in the same way. Several failures are minimised at once,
one row of each at a time, so the result does not depend on the number of processes.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from companion.campaigns.outcomes import FlownRow
from companion.campaigns.rows import Row, Value
from companion.campaigns.search import RowFlyer

if TYPE_CHECKING:
    from companion.flights.simulated_world import Factor

BISECTIONS = 5
Steps = Generator[Row, FlownRow, FlownRow]
"""Yields a row to fly, receives it flown, and returns the simplest row with the same failure."""


def minimised(
    failures: Sequence[FlownRow], factors: Sequence[Factor], fly: RowFlyer
) -> tuple[FlownRow, ...]:
    """The failures, each as simple as possible.

    Args:
        failures: as they were found.
        factors: what may be reset, including the entries of `happens`.
        fly: flies rows.
    """
    under_way = {i: _steps(failure, factors) for i, failure in enumerate(failures)}
    simplest: dict[int, FlownRow] = {}
    sent: dict[int, FlownRow] = {}
    number = 0
    while under_way:
        asked: dict[int, Row] = {}
        for i, steps in [*under_way.items()]:
            try:
                row = steps.send(sent[i]) if i in sent else next(steps)
            except StopIteration as end:
                simplest[i] = end.value
                del under_way[i]
                continue
            asked[i] = replace(row, index=number)
            number += 1
        flown = fly([*asked.values()])
        sent.update(zip(asked, flown, strict=True))
    return tuple(simplest[i] for i in range(len(failures)))


def _steps(failure: FlownRow, factors: Sequence[Factor]) -> Steps:
    best = failure

    def trial(values: Mapping[str, Value], seed: int | None = None) -> Row:
        return Row(0, best.row.seed if seed is None else seed, dict(values))

    best = yield from _put_back(best, failure, factors)
    for factor in factors:
        best = yield from _nearer(best, failure, factor)
    best = yield from _put_back(best, failure, factors)  # then more may be reset
    for factor in factors:
        if factor.is_entry and factor.path not in best.row.values:
            flown = yield trial({**best.row.values, factor.path: False})
            best = flown if _is_alike(flown, failure) else best
    if best.row.seed != 0:
        flown = yield trial(best.row.values, seed=0)
        best = flown if _is_alike(flown, failure) else best
    return best


def _put_back(best: FlownRow, failure: FlownRow, factors: Sequence[Factor]) -> Steps:
    """The failure, with the file's values wherever it still fails in the same way."""
    for factor in factors:
        if factor.path in best.row.values:
            rest = {k: v for k, v in best.row.values.items() if k != factor.path}
            flown = yield replace(best.row, values=rest)
            best = flown if _is_alike(flown, failure) else best
    return best


def _nearer(best: FlownRow, failure: FlownRow, factor: Factor) -> Steps:
    """The failure, with a number as near to the file's as it still fails in the same way."""
    usual, value = factor.usual, best.row.values.get(factor.path)
    if not (factor.is_range and _is_number(usual) and _is_number(value)):
        return best
    assert isinstance(usual, int | float) and isinstance(value, int | float)
    near, far = float(usual), float(value)
    for _ in range(BISECTIONS):
        middle = float(f"{(near + far) / 2:.3g}")
        if middle in (near, far) or not min(near, far) < middle < max(near, far):
            break
        row = replace(best.row, values={**best.row.values, factor.path: middle})
        flown = yield row
        if _is_alike(flown, failure):
            best, far = flown, middle
        else:
            near = middle
    return best


def _is_number(value: Value | None) -> bool:
    return isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool))


def _is_alike(flown: FlownRow, failure: FlownRow) -> bool:
    return flown.kind == failure.kind
