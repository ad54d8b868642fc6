"""One-shot goals: the best path over all of them to a loop, by trying every order."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace

import pytest
from problems import action, asking, histories, problem, random_legs, unit_legs
from reference_search import best_lap_and_prefix

from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import WAIT
from companion.planning.effort import BEFORE_FLIGHT, Effort
from companion.planning.lasso import Problem, Solution
from companion.planning.objective import Objective

ANY_ORDER = replace(BEFORE_FLIGHT, held_karp_additions=0)


def best(asked: Problem, effort: Effort = BEFORE_FLIGHT) -> Solution:
    *_, solution = Search(asked.actions).solutions(asked, effort=effort)
    assert fault(asked, solution.lasso, histories(asked)) is None
    return solution


@pytest.mark.parametrize("sites", range(4, 8))
def test_the_prefix_is_the_shortest_path_over_all_sites(sites: int) -> None:
    """The closed form of a path: it begins at H and ends anywhere."""
    places = "HABCDEFG"[: sites + 1]
    legs = random_legs(random.Random(sites), places)
    found = best(problem(places, legs, " & ".join(f"F at({p})" for p in places[1:])))
    least = min(
        sum(legs[leg] for leg in itertools.pairwise(("H", *order)))
        for order in itertools.permutations(places[1:])
    )
    assert found.lasso.ends_at_rest
    assert found.lasso.prefix_cost_ms == round(1000 * least)


def test_the_goals_come_before_a_loop_that_is_best_elsewhere() -> None:
    """The loop between X and Y is the best, and the way there passes A to D first."""
    places = "HABCDXY"
    legs = {**unit_legs(places), ("X", "Y"): 0.3, ("Y", "X"): 0.3}
    task = " & ".join(f"F at({p})" for p in "ABCD") + " & G F at(X) & G F at(Y)"
    found = best(problem(places, legs, task))
    assert found.lasso.lap_cost_ms == 600
    assert found.lasso.prefix_cost_ms == 5000


@pytest.mark.parametrize("objective", Objective)
def test_a_loop_that_is_out_of_reach_after_the_goals_is_not_taken(objective: Objective) -> None:
    """X and Y are nearest to each other, but from A to D the way leads only to P and Q."""
    legs = {(a, b): 1.0 for a, b in itertools.permutations("HABCD", 2) if b != "H"}
    legs |= {("H", "X"): 1.0, ("X", "Y"): 0.3, ("Y", "X"): 0.3}
    legs |= {("D", "P"): 1.0, ("P", "Q"): 2.0, ("Q", "P"): 2.0}
    task = " & ".join(f"F at({p})" for p in "ABCD")
    task += " & G F (at(X) | at(P)) & G F (at(Y) | at(Q))"
    *_, found = Search().solutions(problem("HABCDXYPQ", legs, task), objective)
    assert {a.name for a in found.lasso.loop} == {"move(P, Q)", "move(Q, P)"}


def test_where_no_path_leads_back_the_order_is_the_only_one() -> None:
    """A river: whoever has passed a site never comes back to it."""
    places = "HDBEACGF"
    legs = {leg: 1.0 for leg in itertools.combinations(places, 2)}
    asked = problem(places, legs, " & ".join(f"F at({p})" for p in sorted(places[1:])))
    for effort in (BEFORE_FLIGHT, ANY_ORDER):
        visited = [a.name[-2] for a in best(asked, effort).lasso.prefix]
        assert visited == [*places[1:]]


def test_a_goal_that_leads_away_from_the_best_loop_is_met_nevertheless() -> None:
    """No path leads back from D, so it comes last, and a loop at home is out of the question."""
    legs = {(a, b): 1.0 for a, b in itertools.permutations("HABCD", 2) if a != "D"}
    asked = problem("HABCD", legs, " & ".join(f"F at({p})" for p in "ABCD"))
    lasso = best(asked).lasso
    assert [lasso.prefix[-1].name[-2], lasso.ends_at_rest] == ["D", True]
    away = problem("HABCD", legs, " & ".join(f"F at({p})" for p in "ABCD") + " & G F at(H)")
    assert list(Search().solutions(away)) == []


def test_a_goal_that_cannot_be_met_leaves_no_plan() -> None:
    asked = problem("HABC", unit_legs("HABC"), "F at(A) & F at(B) & F at(C) & F at(H) & F lit")
    assert list(Search().solutions(asked)) == []
    switch = action("switch", "at(C) & key", "lit")
    both = problem("HABC", unit_legs("HABC"), "F at(A) & F at(B) & F at(C) & F (at(A) & at(B))")
    assert list(Search().solutions(both)) == []
    never = problem("HABC", unit_legs("HABC"), "F at(A) & F at(B) & F at(C) & F lit", [switch])
    assert list(Search().solutions(never)) == []


def test_what_holds_already_has_been_met() -> None:
    """The present position has been read, so one more step there is not asked for."""
    asked = asking("F a & F b & F c & F d & F e", [WAIT], [{"a", "b", "c", "d", "e"}])
    assert str(best(asked).lasso) == "(wait)^w"


def test_what_held_at_the_start_may_have_to_be_met_again() -> None:
    """After X the present position does not count, and without rest it takes a flight to return."""
    legs = random_legs(random.Random(2), "HABC", is_symmetric=False)
    task = "X F at(H) & F at(A) & F at(B) & F at(C)"
    moves = problem("HABC", legs, task).actions[:-1]
    asked = asking(task, [*moves, action("rest", "at(C)", cost_s=0.1)], [{"at(H)"}])
    lasso = best(asked).lasso
    assert (lasso.lap_cost_ms, lasso.prefix_cost_ms) == best_lap_and_prefix(asked)
    assert any(a.name.endswith(", H)") for a in lasso.prefix)


def test_one_action_may_meet_several_goals() -> None:
    all_at_once = action("all", "", "a & b & c & d", 9.0)
    one_by_one = [action(f"do_{x}", "", x, 3.0) for x in "abcd"]
    asked = asking("F a & F b & F c & F d", [*one_by_one, all_at_once, WAIT], [()])
    assert [a.name for a in best(asked).lasso.prefix] == ["all"]
