"""Which lines of a task are kept: greedily, the most important first, and no search for nothing."""

from __future__ import annotations

from collections.abc import Collection
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic import event, mission, planner

from companion.errors import SearchLimit
from companion.ltl.formula import TRUE
from companion.ltl.translate import translate
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import Effort
from companion.planning.explain import NoPlan
from companion.planning.lasso import Conjunct, DroppedLine, Problem
from companion.planning.objective import Encoding
from companion.planning.optional_lines import (
    NO_PLAN,
    NOT_KNOWN,
    line_to_take_up,
    select,
    without_lines,
)
from companion.planning.planner import Planner

LINES = ("must", *"abcd")
OPTIONAL = LINES[1:]
Conflict = frozenset[str]

conflicts = st.lists(st.frozensets(st.sampled_from(LINES), min_size=1, max_size=3), max_size=5)


def problem_of(lines: Collection[str]) -> Problem:
    automaton = translate(TRUE)
    conjuncts = tuple(Conjunct(line, TRUE, automaton) for line in lines)
    return Problem((), conjuncts, frozenset(), (frozenset({0}),) * len(conjuncts))


WHOLE = problem_of(LINES)


class Oracle:
    """A search that knows which lines conflict, and counts how often it was asked."""

    def __init__(self, conflicts: Collection[Conflict], unknown: Collection[Conflict] = ()) -> None:
        self.conflicts, self.unknown, self.asked = conflicts, unknown, 0

    def __call__(self, problem: Problem) -> bool | None:
        self.asked += 1
        return self.holds({conjunct.name for conjunct in problem.conjuncts})

    def holds(self, lines: Collection[str]) -> bool | None:
        if any(conflict <= set(lines) for conflict in self.conflicts):
            return False
        return None if any(limit <= set(lines) for limit in self.unknown) else True


def names(dropped: Collection[DroppedLine]) -> list[str]:
    return [each.line for each in dropped]


def best_by_definition(oracle: Oracle) -> set[str] | None:
    """Of all subsets that have a plan the first in lexicographic order of importance."""
    sets = [
        {"must", *chosen} for n in range(len(OPTIONAL) + 1) for chosen in combinations(OPTIONAL, n)
    ]
    possible = [kept for kept in sets if oracle.holds(kept)]
    return max(possible, key=lambda kept: [line in kept for line in OPTIONAL], default=None)


@given(conflicts)
def test_what_is_kept_is_the_best_by_importance(conflicts: list[Conflict]) -> None:
    oracle = Oracle(conflicts)
    dropped = names(select(WHOLE, OPTIONAL, oracle))
    best = best_by_definition(oracle)
    assert dropped == [line for line in OPTIONAL if best is None or line not in best]


@given(conflicts)
def test_one_search_where_all_is_kept_and_few_where_not(conflicts: list[Conflict]) -> None:
    oracle = Oracle(conflicts)
    dropped = select(WHOLE, OPTIONAL, oracle)
    assert oracle.asked == 1 if not dropped else oracle.asked <= len(OPTIONAL) + 2


@given(conflicts, conflicts)
def test_a_line_is_taken_up_if_and_only_if_the_best_choice_is_another_one(
    before: list[Conflict], now: list[Conflict]
) -> None:
    """The lines kept so far can still be kept; whether more can is asked."""
    dropped = names(select(WHOLE, OPTIONAL, Oracle(before)))
    oracle = Oracle(now)
    if not oracle.holds(set(LINES) - set(dropped)):
        return
    best = names(select(WHOLE, OPTIONAL, oracle))
    first = [line for line in OPTIONAL if (line in best) != (line in dropped)][:1]
    oracle.asked = 0
    assert line_to_take_up(WHOLE, OPTIONAL, dropped, oracle) == next(iter(first), None)
    assert oracle.asked <= len(dropped)


def test_where_no_line_is_optional_nothing_is_searched() -> None:
    oracle = Oracle([frozenset({"must"})])
    assert select(problem_of(["must"]), (), oracle) == ()
    assert oracle.asked == 0


def test_a_search_that_is_given_up_drops_the_line_and_says_so() -> None:
    oracle = Oracle([frozenset({"a"})], unknown=[frozenset({"c"})])
    dropped = select(WHOLE, OPTIONAL, oracle)
    assert dropped == (DroppedLine("a", NO_PLAN), DroppedLine("c", NOT_KNOWN))


