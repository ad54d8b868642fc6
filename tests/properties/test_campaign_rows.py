"""Rows are points of the unit cube: each is a possible scenario, and none depends on others."""

from __future__ import annotations

import json
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from varied import short_kit

from companion.campaigns.outcomes import FlownRow, Margins, RowOutcome
from companion.campaigns.rows import SEEDS, Row, chance, random_row, row_at
from companion.campaigns.table import read_table, table_text, write_whole
from sitl.world.distributions import Chance, Choice, Distribution, Normal, Uniform

UNIT = st.floats(0, 1, exclude_max=True)
NUMBERS = st.floats(-1e4, 1e4)
RANGES = st.tuples(NUMBERS, NUMBERS).filter(lambda r: r[1] - r[0] > 1e-3).map(lambda r: Uniform(*r))
BELLS = st.tuples(NUMBERS, st.floats(0.1, 9.0)).map(
    lambda b: Normal(b[0], b[1], b[0] - 2 * b[1], b[0] + b[1])
)
INDICES = st.integers(0, 10**6)


@given(st.one_of(RANGES, BELLS), UNIT, UNIT)
def test_numbers_rise_with_their_share_and_stay_within_their_ends(
    distribution: Uniform | Normal, one: float, other: float
) -> None:
    low, high = (float(end) for end in distribution.extremes)
    less, more = (float(distribution.value(u)) for u in sorted((one, other)))
    assert low <= less <= more <= high
    assert less == float(f"{less:.6g}")


@given(UNIT, st.floats(0, 1))
def test_choices_are_taken_by_their_weights(u: float, share: float) -> None:
    choice: Distribution = Choice((True, False), (share, 1 - share)) if share else Chance(0.0)
    assert choice.value(u) == Chance(share).value(u)


@given(INDICES, INDICES)
def test_a_row_needs_no_other_row_and_no_other_factor(seed: int, index: int) -> None:
    factors = short_kit().factors
    row = random_row(factors, seed, index)
    assert row == random_row(factors, seed, index)
    backwards = random_row(factors[::-1], seed, index)
    assert backwards.values == row.values and backwards.seed == row.seed
    few = random_row(factors[:2], seed, index)
    assert dict(few.values).items() <= dict(row.values).items()
    assert 0 <= row.seed < SEEDS


@given(st.lists(UNIT, min_size=5, max_size=5))
def test_each_point_of_the_cube_is_a_scenario(point: list[float]) -> None:
    kit = short_kit()
    row = row_at(kit.factors, 0, 0, point)
    scenario, grid = kit.scenario.world(row.values)
    assert grid is not None and scenario.wind[1] == row.values["wind.east_mps"]


@given(INDICES, st.integers(0, 2**64), st.sampled_from(["a", "b", "seed"]))
def test_chances_lie_in_the_unit_interval(index: int, seed: int, path: str) -> None:
    assert 0 <= chance(seed, index, path) < 1


MARGINS = st.one_of(st.none(), st.floats(-9, 9).map(lambda m: round(m, 4) + 0.0))
FLOWN = st.builds(
    FlownRow,
    row=st.builds(Row, INDICES, INDICES, st.just({"a": 1.5, "b": True}), st.integers(0, 9)),
    outcome=st.sampled_from(RowOutcome),
    conjunct=st.text(max_size=5).filter(lambda t: "\n" not in t and "\r" not in t),
    margins=st.builds(Margins, clearance_m=MARGINS, charge=MARGINS),
    track=st.just(((1.0, 2.0), (3.0, 4.5))),
)


@given(FLOWN)
def test_a_row_is_the_same_after_it_was_kept(flown: FlownRow) -> None:
    kept: Any = json.loads(json.dumps(flown.as_json()))
    assert FlownRow.of_json(kept) == flown


@given(st.lists(FLOWN, max_size=5, unique_by=lambda each: each.row.index))
def test_a_table_is_the_same_in_any_order_and_reads_as_it_was_written(
    tmp_path_factory: Any, rows: list[FlownRow]
) -> None:
    text = table_text({"format": "1", "seed": "3"}, ["a", "b"], rows)
    assert text == table_text({"format": "1", "seed": "3"}, ["a", "b"], rows[::-1])
    path = tmp_path_factory.getbasetemp() / "table.csv"
    write_whole(path, text)
    read = read_table(path)
    assert read.header == {"format": "1", "seed": "3"}
    assert [int(row["index"]) for row in read.rows] == sorted(each.row.index for each in rows)


@given(FLOWN)
def test_a_failure_is_what_has_a_score_below_zero(flown: FlownRow) -> None:
    assert flown.is_failure == (flown.score < 0)
    assert bool(flown.kind) == flown.is_failure
