"""Rows of a campaign that were not flown, and what a report is made of."""

from __future__ import annotations

from varied import SEED, short_kit

from companion.campaigns.outcomes import FlownRow, Margins, RowOutcome
from companion.campaigns.report import ReportSource
from companion.campaigns.rows import random_row

WIND, EVENT = "wind.east_mps", "happens.1"


def flown(index: int) -> FlownRow:
    """A row that fails in a wind from the west above 2 m/s, and has hit something above 3 m/s."""
    row = random_row(short_kit().factors, SEED, index)
    wind = float(row.values[WIND])
    outcome, conjunct = RowOutcome.SATISFIED, ""
    if wind > 2:
        outcome, conjunct = (RowOutcome.CRASH, "") if wind > 3 else (RowOutcome.VIOLATED, "patrol")
    return FlownRow(
        row,
        outcome,
        conjunct,
        reason="the <reason>" if wind > 2 else "",
        margins=Margins(clearance_m=round(3 - wind, 4)),
        duration_s=40 + wind,
        phase="flying the task",
        place="Gate",
        east_m=3.0,
        north_m=4.0,
        track=((0.0, 0.0), (3.0, 4.0)),
    )


def source(rows: list[FlownRow], is_search: bool = False) -> ReportSource:
    header = short_kit().header(SEED, runs=len(rows))
    return ReportSource(short_kit(), header, rows, "companion campaign M", {}, is_search)


ROWS = [flown(index) for index in range(40)]
