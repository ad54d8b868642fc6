"""Figs. 2-4: the fluents, initial state, goal and actions of the paper's compilation.

The automaton is that of F at(A): state 0 waits, state 1 accepts. There are two places, so at(A) and
at(H) are the facts. Each test gives the figure with its misprints corrected; that each correction
is needed is shown in tests/unit/planning/compilation/test_corrections.py.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import pytest
from compiled import problem, unit_costs

from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.parser import parse
from companion.planning.compilation.classical import ClassicalAction, ClassicalProblem
from companion.planning.compilation.encode import encode
from companion.planning.domain import ConditionalEffect
from companion.planning.lasso import Conjunct
from companion.planning.objective import Encoding

A, H = "at(A)", "at(H)"
NONE: frozenset[str] = frozenset()
ON_A, OFF_A, ANY = Label(frozenset({A}), NONE), Label(NONE, frozenset({A})), Label(NONE, NONE)


def when(requires: Iterable[str], adds: str, forbids: str | None = None) -> ConditionalEffect[str]:
    """requires, not forbids -> adds."""
    unwanted = frozenset({forbids}) if forbids else NONE
    return ConditionalEffect(frozenset(requires), unwanted, frozenset({adds}), NONE)


@pytest.fixture(scope="module")
def compiled() -> ClassicalProblem:
    transitions = (
        Transition(0, OFF_A, 0, frozenset()),
        Transition(0, ON_A, 1, frozenset()),
        Transition(1, ANY, 1, frozenset({0})),
    )
    automaton = BuchiAutomaton(2, frozenset({0}), transitions, 1)
    asked = problem("HA", unit_costs("HA"), "true")
    task = Conjunct("visit", parse("F at(A)"), automaton)
    return encode(
        replace(asked, conjuncts=(task,), automaton_states=(frozenset({0}),)), Encoding.V1
    )


def action(compiled: ClassicalProblem, name: str) -> ClassicalAction:
    return next(a for a in compiled.actions if a.name == name)


def test_figure_2_fluents(compiled: ClassicalProblem) -> None:
    """acptBA never changes and is in the names of the loop actions; actNop is `wait`."""
    assert set(compiled.fluents) == {
        *(A, H),
        *("currBA(0)", "currBA(1)", "nxtBA(0)", "nxtBA(1)", "reqLp(1)"),
        *(f"{name}({fact})" for name in ("req", "nreq", "end") for fact in (A, H)),
        *("mv1Done", "endDone", "BAturn", "endBA", "inLp", "LpS"),
    }


def test_figure_2_initial_state_and_goal(compiled: ClassicalProblem) -> None:
    """The automaton has read the present position, so it is not its turn."""
    assert compiled.init == {H, "currBA(0)"}
    assert compiled.goal == {"inLp", "LpS", "endBA", f"end({A})", f"end({H})"}


def test_figure_2_the_automaton_moves_in_two_halves(compiled: ClassicalProblem) -> None:
    mv_ba1, mv_ba2 = action(compiled, "mvBA1"), action(compiled, "mvBA2")
    assert mv_ba1.requires == {"BAturn"}
    assert mv_ba1.forbids == {"mv1Done", "endDone"}
    assert mv_ba1.adds == {"mv1Done"}
    assert mv_ba1.deletes == {"currBA(0)", "currBA(1)"}
    assert set(mv_ba1.conditional) == {
        when({"currBA(0)"}, "nxtBA(0)", forbids=A),
        when({"currBA(0)", A}, "nxtBA(1)"),
        when({"currBA(1)"}, "nxtBA(1)"),
    }
    assert mv_ba2.requires == {"mv1Done"}
    assert mv_ba2.forbids == mv_ba2.adds == NONE
    assert mv_ba2.deletes == {"mv1Done", "BAturn", "nxtBA(0)", "nxtBA(1)"}
    assert set(mv_ba2.conditional) == {
        when({"nxtBA(0)"}, "currBA(0)"),
        when({"nxtBA(1)"}, "currBA(1)"),
    }


def test_figure_3_the_loop_begins(compiled: ClassicalProblem) -> None:
    """In an accepting state, which is remembered and kept alone, and so are the facts."""
    assert compiled.loops == {"actLoop(1)"}
    loop = action(compiled, "actLoop(1)")
    assert loop.requires == {"currBA(1)"}
    assert loop.forbids == {"BAturn", "LpS", "endDone"}
    assert loop.adds == {"reqLp(1)", "LpS"}
    assert loop.deletes == {"currBA(0)"}
    assert set(loop.conditional) == {
        *(when({fact}, f"req({fact})") for fact in (A, H)),
        *(when(set(), f"nreq({fact})", forbids=fact) for fact in (A, H)),
    }


def test_figure_3_the_loop_ends(compiled: ClassicalProblem) -> None:
    """`end` is a word of PDDL, so the action is actEnd."""
    end = action(compiled, "actEnd")
    assert end.requires == {"inLp"}
    assert end.forbids == {"endDone", "BAturn"}
    assert end.adds == {"endDone"}
    assert end.deletes == NONE
    assert set(end.conditional) == {
        when({"currBA(1)", "reqLp(1)"}, "endBA"),
        *(when({f"req({fact})", fact}, f"end({fact})") for fact in (A, H)),
        *(when({f"nreq({fact})"}, f"end({fact})", forbids=fact) for fact in (A, H)),
    }


def test_figure_4_actions_of_the_task(compiled: ClassicalProblem) -> None:
    move = action(compiled, "move(H, A)")
    assert move.requires == {H}
    assert move.forbids == {"BAturn", "endDone"}
    assert move.adds == {A, "BAturn"}
    assert move.deletes == {H}
    assert move.conditional == (when({"LpS"}, "inLp"),)
    assert move.stands_for is not None and move.stands_for.name == "move(H, A)"


def test_figure_4_rest_is_an_action_like_the_others(compiled: ClassicalProblem) -> None:
    wait = action(compiled, "wait")
    assert wait.requires == NONE
    assert wait.forbids == {"BAturn", "endDone"}
    assert wait.adds == {"BAturn"}
    assert wait.cost > 0


def test_only_actions_of_the_task_cost_anything(compiled: ClassicalProblem) -> None:
    assert all((a.cost > 0) == (a.stands_for is not None) for a in compiled.actions)


def test_there_are_no_other_actions(compiled: ClassicalProblem) -> None:
    names = {"move(H, A)", "move(A, H)", "wait", "mvBA1", "mvBA2", "actLoop(1)", "actEnd"}
    assert {a.name for a in compiled.actions} == names
