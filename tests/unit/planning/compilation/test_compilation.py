"""Compiled tasks: the cheapest plans are the best lassos, and each correction is needed.

The planner here is the one of a page in `tests/compiled.py`; real ones are in `test_engines.py`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import pytest
from compiled import Outcome, action, cheapest_plan, history, outcome, problem, unit_costs
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from synthetic import facts_of

from companion.errors import CompanionError
from companion.ltl.automaton import BuchiAutomaton, Label, Transition, statistics
from companion.ltl.parser import parse
from companion.ltl.translate import state_based, translate
from companion.planning.builtin.search import Search
from companion.planning.compilation.classical import ClassicalAction, ClassicalProblem
from companion.planning.compilation.conditional import unread
from companion.planning.compilation.decode import decode
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.compilation.reduced_task import reduced_task
from companion.planning.domain import WAIT, ConditionalEffect
from companion.planning.lasso import Conjunct, Lasso, Problem
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


def asked_of(encoding: Encoding, asked: Problem, past: str = "") -> Problem:
    return monolithic(asked, history(asked, past)) if encoding is Encoding.V1 else asked


def best(asked: Problem, objective: Objective) -> int:
    *_, solution = Search().solutions(asked, objective)
    return solution.cost_ms


def planned(asked: Problem, encoding: Encoding, objective: Objective, past: str = "") -> Outcome:
    return outcome(asked, encode(asked_of(encoding, asked, past), encoding, objective), past)


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
    lamp, none = facts_of("lamp"), NOTHING
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


# -- Each correction of the paper is needed --------------------------------------------------------


def changed(
    classical: ClassicalProblem, prefix: str, change: Callable[[ClassicalAction], ClassicalAction]
) -> ClassicalProblem:
    """The problem with the actions changed whose names begin so."""
    actions = [change(a) if a.name.startswith(prefix) else a for a in classical.actions]
    assert tuple(actions) != classical.actions
    return replace(classical, actions=tuple(actions))


def moving_only(task: str) -> Problem:
    """A system without a step of rest, in which a place must be left."""
    asked = problem("HA", unit_costs("HA"), task)
    return replace(asked, actions=tuple(a for a in asked.actions if a is not WAIT))


def paper(asked: Problem) -> ClassicalProblem:
    return encode(monolithic(asked, history(asked)), Encoding.V1)


def test_e1_the_automaton_s_first_half_move_must_not_have_been_done() -> None:
    asked = problem("HA", unit_costs("HA"), "F at(A)")
    assert outcome(asked, paper(asked)).names is not None
    printed = changed(
        paper(asked),
        "mvBA1",
        lambda a: replace(a, requires=a.requires | {"mv1Done"}, forbids=a.forbids - {"mv1Done"}),
    )
    assert outcome(asked, printed).names is None


def test_e2_the_automaton_must_move_to_the_successor() -> None:
    asked = problem("HA", unit_costs("HA"), "F at(A)")

    def stay(mv_ba1: ClassicalAction) -> ClassicalAction:
        effects = tuple(
            replace(e, adds=frozenset(f.replace("curr", "nxt") for f in e.requires if "BA" in f))
            for e in mv_ba1.conditional
        )
        return replace(mv_ba1, conditional=effects)

    assert outcome(asked, changed(paper(asked), "mvBA1", stay)).names is None


def test_e3_only_the_states_after_the_history_are_current() -> None:
    asked = problem("HA", unit_costs("HA"), "F at(A)")
    right = paper(asked)
    everywhere = {f for f in right.fluents if f.startswith("currBA")}
    assert everywhere > right.init & everywhere
    found = outcome(asked, replace(right, init=right.init | everywhere))
    assert "does not satisfy" in (found.fault or "")


def test_e4_the_loop_must_begin_in_one_state_alone() -> None:
    """F G at(A) where rest is not possible: without the collapse a loop through H is accepted."""
    asked = moving_only("F G at(A)")
    assert outcome(asked, paper(asked)).names is None
    wrong = changed(paper(asked), "actLoop", lambda a: replace(a, deletes=NOTHING))
    assert "does not satisfy" in (outcome(asked, wrong).fault or "")


def test_e5_the_loop_closes_where_a_fact_holds_again() -> None:
    """As the text has it, a required fact must be gone at the end."""
    asked = problem("HA", unit_costs("HA"), "G !at(A)")

    def as_in_the_text(act_end: ClassicalAction) -> ClassicalAction:
        effects = []
        for e in act_end.conditional:
            facts = {f for f in e.requires if not f.startswith(("req", "currBA"))}
            if any(f.startswith("req(") for f in e.requires):
                e = replace(e, requires=e.requires - facts, forbids=frozenset(facts))
            effects.append(e)
        return replace(act_end, conditional=tuple(effects))

    assert outcome(asked, paper(asked)).fault is None
    assert outcome(asked, changed(paper(asked), "actEnd", as_in_the_text)).names is None


def test_e6_the_memory_is_of_all_facts_that_change() -> None:
    """With the formula's propositions alone a loop from r "closes" at s: both have no label."""
    costs = {pair: 1.0 for pair in itertools.permutations("HRS", 2)}
    asked = problem("HRS", costs, "G F !at(H)")
    asked = replace(
        asked,
        actions=tuple(
            a for a in asked.actions if a.name.endswith("(H, R)") or a.name.endswith("(R, S)")
        ),
    )
    right = paper(asked)
    assert outcome(asked, right).names is None
    kept = frozenset(f for f in right.goal if not f.startswith("end(") or f == "end(at(H))")
    assert "does not close" in (outcome(asked, replace(right, goal=kept)).fault or "")


