"""What becomes of the failures of a search."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path

from varied import SEED, ThisProcess, short_kit

from companion.campaigns.campaign import Campaign
from companion.campaigns.falsification import minimise
from companion.campaigns.kit import Kit
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row, random_row


class Failing(ThisProcess):
    """All rows fail, whatever is in them."""

    def fly(self, rows: Iterable[Row]) -> Iterator[FlownRow]:
        yield from (FlownRow(row, RowOutcome.CRASH, place="Gate") for row in rows)


def test_failures_that_are_one_when_they_are_simple_are_one(tmp_path: Path) -> None:
    kit = short_kit()
    rows = [random_row(kit.factors, SEED, index) for index in range(2)]
    failures = [FlownRow(row, RowOutcome.CRASH, place=f"A{row.index}") for row in rows]

    def engine_of(simpler: Kit) -> ThisProcess:
        return Failing(simpler)

    search = Campaign(kit, Failing(kit), tmp_path, {"seed": "3"}, lambda flown: None)
    with closing(search):
        (simple,) = minimise(search, failures, engine_of, lambda flown: None)
    assert simple.row.seed == 0 and not any(simple.row.values.values())
