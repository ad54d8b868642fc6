"""A campaign in a few lines: how many rows ended how, and against another table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

from companion.campaigns.outcomes import FlownRow, Outcome
from companion.campaigns.statistics import Comparison, compare
from companion.campaigns.table import Table, read_table
from companion.errors import MissionError

SAME = ("format", "scenario", "seed", "limit_s")
"""Lines of the header that have to be equal for the rows of two tables to be the same."""


def summary(flown: Iterable[FlownRow]) -> list[tuple[str, int, bool]]:
    """What became of the rows: the name of each end, how many, and whether it is a failure."""
    counts = Counter((each.kind or each.outcome.value, each.is_failure) for each in flown)
    order = [outcome.value for outcome in Outcome]

    def rank(name: str) -> tuple[int, str]:
        outcome = name.partition(":")[0]
        return (order.index(outcome) if outcome in order else len(order)), name

    listed = [(name, count, is_failure) for (name, is_failure), count in counts.items()]
    return sorted(listed, key=lambda entry: rank(entry[0]))


def failures_in(table: Table) -> list[tuple[int, bool]]:
    """Index of each row of a table that counts, and whether it failed."""
    return [
        (int(row["index"]), float(row["score"]) < 0)
        for row in table.rows
        if row["outcome"] != Outcome.INVALID.value
    ]


def compared(before: Path, now: Path) -> Comparison:
    """Two versions on the same rows.

    Raises:
        MissionError: a table cannot be read, or their rows are not the same.
    """
    other, this = read_table(before), read_table(now)
    for name in (*SAME, *(key for key in this.header if key.startswith("vary "))):
        if other.header.get(name) != this.header.get(name):
            raise _not_the_same(before, name, other.header, this.header)
    return compare(failures_in(other), failures_in(this))


def comparison_with(before: Path, now: Path) -> str:
    """The same in words."""
    found = compared(before, now)
    verdict = "more than chance" if found.is_significant else "may be chance"
    lines = [
        f"against    {before}",
        f"worse      {len(found.worse)} rows fail that did not: {_listed(found.worse)}",
        f"better     {len(found.better)} rows do not fail that did: {_listed(found.better)}",
        f"McNemar    p = {found.p:.3g}: {verdict}",
    ]
    return "\n".join(lines)


def _listed(rows: tuple[int, ...], most: int = 10) -> str:
    listed = ", ".join(map(str, rows[:most]))
    return f"{listed}, ..." if len(rows) > most else listed or "none"


def _not_the_same(
    path: Path, name: str, before: Mapping[str, str], now: Mapping[str, str]
) -> MissionError:
    return MissionError(
        f"{path} has other rows: its {name} is {before.get(name, 'not there')}, "
        f"and is {now.get(name, 'not there')} here",
        hint="compare campaigns of one scenario, one --seed and one --limit-s",
    )
