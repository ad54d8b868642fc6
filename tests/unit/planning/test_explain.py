"""Why there is no plan: the conjuncts in conflict, the facts out of reach, the belief to blame."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace

import pytest
from leaves import walled_in
from problems import find_lasso
from synthetic import command, event, facts_of, mission, planner

from companion.mission.facts import Fact
from companion.mission.model import Mission
from companion.planning.builtin.search import Search
from companion.planning.explain import Explanation, NoPlan, why_no_plan, world_of
from companion.planning.lasso import Problem
from companion.planning.planner import Planner


def explained(made: Planner, withdrawn: frozenset[Fact] = frozenset()) -> Explanation:
    problem, _ = made.initial_problem()
    problem = replace(problem, facts=problem.facts - withdrawn, withdrawn=withdrawn)
    assert find_lasso(problem) is None
    return why_no_plan(problem, Search().is_solvable, world_of(made.mission, problem))


def why(made: Planner, withdrawn: frozenset[Fact] = frozenset()) -> str:
    return str(explained(made, withdrawn))


# -- Conjuncts -------------------------------------------------------------------------------------


def test_one_conjunct_that_cannot_hold_is_named_with_its_formula() -> None:
    assert why(planner(mission({"go": "F at(A)", "never": "F gone"}))) == (
        "no plan: never cannot hold from here.\n  never: F gone"
    )


def test_conjuncts_that_only_conflict_together_are_named_together() -> None:
    task = {"a": "F at(A)", "near": "G !at(A)", "b": "F at(B)"}
    assert why(planner(mission(task))) == (
        "no plan: a, near cannot hold together from here.\n  a: F at(A)\n  near: G !at(A)"
    )


def test_a_line_with_two_parts_is_named_once() -> None:
    text = why(planner(mission({"line": "F at(A) & G !at(A)"})))
    assert text.startswith("no plan: line cannot hold together from here.")


CONFLICTS = [
    ["F at(A)", "F at(B)", "G !at(B)", "G F at(H)"],
    ["X at(A)", "X at(B)", "F at(H)"],
    ["G (at(A) -> X at(B))", "F at(A)", "G !at(B)", "G !gone"],
    ["F gone", "G !at(B)", "F at(B)"],
]


def only(problem: Problem, names: set[str]) -> Problem:
    kept = [i for i, c in enumerate(problem.conjuncts) if c.name in names]
    return replace(
        problem,
        conjuncts=tuple(problem.conjuncts[i] for i in kept),
        automaton_states=tuple(problem.automaton_states[i] for i in kept),
    )


@pytest.mark.parametrize("formulas", CONFLICTS)
def test_the_named_conjuncts_conflict_and_every_smaller_set_has_a_plan(
    formulas: list[str],
) -> None:
    task = {f"line{i}": formula for i, formula in enumerate(formulas)}
    made = planner(mission(task))
    problem, _ = made.initial_problem()
    first = why(made).splitlines()[0]
    named = {name for name in task if name in first}
    assert find_lasso(only(problem, named)) is None
    for smaller in itertools.combinations(sorted(named), len(named) - 1):
        assert find_lasso(only(problem, set(smaller))) is not None


# -- Beliefs ---------------------------------------------------------------------------------------


def test_the_belief_that_would_help_is_named_and_the_other_is_not() -> None:
    made = planner(mission("F done", skills=[command("do", "at(H)", "done")]))
    withdrawn = facts_of("can_do", "trans_ok(A, B)")
    assert why(made, withdrawn).splitlines()[2:] == [
        "  done can never become true: that needs can_do",
        "  withdrawn: can_do, trans_ok(A, B)",
        "  with can_do there would be a plan",
    ]


def test_each_belief_that_would_help_by_itself_is_named() -> None:
    skills = [command("one", "at(H)", "done"), command("two", "at(H)", "done")]
    made = planner(mission("F done", skills=skills))
    text = why(made, facts_of("can_one", "can_two"))
    assert text.endswith("  with can_one or can_two there would be a plan")


def test_no_belief_is_blamed_where_it_takes_two() -> None:
    made = planner(mission("F done", skills=[command("do", "at(A)", "done")], places="HA"))
    text = why(made, facts_of("can_do", "trans_ok(H, A)"))
    assert text.endswith("  withdrawn: can_do, trans_ok(H, A)")


@pytest.mark.parametrize("count", [1, 2, 3])
def test_exactly_the_beliefs_that_would_help_are_restoring(count: int) -> None:
    skills = [command(f"do{i}", "at(H)", "done") for i in range(count)]
    made = planner(mission("F done & G F at(H)", skills=skills))
    withdrawn = facts_of(*(f"can_do{i}" for i in range(count)), "trans_ok(A, B)")
    found = explained(made, withdrawn)
    assert found.withdrawn == tuple(sorted(withdrawn))
    problem, _ = made.initial_problem()
    for belief in withdrawn:
        facts = problem.facts - withdrawn | {belief}
        assert (find_lasso(replace(problem, facts=facts)) is not None) == (
            belief in found.restoring
        )


def test_without_a_withdrawn_belief_none_is_mentioned() -> None:
    found = explained(planner(mission("F gone")))
    assert (found.withdrawn, found.restoring) == ((), ())
    assert "withdrawn" not in str(found)


# -- Facts out of reach ----------------------------------------------------------------------------


def test_a_fact_is_out_of_reach_for_what_its_skill_needs() -> None:
    """As the paper's upload, when all sites have refused."""
    skills = [command("upload", "at(A) & found", "reported")]
    made = planner(mission("F reported", skills=skills, events=[event("found")]))
    (fact,) = explained(made).unreachable
    assert (fact.fact, fact.needs) == ("reported", (facts_of("found"),))
    assert str(fact) == "reported can never become true: that needs found"
    (fact,) = explained(made, facts_of("can_upload")).unreachable
    assert str(fact) == "reported can never become true: that needs can_upload and found"