def test_parts_of_a_problem_belong_together() -> None:
    made = planner(mission({"a": "G F at(A)", "b": "F at(B) & G F at(H)"}))
    problem, histories = made.initial_problem()
    histories = [[*histories[0]], [*histories[1], *histories[1]], histories[2]]
    rest, read = without_lines(["a"], problem, histories)
    assert [conjunct.name for conjunct in rest.conjuncts] == ["b", "b"]
    assert rest.automaton_states == problem.automaton_states[1:]
    assert read == histories[1:]


# -- with the search -------------------------------------------------------------------------------

PATROL = {"home": "G F at(H)", "near": "G F at(A)", "far": "G F at(B)", "calm": "G !at(A)"}


def patrol(**priorities: int) -> Planner:
    return planner(mission(PATROL, priorities=priorities))


def test_a_plan_keeps_what_is_important() -> None:
    made = patrol(near=1, far=1, calm=2)
    plan = made.plan()
    assert names(plan.dropped) == ["near"]
    assert {action.name for action in plan.loop} == {"move(H, B)", "move(B, H)"}
    assert plan.as_json()["dropped"] == [{"line": "near", "reason": NO_PLAN}]
    assert names(patrol(near=2, far=1, calm=1).plan().dropped) == ["calm"]


def test_a_plan_without_what_was_dropped_is_the_plan_of_a_mission_without_it() -> None:
    less = {name: text for name, text in PATROL.items() if name != "near"}
    assert patrol(near=1).plan().lasso == planner(mission(less)).plan().lasso


def test_the_lines_that_are_never_dropped_may_have_no_plan() -> None:
    made = planner(
        mission({"never": "F !at(H) & G at(H)", "far": "F at(B)"}, priorities={"far": 1})
    )
    with pytest.raises(NoPlan) as reason:
        made.plan()
    assert {conjunct.name for conjunct in reason.value.explanation.conflict} == {"never"}
    explanation = made.explain()
    assert explanation is not None and explanation == reason.value.explanation


def test_a_line_that_has_to_be_dropped_is_no_reason_for_no_plan() -> None:
    assert patrol(near=1).explain() is None


def test_why_a_line_was_dropped_names_what_it_conflicts_with() -> None:
    made = patrol(near=1)
    plan = made.plan()
    why = made.solver.why_dropped(made.initial_problem()[0], plan.dropped, "near")
    assert {conjunct.name for conjunct in why.conflict} == {"near", "calm"}


def test_a_line_that_gives_way_to_a_more_important_one_conflicts_with_that_one() -> None:
    made = patrol(near=2, far=1, calm=1)
    plan = made.plan()
    why = made.solver.why_dropped(made.initial_problem()[0], plan.dropped, "calm")
    assert {conjunct.name for conjunct in why.conflict} == {"near", "calm"}


def test_the_product_is_that_of_the_lines_that_are_kept() -> None:
    graph = patrol(near=1).product().to_networkx()
    assert "G F at(A)" not in graph.graph["conjuncts"]


def test_a_supposed_state_may_keep_more() -> None:
    lines = {"home": "G F at(H)", "wet": "G (rain -> F at(A))", "dry": "G (rain -> !at(A))"}
    made = planner(mission(lines, events=[event("rain")], priorities={"wet": 1, "dry": 2}))
    assert made.plan().dropped == ()
    assert names(made.plan(facts={"rain"}).dropped) == ["wet"]


def test_an_engine_plans_with_the_lines_that_are_kept() -> None:
    made = patrol(near=1)
    plan = made.plan(engine="pyperplan", encoding=Encoding.V5)
    problem, histories = without_lines(["near"], *made.initial_problem())
    assert names(plan.dropped) == ["near"] and plan.engine == "pyperplan v5"
    assert fault(problem, plan.lasso, histories) is None


def test_a_limit_of_the_search_drops_what_it_is_for(monkeypatch: pytest.MonkeyPatch) -> None:
    product = Search.product

    def limited(search: Search, problem: Problem, effort: Effort) -> object:
        if any(conjunct.name == "far" for conjunct in problem.conjuncts):
            raise SearchLimit("80,000 edges of the product")
        return product(search, problem, effort)

    monkeypatch.setattr(Search, "product", limited)
    lines = {"home": "G F at(H)", "far": "G F at(B)"}
    made = planner(mission(lines, priorities={"far": 1}))
    assert made.plan().dropped == (DroppedLine("far", NOT_KNOWN),)
