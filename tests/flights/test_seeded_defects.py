"""A defect that is put into the companion is found by the search, though it seldom shows.

    scripts/test -m long -n 2 -rP tests/flights/test_seeded_defects.py

It is searched with three seeds, and the search is left at its first failure. Without the defect
none of its rows fails. How many random rows meet it is printed beside it, of as many as the search
may fly, and asserts nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import pytest
from seeded_defects import DEFECTS, Defect

from companion.campaigns.campaign import random_rows
from companion.campaigns.kit import Kit
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.processes import accepted
from companion.campaigns.rows import Row
from companion.campaigns.search import FailureSearch
from companion.campaigns.worker import fly_row

pytestmark = pytest.mark.long

BUDGET = 150
SEEDS = (0, 1, 2)


class Found(Exception):
    """The first failure is there."""


class UntilFailure:
    """Flies rows in this process, in which the defect is, and stops at the first failure.

    Attributes:
        flown: the failure is the last of them.
    """

    def __init__(self, kit: Kit) -> None:
        self._packed = kit.packed
        self.flown: list[FlownRow] = []

    def __call__(self, rows: Sequence[Row]) -> tuple[FlownRow, ...]:
        for row in rows:
            self.flown.append(accepted(fly_row(self._packed, row)))
            assert self.flown[-1].outcome is not RowOutcome.ERROR, self.flown[-1].reason
            if self.flown[-1].is_failure:
                raise Found
        return tuple(self.flown[len(self.flown) - len(rows) :])

    def __str__(self) -> str:
        is_found = self.flown[-1].is_failure
        return f"after {len(self.flown)} rows" if is_found else f"not in {len(self.flown)} rows"


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
def test_the_search_finds_it(defect: Defect, seed: int) -> None:
    kit = defect.kit()
    searched, drawn, without = UntilFailure(kit), UntilFailure(kit), UntilFailure(kit)
    with pytest.MonkeyPatch.context() as patch:
        defect.put_in(patch)
        with pytest.raises(Found):
            FailureSearch(kit.factors, seed, BUDGET).run(searched)
        with suppress(Found):
            drawn(random_rows(kit, seed, BUDGET))
    without([each.row for each in searched.flown])
    print(f"{defect.name}, seed {seed}: {searched}; at random {drawn}")
