"""A campaign in a few lines: how its rows ended, and the comparison with another table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.statistics import Comparison
from companion.campaigns.table import Table, header_lines, header_of, read_table
from companion.errors import MissionError

SAME = ("format", "scenario", "seed", "limit_s")
"""Header lines that must be equal for two tables to have the same rows."""


def summary(flown: Iterable[FlownRow]) -> list[tuple[str, int, bool]]:
    """For each way in which rows ended: its name, their number, and whether it is a failure."""
    counts = Counter((each.kind or each.outcome.value, each.is_failure) for each in flown)
    order = [outcome.value for outcome in RowOutcome]

    def rank(name: str) -> tuple[int, str]:
        outcome = name.partition(":")[0]
        return (order.index(outcome) if outcome in order else len(order)), name

    listed = [(name, count, is_failure) for (name, is_failure), count in counts.items()]
    return sorted(listed, key=lambda entry: rank(entry[0]))


def why_invalid(flown: Iterable[FlownRow]) -> str:
    """Why rows do not count: the most frequent reason."""
    reasons = Counter(each.reason for each in flown if each.outcome is RowOutcome.INVALID)
    ((reason, count),) = reasons.most_common(1)
    most = "most: " if count < reasons.total() else ""
    return f"of no account; {most}{reason}"


def failures_in(table: Table) -> list[tuple[int, bool]]:
    """For each row of a table that counts: its index, and whether it failed."""
    return [
        (int(row["index"]), float(row["score"]) < 0)
        for row in table.rows
        if row["outcome"] != RowOutcome.INVALID.value
    ]


def earlier_table(path: Path, header: Mapping[str, str]) -> Table:
    """An earlier table of the same rows.

    Raises:
        MissionError: it cannot be read, or has other rows.
    """
    table, header = read_table(path), header_of(header_lines(header))
    if "budget" in table.header:
        raise MissionError(
            f"{path} is the table of a search; its rows cannot be compared",
            hint="compare with the table of a campaign",
        )
    for name in (*SAME, *(key for key in header if key.startswith("vary "))):
        if table.header.get(name) != header.get(name):
            raise _not_the_same(path, name, table.header, header)
    try:
        rows = failures_in(table)
    except (KeyError, TypeError, ValueError) as error:
        raise MissionError(
            f"{path} has a row that does not belong to a campaign ({error!r})",
            hint="it takes the columns index, outcome and score as they were written",
        ) from error
    if not rows:
        raise MissionError(f"{path} has no row that counts: there is nothing to compare with")
    return table


def in_words(path: Path, found: Comparison) -> str:
    """The comparison of two versions on the same rows, in words.

    Args:
        path: the path of the earlier table.
        found: the comparison.
    """
    verdict = "more than chance" if found.is_significant else "may be chance"
    lines = [
        f"against    {path}, {found.rows} rows that count in both",
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