def test_e7_rest_is_an_ordinary_action() -> None:
    """With one actNop, after the loop began and at its end alone, nobody can wait before a move."""
    asked = problem("HA", unit_costs("HA"), "X at(H) & F at(A)")
    assert outcome(asked, paper(asked)).fault is None

    def nop(wait: ClassicalAction) -> ClassicalAction:
        return replace(
            wait,
            requires=wait.requires | {"LpS"},
            forbids=wait.forbids | {"nopDone"},
            adds=wait.adds | {"nopDone"},
        )

    once = changed(paper(asked), "wait", nop)
    once = changed(once, "move", lambda a: replace(a, forbids=a.forbids | {"nopDone"}))
    assert outcome(asked, replace(once, fluents=(*once.fluents, "nopDone"))).names is None


def test_e11_what_holds_for_ever_needs_rest() -> None:
    asked = moving_only("F G at(A)")
    assert outcome(asked, paper(asked)).names is None
    with_rest = replace(asked, actions=(*asked.actions, WAIT))
    assert str(outcome(with_rest, paper(with_rest)).lasso) == "move(H, A), (wait)^w"


def test_an_incomplete_automaton_must_stop_where_it_has_no_run() -> None:
    """v4 deletes a state where it is left; without `deadBA` a rejected word leaves it in place."""
    asked = problem("HAB", {p: 1.0 for p in itertools.permutations("HAB", 2)}, "G !at(A) & F at(B)")
    detour = tuple(a for a in asked.actions if a.name not in ("move(H, B)", "move(B, H)"))
    asked = replace(asked, actions=detour)
    right = encode(asked, Encoding.V4)
    assert outcome(asked, right).names is None

    def survive(mv_ba: ClassicalAction) -> ClassicalAction:
        effects = tuple(e for e in mv_ba.conditional if "deadBA" not in e.adds)
        return replace(mv_ba, conditional=effects)

    assert "does not satisfy" in (outcome(asked, changed(right, "mvBA", survive)).fault or "")


def test_one_automaton_fixes_the_order_of_a_lap() -> None:
    """Three places one way round cost 3, the other way 30; a state-based automaton knows one."""
    around = {("A", "B"), ("B", "C"), ("C", "A")}
    costs = {p: 1.0 if p in around else 10.0 for p in itertools.permutations("ABC", 2)}
    laps = set()
    for task in ("G F at(A) & G F at(B) & G F at(C)", "G F at(C) & G F at(B) & G F at(A)"):
        asked = problem("ABC", costs, task)
        found = planned(asked, Encoding.V1, Objective.LAP).lasso
        free = planned(asked, Encoding.V4, Objective.LAP).lasso
        assert found is not None and free is not None and free.lap_cost_ms == 3000
        laps.add(found.lap_cost_ms)
    assert max(laps) > 3000


def test_a_state_based_conjunct_goes_into_the_paper_s_encoding_as_it_is() -> None:
    asked = problem("HA", unit_costs("HA"), "F at(A)")
    only = asked.conjuncts[0]
    automaton = state_based(replace(only.automaton, initial=asked.automaton_states[0]))
    single = Conjunct(only.name, only.formula, automaton)
    ready = replace(asked, conjuncts=(single,), automaton_states=(automaton.initial,))
    assert outcome(asked, encode(ready, Encoding.V1)).fault is None