def test_every_way_to_make_a_fact_true_is_told_with_what_it_lacks() -> None:
    skills = [
        command("by_hand", "hand", "done"),
        command("by_foot", "foot & at(A)", "done"),
        command("again", "hand", "done"),
    ]
    events = [event("hand"), event("foot")]
    (fact,) = explained(planner(mission("F done", skills=skills, events=events))).unreachable
    assert fact.needs == (facts_of("hand"), facts_of("foot"))
    assert str(fact).endswith("that needs hand or foot")


def test_of_many_ways_some_are_listed_and_all_are_kept() -> None:
    skills = [command(f"do{i}", f"tool{i}", "done") for i in range(9)]
    events = [event(f"tool{i}") for i in range(9)]
    (fact,) = explained(planner(mission("F done", skills=skills, events=events))).unreachable
    assert len(fact.needs) == 9
    assert str(fact).endswith("or tool5 or ...")


def test_a_place_that_no_way_leads_to_is_out_of_reach() -> None:
    made = planner(mission({"go": "F at(A)", "stay": "G !at(C)"}, places="HA"))
    found = explained(made, facts_of("trans_ok(H, A)"))
    assert [str(fact) for fact in found.unreachable] == [
        "at(A) can never become true: that needs trans_ok(H, A)"
    ]
    assert found.restoring == ("trans_ok(H, A)",)


def test_a_fact_that_no_skill_makes_true_is_not_said_to_need_anything() -> None:
    assert explained(planner(mission("F gone"))).unreachable == ()


def test_a_fact_that_is_reachable_is_not_blamed_for_a_conflict_of_lines() -> None:
    task = {"stay": "G at(H)", "go": "F at(A)"}
    assert explained(planner(mission(task))).unreachable == ()


def test_facts_of_lines_that_do_not_conflict_are_left_alone() -> None:
    skills = [command("do", "tool", "done")]
    task = {"stay": "G at(H)", "go": "F at(A)", "work": "F at(H) & G !done"}
    made = planner(mission(task, skills=skills, events=[event("tool")]))
    assert explained(made).unreachable == ()


# -- Routes ----------------------------------------------------------------------------------------


def without_routes(made: Mission, *closed: tuple[str, str]) -> Planner:
    """A planner on whose map some flights have no route."""
    return Planner(made, lambda origin, goal: math.inf if (origin, goal) in closed else 4.0)


def test_a_place_to_which_no_route_leads_is_named() -> None:
    made = mission({"go": "F at(A)", "stay": "G F at(H)"})
    found = explained(without_routes(made, ("H", "A"), ("B", "A")))
    assert found.no_route == ("A",)
    assert str(found) == (
        "no plan: go cannot hold from here.\n  go: F at(A)\n  no route leads to A on the map"
    )


def test_a_place_that_a_skill_needs_is_named_too() -> None:
    made = mission("F done", skills=[command("do", "at(A)", "done")])
    found = explained(without_routes(made, ("H", "A"), ("B", "A")))
    assert str(found).splitlines()[2:] == [
        "  done can never become true: that needs at(A)",
        "  no route leads to A on the map",
    ]


