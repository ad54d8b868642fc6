"""Falsification from end to end: searches for failures, minimises, writes and checks them.

Everything flown is a row in a folder, so an interrupted falsification is continued by running the
same command again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from companion.campaigns.campaign import Campaign
from companion.campaigns.cases import Case, simplifiable, write_cases
from companion.campaigns.kit import Kit
from companion.campaigns.minimising import minimised
from companion.campaigns.outcomes import FlownRow
from companion.campaigns.processes import LocalProcesses, RowEngine
from companion.campaigns.rows import Row
from companion.campaigns.search import FailureSearch
from companion.flights.simulated_world import varied_world_of

MINIMISED_FOLDER = "minimised"
MOST_CASES = 8
"""Most failures that are minimised; the table has all of them."""


@dataclass(frozen=True, slots=True)
class CheckedCase:
    """A failure as a file, and whether this file alone repeats it in a new process."""

    case: Case
    is_repeated: bool


def falsify(search: Campaign, seed: int, budget: int) -> tuple[FlownRow, ...]:
    """The first failure of each kind and place that a search finds; writes the search's table."""
    failures = FailureSearch(search.kit.factors, seed, budget).run(search.flown)
    search.write_table()
    return failures


def minimise(
    search: Campaign,
    failures: Sequence[FlownRow],
    engine_of: Callable[[Kit], RowEngine],
    tell: Callable[[FlownRow], None],
) -> tuple[FlownRow, ...]:
    """Minimises the failures of a search.

    Args:
        search: the search that found them.
        failures: only the first few are minimised.
        engine_of: makes the engine for a kit; called only if there are failures.
        tell: called with each row that is flown for this.
    """
    if not failures:
        return ()
    kit = simplifiable(search.kit)
    with closing(engine_of(kit)) as engine:
        folder = search.folder / MINIMISED_FOLDER
        with closing(Campaign(kit, engine, folder, search.header, tell)) as simpler:
            simple = minimised(failures[:MOST_CASES], kit.factors, simpler.flown)
    flights = {(each.row.seed, tuple(sorted(each.row.values.items()))): each for each in simple}
    return tuple(flights.values())  # different failures may become the same after minimising


def checked(
    search: Campaign, mission: Path, failures: tuple[FlownRow, ...]
) -> tuple[CheckedCase, ...]:
    """Writes a file for each failure, and flies each file in a process of its own."""
    kit = simplifiable(search.kit)
    return tuple(
        CheckedCase(case, _flown_again(kit, case).kind == case.flown.kind)
        for case in write_cases(kit, mission, search.folder, failures)
    )


def _flown_again(kit: Kit, case: Case) -> FlownRow:
    again = Kit.of(kit.mission, varied_world_of(kit.mission, case.file), kit.limit_s)
    with closing(LocalProcesses(again.packed, 1)) as engine:
        (flown,) = engine.fly([Row(0, case.flown.row.seed)])
    return flown
