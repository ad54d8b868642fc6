"""The search finds failures that chance does not, different ones, and makes them simple.

Flights are replaced by a function of the row: how far it is from balls in the unit cube, in two of
six factors that matter much and two that matter little.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from companion.campaigns.minimising import minimised
from companion.campaigns.outcomes import FlownRow, Margins, RowOutcome
from companion.campaigns.rows import Row, random_row
from companion.campaigns.search import GENERATION, FailureSearch, first_points
from sitl.world.distributions import Chance, Choice, Uniform
from sitl.world.vary import Factor

NAMES = "abcdef"
FACTORS = [Factor(name, (name,), Uniform(0, 1), 0.5) for name in NAMES]
WEIGHTS = np.array([1.0, 1.0, 1.0, 1.0, 0.2, 0.2])
BALLS = {
    "low": (np.array([0.1, 0.15, 0.2, 0.3, 0.5, 0.5]), 0.16),
    "high": (np.array([0.9, 0.85, 0.8, 0.7, 0.5, 0.5]), 0.16),
}
BUDGET = 320


class Flights:
    """Flies rows of the toy, and counts them."""

    def __init__(self) -> None:
        self.rows: list[Row] = []

    def __call__(self, rows: Sequence[Row]) -> tuple[FlownRow, ...]:
        self.rows += rows
        return tuple(map(self.fly, rows))

    def fly(self, row: Row) -> FlownRow:
        point = np.array([float(row.values.get(name, 0.5)) for name in NAMES])
        away = {
            name: float(np.linalg.norm((point - centre) * WEIGHTS)) - radius
            for name, (centre, radius) in BALLS.items()
        }
        nearest = min(away, key=lambda name: away[name])
        margins = Margins(clearance_m=round(away[nearest], 4))
        if away[nearest] >= 0:
            return FlownRow(row, RowOutcome.SATISFIED, margins=margins)
        return FlownRow(row, RowOutcome.VIOLATED, conjunct=nearest, margins=margins)


def kinds_by_chance(seed: int) -> set[str]:
    rows = (random_row(FACTORS, seed, index) for index in range(BUDGET))
    return {flown.kind for flown in map(Flights().fly, rows) if flown.is_failure}


@pytest.mark.long
def test_different_failures_are_found_where_chance_finds_few() -> None:
    for seed in range(3):
        found = FailureSearch(FACTORS, seed, BUDGET).run(Flights())
        assert {each.kind for each in found} == {"violated: low", "violated: high"}
    assert sum(len(kinds_by_chance(seed)) for seed in range(3)) < 6


def test_the_same_seed_is_the_same_search() -> None:
    first, second, other = Flights(), Flights(), Flights()
    for flights, seed in ((first, 1), (second, 1), (other, 2)):
        FailureSearch(FACTORS, seed, 80).run(flights)
    assert first.rows == second.rows != other.rows
    assert [row.index for row in first.rows] == list(range(80))


def test_the_budget_is_kept_to_the_row() -> None:
    for budget in (16, 17, 50):
        flights = Flights()
        FailureSearch(FACTORS, 0, budget).run(flights)
        assert len(flights.rows) == budget


def test_one_factor_or_none_will_do() -> None:
    for factors in (FACTORS[:1], []):
        flights = Flights()
        assert FailureSearch(factors, 0, 48).run(flights) == ()
        assert len(flights.rows) == 48


def test_the_first_points_fill_the_cube() -> None:
    points = np.array(first_points(3, 5, 256))
    assert len(points) == 64
    assert points.min() >= 0 and points.max() < 1
    for axis in range(3):
        counts, _ = np.histogram(points[:, axis], bins=8, range=(0, 1))
        assert set(counts) == {8}
    assert len(first_points(3, 5, GENERATION)) == GENERATION


class Windy(Flights):
    """A flight fails in a wind above 3 m/s if an event happens; another one always does."""

    def fly(self, row: Row) -> FlownRow:
        fails = float(row.values.get("wind", 0.0)) > 3.0 and row.values.get("happens.1", True)
        outcome = RowOutcome.CRASH if fails else RowOutcome.SATISFIED
        if row.seed == 7:
            outcome = RowOutcome.NO_PLAN
        return FlownRow(row, outcome)


def test_a_failure_is_made_of_what_it_needs_alone() -> None:
    factors = [
        Factor("wind", ("wind",), Uniform(-8, 8), 0.0),
        Factor("lidar", ("lidar",), Uniform(0, 1), None),
        Factor("happens.0", ("happens", 0), Chance(1.0), None, is_entry=True),
        Factor("happens.1", ("happens", 1), Chance(1.0), None, is_entry=True),
    ]
    crash = Windy().fly(Row(9, 5, {"wind": 7.5, "lidar": 0.7}))
    no_plan = Windy().fly(Row(8, 7, {"wind": 1.0, "lidar": 0.1}))
    flights = Windy()
    simple, other = minimised([crash, no_plan], factors, flights)
    assert simple.kind == "crash" and simple.row.seed == 0
    assert simple.row.values.keys() == {"wind", "happens.0"}
    assert 3.0 < float(simple.row.values["wind"]) < 3.3
    assert other.kind == "no plan" and other.row.seed == 7
    assert dict(other.row.values) == {"happens.0": False, "happens.1": False}
    assert [row.index for row in flights.rows] == list(range(len(flights.rows)))
    assert len(flights.rows) < 30


class Tangled(Flights):
    """Fails where there is noise, and the wind is much like it."""

    def fly(self, row: Row) -> FlownRow:
        wind, noise = (float(row.values.get(name, 0.0)) for name in ("wind", "noise"))
        fails = noise > 0.5 and abs(wind - noise) <= 5.0
        return FlownRow(row, RowOutcome.CRASH if fails else RowOutcome.SATISFIED)


def test_what_a_failure_no_longer_needs_with_nearer_numbers_goes_back_too() -> None:
    factors = [Factor(name, (name,), Uniform(0, 8), 0.0) for name in ("wind", "noise")]
    flights = Tangled()
    (simple,) = minimised([flights.fly(Row(0, 0, {"wind": 7.0, "noise": 7.0}))], factors, flights)
    assert simple.row.values.keys() == {"noise"}


def test_a_failure_is_made_of_values_that_may_be_chosen() -> None:
    factors = [Factor("wind", ("wind",), Choice((0.0, 8.0), (1.0, 1.0)), 0.0)]
    flights = Windy()
    (simple,) = minimised([flights.fly(Row(0, 0, {"wind": 8.0}))], factors, flights)
    assert dict(simple.row.values) == {"wind": 8.0}
    assert {row.values.get("wind", 0.0) for row in flights.rows} == {0.0}


def test_any_seed_is_one_of_the_search() -> None:
    flights = Flights()
    FailureSearch(FACTORS, 2**32 - 1, 2 * GENERATION).run(flights)
    assert len(flights.rows) == 2 * GENERATION