def test_places_that_are_walled_in_together_are_all_named() -> None:
    made = mission("F (at(A) & F at(B))")
    assert explained(without_routes(made, ("H", "A"), ("H", "B"))).no_route == ("A", "B")


def test_a_place_with_a_route_that_is_not_believed_in_has_a_route() -> None:
    made = without_routes(mission("F at(A)"), ("B", "A"))
    found = explained(made, facts_of("trans_ok(H, A)"))
    assert found.no_route == ()
    assert found.restoring == ("trans_ok(H, A)",)


def test_routes_are_not_blamed_for_a_conflict_of_lines() -> None:
    made = mission({"go": "F at(A)", "near": "G !at(A)"})
    assert explained(without_routes(made, ("B", "A"))).no_route == ()


def test_a_map_that_walls_a_place_in_is_to_blame() -> None:
    walled = replace(mission("F at(A)"), grid=walled_in("A"))
    found = Planner(walled).explain()
    assert found is not None and found.no_route == ("A",)


# -- Events ----------------------------------------------------------------------------------------


def test_events_that_a_skill_needs_are_told_with_their_values() -> None:
    skills = [command("do", "at(H) & found & !low", "done")]
    made = planner(mission("F done", skills=skills, events=[event("found"), event("low")]))
    assert str(explained(made)).splitlines()[2:] == [
        "  done can never become true: that needs found",
        "  a plan takes events as they are now: found is false",
    ]


def test_a_line_that_is_violated_is_the_reason_whatever_else_there_is() -> None:
    asked = mission({"away": "G !at(H)", "do": "F done"}, skills=[command("do", "at(A)", "done")])
    found = explained(planner(asked), withdrawn=facts_of("can_do"))
    assert [conjunct.name for conjunct in found.conflict] == ["away"]
    assert "\n  away is violated, whatever is done now\n" in str(found)


@pytest.mark.parametrize(("task", "holds"), [("F found", False), ("G !found", True)])
def test_events_that_the_lines_in_conflict_mention_are_told(task: str, holds: bool) -> None:
    initially = ["at(H)", *(["found"] if holds else [])]
    made = planner(mission(task, events=[event("found"), event("low")], initially=initially))
    found = explained(made)
    assert found.events == {"found": holds}
    value = str(holds).lower()
    assert str(found).endswith(f"  a plan takes events as they are now: found is {value}")


def test_an_event_that_a_skill_must_not_meet_is_told() -> None:
    skills = [command("do", "at(H) & !low", "done")]
    asked = mission("F done", skills=skills, events=[event("low")], initially=["at(H)", "low"])
    assert explained(planner(asked)).events == {"low": True}


def test_events_are_not_told_where_something_else_is_out_of_reach() -> None:
    skills = [command("do", "at(H)", "done")]
    made = planner(
        mission(
            "G (found -> F done)",
            skills=skills,
            events=[event("found")],
            initially=["at(H)", "found"],
        )
    )
    assert explained(made, facts_of("can_do")).events == {}


# -- For programs ----------------------------------------------------------------------------------


def test_as_json_has_all_of_it() -> None:
    skills = [command("upload", "at(A) & found", "reported")]
    task = {"report": "F reported", "go": "F at(B)"}
    made = planner(mission(task, skills=skills, events=[event("found")]))
    found = explained(made, facts_of("can_upload")).as_json()
    assert found == {
        "conflict": [{"name": "report", "formula": "F reported"}],
        "unreachable": [{"fact": "reported", "needs": [["can_upload", "found"]]}],
        "no_route": [],
        "events": {"found": False},
        "withdrawn": ["can_upload"],
        "restoring": [],
        "shortages": [],
        "late": [],
        "barred": [],
    }
    assert json.loads(json.dumps(found)) == found


def test_the_error_carries_its_explanation_and_says_it() -> None:
    found = explained(planner(mission("F gone")))
    error = NoPlan(found)
    assert error.explanation is found
    assert str(error) == str(found)


def test_a_place_above_another_one_is_told() -> None:
    """Routes enter the region of no other place that the task mentions, at any height."""
    asked = mission({"both": "F at(A) & F at(B)"})
    above = replace(asked.places["B"], position=(*asked.places["A"].position[:2], -3.5))
    asked = replace(asked, places={**asked.places, "B": above})
    text = why(Planner(asked))
    assert "no route leads to A on the map" in text
    assert "lies in the region of A, seen from above, which no way enters, at any height" in text
