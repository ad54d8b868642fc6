"""A plan is the best of all lassos: held against the semantics of LTL (`reference_lassos.py`).

The reference knows no automata and no product. It is exhaustive: walks of the transition system
are told apart by where they begin and end and by what their words do to the truth of the task, of
which there are finitely many; none is left out but for a cheaper one that does the same.
"""

from __future__ import annotations

import itertools
import random

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from problems import problem, random_legs, unit_legs
from random_missions import random_mission
from reference_lassos import Reference, TooLarge, Truths
from synthetic import facts_of

from companion.ltl.parser import parse
from companion.ltl.semantics import holds
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT, Effort
from companion.planning.lasso import Letter, Problem, Solution
from companion.planning.objective import Objective


def solution(
    asked: Problem, objective: Objective, effort: Effort = BEFORE_FLIGHT
) -> Solution | None:
    """The last one, which is the best."""
    found = list(Search(asked.actions).solutions(asked, objective, effort))
    return found[-1] if found else None


def compare(seed: int) -> bool:
    """Holds the plans of a random mission against the reference; False if it is too large."""
    asked, letters = random_mission(random.Random(seed))
    try:
        reference = Reference(asked, letters)
        best, best_sum = reference.best_lap_and_prefix(), reference.best_sum()
    except TooLarge:
        return False
    by_lap, by_sum = (solution(asked, objective) for objective in (Objective.LAP, Objective.SUM))
    if best is None:
        assert by_lap is None and by_sum is None and best_sum is None
        return True
    assert by_lap is not None and by_sum is not None
    assert (by_lap.lasso.lap_cost_ms, by_lap.lasso.prefix_cost_ms) == best
    assert by_sum.lasso.lap_cost_ms + by_sum.lasso.prefix_cost_ms == by_sum.cost_ms == best_sum
    for found in (by_lap, by_sum):
        assert found.is_optimal
        assert fault(asked, found.lasso, [letters] * len(asked.conjuncts)) is None
    return True


@pytest.mark.slow
@pytest.mark.parametrize(
    "part", [*range(15), *(pytest.param(n, marks=pytest.mark.long) for n in range(15, 30))]
)
def test_no_lasso_is_better_on_random_missions(part: int) -> None:
    seeds = range(10 * part, 10 * part + 10)
    assert sum(map(compare, seeds)) >= 5


@pytest.mark.long
@pytest.mark.parametrize("part", range(22))
def test_no_lasso_is_better_on_10_000_random_missions(part: int) -> None:
    seeds = range(1000 + 500 * part, 1500 + 500 * part)
    assert sum(map(compare, seeds)) > 450


@pytest.mark.parametrize("seed", range(40))
def test_what_is_promised_in_flight_is_true(seed: int) -> None:
    """With little effort, or none, less is proved; what is proved is so."""
    asked, letters = random_mission(random.Random(seed))
    try:
        reference = Reference(asked, letters)
        best, best_sum = reference.best_lap_and_prefix(), reference.best_sum()
    except TooLarge:
        return
    for effort in (IN_FLIGHT, Effort(80_000, 200, 0, 0, 0)):
        for found in Search(asked.actions).solutions(asked, Objective.LAP, effort):
            assert best is not None and found.bound_ms <= best[0] <= found.cost_ms
            ours = (found.lasso.lap_cost_ms, found.lasso.prefix_cost_ms)
            assert ours == best or not found.is_optimal
        for found in Search(asked.actions).solutions(asked, Objective.SUM, effort):
            assert best_sum is not None and found.bound_ms <= best_sum <= found.cost_ms


# -- Cases -----------------------------------------------------------------------------------------

VISIT_ON_THE_LAP = "F (at(B) & F at(A)) & G F at(A) & G F at(B) & G F at(C)"


def test_what_the_lap_meets_is_not_met_before_it() -> None:
    """The visits come about on the first laps, so the loop is entered at once."""
    asked = problem("ABC", unit_legs("ABC"), VISIT_ON_THE_LAP)
    for objective in (Objective.LAP, Objective.SUM):
        found = solution(asked, objective)
        assert found is not None and found.is_optimal
        assert (found.lasso.prefix_cost_ms, found.lasso.lap_cost_ms) == (0, 3000)


def test_a_cycle_of_two_laps_is_a_loop_of_one() -> None:
    """The automaton needs two positions for a mark, and rest has both in one."""
    asked = problem("A", {}, "G F (at(A) & X X at(A))")
    for objective in (Objective.LAP, Objective.SUM):
        found = solution(asked, objective)
        assert found is not None and found.is_optimal
        assert [len(found.prefix), len(found.loop)] == [0, 1]


def test_many_one_shot_goals_may_be_met_on_the_lap() -> None:
    """Four visits are kept out of the product at first; the lap passes two of them anyway."""
    sites = ["s0", "s1", "s2", "s3"]
    legs = random_legs(random.Random(3), ["H", *sites])
    task = " & ".join(f"F (at({site}) & F at(H))" for site in sites)
    task += " & " + " & ".join(f"F at({site})" for site in sites) + " & G F at(s0) & G F at(s1)"
    asked = problem(["H", *sites], legs, task)
    found = solution(asked, Objective.LAP)
    assert found is not None
    free = solution(problem(["H", *sites], legs, "G F at(s0) & G F at(s1)"), Objective.LAP)
    assert free is not None and found.cost_ms == free.cost_ms


# -- The reference ---------------------------------------------------------------------------------

FORMULAS = [
    "F p & G (q -> X p)",
    "G F (p & X q) | F G q",
    "(p U q) W (X !p)",
    "(p R q) & F (p & X X q)",
    "!(G (p -> F q)) <-> q U p",
]
LETTERS: list[Letter] = [
    facts_of(*some) for n in range(3) for some in itertools.combinations("pq", n)
]
WORDS = st.lists(st.sampled_from(LETTERS), max_size=3)


@drawn(100)
@given(st.sampled_from(FORMULAS), WORDS, WORDS, st.sampled_from(LETTERS))
def test_the_reference_says_what_the_semantics_says(
    text: str, prefix: list[Letter], loop: list[Letter], last: Letter
) -> None:
    truths = Truths(parse(text))
    loop = [*loop, last]
    lap = truths.identity
    for letter in loop:
        lap = lap[truths.function(letter)]
    after = truths.repeated(lap)
    first, *rest = [*prefix, *loop]
    for letter in reversed(rest):
        after = int(truths.function(letter)[after])
    assert bool(truths.holds(first)[after]) is holds(parse(text), prefix, loop)
