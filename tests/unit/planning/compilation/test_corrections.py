"""Each correction of the paper is needed: without it a plan is missed, or a wrong one is found."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

from compiled import history, outcome, planned, problem, unit_costs

from companion.ltl.translate import state_based
from companion.planning.compilation.classical import ClassicalAction, ClassicalProblem
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.domain import WAIT
from companion.planning.lasso import Conjunct, Problem
from companion.planning.objective import Encoding, Objective

NOTHING: frozenset[str] = frozenset()


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
