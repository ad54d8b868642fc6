"""Compiled tasks: the cheapest plans are the best lassos.

The planner here is the one of a page in `tests/compiled.py`; real ones are in `test_engines.py`.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from compiled import (
    action,
    asked_of,
    cheapest_plan,
    history,
    outcome,
    planned,
    problem,
    unit_costs,
)
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from synthetic import facts_of

from companion.errors import CompanionError
from companion.ltl.automaton import BuchiAutomaton, Label, Transition, statistics
from companion.ltl.parser import parse
from companion.ltl.translate import translate
from companion.planning.builtin.search import Search
from companion.planning.compilation.conditional import unread
from companion.planning.compilation.decode import decode
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.compilation.reduced_task import reduced_task
from companion.planning.domain import WAIT, ConditionalEffect
from companion.planning.lasso import Lasso, Problem
from companion.planning.objective import Encoding, Objective

TASKS = [
    "G F at(A) & G F at(B)",
    "G (F at(A) & F at(B))",
    "F (at(A) & F at(B))",
    "at(H) U at(B)",
    "G (at(A) -> X at(B)) & G F at(A)",
    "F G at(A)",
    "F G (at(A) | at(B)) & G F at(A) & G F at(B)",
    "X (at(A) & X (at(B) & X G at(B)))",
    "(!at(B)) U at(A) & F at(B)",
    "G F (at(A) & F at(B)) & G (at(B) -> X !at(B))",
    "(F G at(A)) | (F G at(B))",
    "G (at(H) -> F at(A)) W at(B)",
    "G F at(A) -> G F at(B)",
    "G !at(A)",
]
IMPOSSIBLE = ["G at(H) & F at(A)", "G F at(A) & F G at(B)", "false", "X at(A) & X at(B)"]
NOTHING: frozenset[str] = frozenset()
NOWHERE: frozenset[int] = frozenset()


def best(asked: Problem, objective: Objective) -> int:
    *_, solution = Search().solutions(asked, objective)
    return solution.cost_ms


# -- Every plan is right, and the best one is found ------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("encoding", Encoding)
@pytest.mark.parametrize("task", TASKS)
def test_a_cheapest_plan_is_a_best_lasso(task: str, encoding: Encoding) -> None:
    costs = {p: 1.0 + i for i, p in enumerate(itertools.permutations("HAB", 2))}
    asked = problem("HAB", costs, task)
    by_sum = planned(asked, encoding, Objective.SUM)
    assert by_sum.fault is None and by_sum.lasso is not None
    sum_ms = by_sum.lasso.prefix_cost_ms + by_sum.lasso.lap_cost_ms
    by_lap = planned(asked, encoding, Objective.LAP)
    assert by_lap.fault is None and by_lap.lasso is not None
    if encoding is Encoding.V1:  # one automaton may ask for more of a loop
        assert sum_ms >= best(asked, Objective.SUM)
        assert by_lap.lasso.lap_cost_ms >= best(asked, Objective.LAP)
    else:
        assert sum_ms == best(asked, Objective.SUM)
        assert by_lap.lasso.lap_cost_ms == best(asked, Objective.LAP)


@pytest.mark.parametrize("encoding", Encoding)
@pytest.mark.parametrize("task", IMPOSSIBLE)
def test_an_impossible_task_has_no_plan(task: str, encoding: Encoding) -> None:
    asked = problem("HAB", unit_costs("HAB"), task)
    assert planned(asked, encoding, Objective.SUM).names is None


@drawn(25)
@given(
    costs=st.lists(st.integers(2, 30), min_size=6, max_size=6),
    task=st.sampled_from(TASKS),
    encoding=st.sampled_from([Encoding.V4, Encoding.V5]),
)
def test_costs_of_any_kind(costs: list[int], task: str, encoding: Encoding) -> None:
    pairs = itertools.permutations("HAB", 2)
    asked = problem("HAB", dict(zip(pairs, map(float, costs), strict=True)), task)
    lasso = planned(asked, encoding, Objective.LAP).lasso
    by_sum = planned(asked, encoding, Objective.SUM).lasso
    assert lasso is not None and by_sum is not None
    *_, wanted = Search().solutions(asked, Objective.LAP)
    found = (lasso.lap_cost_ms, lasso.prefix_cost_ms, by_sum.prefix_cost_ms + by_sum.lap_cost_ms)
    least = (wanted.lasso.lap_cost_ms, wanted.lasso.prefix_cost_ms, best(asked, Objective.SUM))
    product = Search().product(asked)
    if product.facts_of == product.state_of:  # a lap leads to the automata's states as well
        assert found == least
    else:
        assert found[:2] >= least[:2]
        assert found[2] >= least[2]


def test_some_of_these_automata_are_nondeterministic() -> None:
    """Or the tests above would say nothing of them."""
    kinds = [statistics(translate(parse(task))).is_deterministic for task in TASKS]
    assert kinds.count(False) >= 3


# -- States of the automata at the start -----------------------------------------------------------


@pytest.mark.parametrize("encoding", Encoding)
def test_all_states_after_the_history_count(encoding: Encoding) -> None:
    """Of two states that a run may be in only the second leads on; with no state none does."""
    automaton = BuchiAutomaton(
        2,
        frozenset({0, 1}),
        tuple(
            Transition(state, Label(frozenset({f"at({place})"}), NOTHING), state, frozenset({0}))
            for state, place in enumerate("AB")
        ),
        1,
    )
    asked = problem("HAB", unit_costs("HAB"), "X (G at(A) | G at(B))")
    actions = tuple(a for a in asked.actions if not a.name.endswith("A)"))
    only = replace(asked.conjuncts[0], automaton=automaton)
    several = replace(
        asked, actions=actions, conjuncts=(only,), automaton_states=(frozenset({0, 1}),)
    )
    assert str(outcome(several, encode(several, encoding)).lasso) == "move(H, B), (wait)^w"
    for states in (NOWHERE, frozenset({0})):
        stuck = replace(several, automaton_states=(states,))
        assert outcome(stuck, encode(stuck, encoding)).names is None


@pytest.mark.parametrize("encoding", Encoding)
def test_a_history_is_kept(encoding: Encoding) -> None:
    asked = problem("HAB", unit_costs("HAB"), "F at(A) & F at(B)", past="HA")
    found = planned(asked, encoding, Objective.SUM, past="HA")
    assert found.fault is None and str(found.lasso) == "move(A, B), (wait)^w"


def test_histories_may_differ() -> None:
    """An event restarted the second conjunct alone: A is still to be visited, B is not."""
    begun = problem("HAB", unit_costs("HAB"), "F at(B) & F at(A)", past="HAB")
    fresh = problem("BHA", unit_costs("BHA"), "F at(B) & F at(A)")
    states = (begun.automaton_states[0], fresh.automaton_states[1])
    histories = [history(begun, "HAB")[0], history(fresh)[1]]
    asked = replace(begun, automaton_states=states)
    classical = encode(monolithic(asked, histories), Encoding.V1)
    names = cheapest_plan(classical)
    assert names is not None
    assert str(decode(classical, names)) == "move(B, A), (wait)^w"


# -- What is taken out -----------------------------------------------------------------------------


def test_what_cannot_change_is_left_out() -> None:
    never = action("upload", requires={"found"}, adds={"reported"})
    asked = problem("HA", unit_costs("HA"), "G (found -> F reported) & G F at(A)", extra=(never,))
    asked = replace(asked, facts=asked.facts | facts_of("belief"))
    task = reduced_task(asked)
    assert task.changing == ("at(A)", "at(H)")
    assert task.variables == (("at(A)", "at(H)"),)
    assert [a.name for a in task.actions] == ["move(H, A)", "move(A, H)", "wait"]
    for encoding in Encoding:
        fluents = encode(asked_of(encoding, asked), encoding).fluents
        assert not any("found" in f or "reported" in f or "belief" in f for f in fluents)


def test_places_are_no_variable_if_a_vehicle_can_be_at_two() -> None:
    twin = action("twin", requires={"at(H)"}, adds={"at(A)"})
    asked = problem("HA", unit_costs("HA"), "G F at(A)", extra=(twin,))
    assert reduced_task(asked).variables == (("at(A)",), ("at(H)",))


@given(
    cubes=st.lists(
        st.tuples(st.frozensets(st.sampled_from("pqr")), st.frozensets(st.sampled_from("pqr"))),
        max_size=4,
    )
)
def test_unread_labels_match_what_is_left_once(
    cubes: list[tuple[frozenset[str], frozenset[str]]],
) -> None:
    labels = [Label(positive, negative - positive) for positive, negative in cubes]
    rest = unread(labels)
    for size in range(4):
        for letter in map(frozenset, itertools.combinations("pqr", size)):
            matches = sum(label.matches(letter) for label in rest)
            assert matches == (not any(label.matches(letter) for label in labels))


# -- Conditional effects of skills -----------------------------------------------------------------


def lamp_task() -> Problem:
    """A switch turns the lamp on if it is off, and off if it is on."""
    lamp, none = facts_of("lamp"), facts_of()
    switch = action(
        "switch",
        conditional=(
            ConditionalEffect(lamp, none, none, lamp),
            ConditionalEffect(none, lamp, lamp, none),
        ),
    )
    return problem("HA", unit_costs("HA"), "G F lamp & G F !lamp", extra=(switch,))


@pytest.mark.parametrize("encoding", [Encoding.V1, Encoding.V4])
def test_conditional_effects_of_skills_are_encoded(encoding: Encoding) -> None:
    found = planned(lamp_task(), encoding, Objective.LAP)
    assert found.fault is None and found.lasso is not None
    assert [a.name for a in found.lasso.loop] == ["switch", "switch"]


def test_plain_strips_refuses_conditional_effects_by_name() -> None:
    with pytest.raises(CompanionError, match=r"v5 has no conditional effects, but switch has one"):
        encode(lamp_task(), Encoding.V5)


def test_plain_strips_is_plain() -> None:
    asked = problem("HAB", unit_costs("HAB"), "F G at(A) & G F !at(B) & (!at(B)) U at(A)")
    classical = encode(asked, Encoding.V5)
    assert not classical.has_conditional_effects
    assert not any(a.forbids for a in classical.actions)


# -- Bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize("encoding", Encoding)
def test_the_bottleneck_is_refused(encoding: Encoding) -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    with pytest.raises(CompanionError, match="bottleneck"):
        encode(asked_of(encoding, asked), encoding, Objective.BOTTLENECK)


@pytest.mark.parametrize("encoding", Encoding)
def test_a_fact_with_the_name_of_an_auxiliary_is_refused(encoding: Encoding) -> None:
    thief = action("thief", adds={"endDone"})
    asked = problem("HA", unit_costs("HA"), "F endDone", extra=(thief,))
    with pytest.raises(CompanionError, match="endDone"):
        encode(asked_of(encoding, asked), encoding)


def test_the_paper_s_encoding_takes_one_state_based_automaton() -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A) & G F at(H)")
    with pytest.raises(ValueError, match="monolithic"):
        encode(asked, Encoding.V1)


@pytest.mark.parametrize(
    ("names", "complaint"),
    [
        (["fly"], "has not: fly"),
        (["move(H, A)"], "0 loops"),
        (["actLoop", "wait", "actLoop"], "2 loops"),
        (["move(H, A)", "actLoop", "actEnd"], "empty"),
    ],
)
def test_a_malformed_plan_is_refused(names: list[str], complaint: str) -> None:
    classical = encode(problem("HA", unit_costs("HA"), "G F at(A)"), Encoding.V4)
    with pytest.raises(CompanionError, match=complaint):
        decode(classical, names)


def test_a_plan_is_cut_at_the_loop_and_stripped() -> None:
    asked = problem("HA", unit_costs("HA"), "F at(A)")
    go = asked.actions[0]
    classical = encode(asked, Encoding.V4)
    plan = ["move(H, A)", "mvBA", "actLoop", "loop wait", "mvBA", "actEnd"]
    assert decode(classical, plan) == Lasso((go,), (WAIT,))
    assert decode(classical, plan).ends_at_rest
