"""Plans from where events have risen unread: the first letter has them, and no other one.

What is a plan at all is said by the direct semantics of LTL on the word. That the best one is found
is held against the best of all first actions, each with the best plan after it. Every encoding for
other planners agrees.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from compiled import outcome
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from problems import action, asking, find_lasso, histories, move, names
from synthetic import facts_of

from companion.ltl.automaton import successors
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.domain import WAIT
from companion.planning.lasso import Lasso, Letter, Problem, Solution, word
from companion.planning.objective import Encoding, Objective
from companion.planning.unread_rises import UnreadRises

TASKS = [
    "G (x -> F at(B))",
    "G (x -> X at(B)) & G F at(A)",
    "F (x & at(A))",
    "(!x) U at(B)",
    "G (x -> X !x)",
    "G (F at(A) | x) & G (y -> F at(B))",
    "F x & F y & F at(A) & F at(B)",
    "G (at(A) -> F y) & G F at(B)",
    "G F x",
    "F (x & X (at(B) & !x))",
    "G (y -> F lamp)",
]


@st.composite
def problems(draw: st.DrawFn) -> tuple[Problem, Letter]:
    """A task or two from somewhere, and the events that have risen unread."""
    moves = [
        move(a, b, draw(st.integers(2, 9)) / 10)
        for a, b in itertools.product(["here", *"HAB"], "HAB")
        if a != b
    ]
    extra = [
        action("light", "at(A) & !x", "lamp", 0.4, [("y", "!lamp")]),
        action("need", "at(B) & x", "lamp", 0.1),
    ]
    task = " & ".join(draw(st.lists(st.sampled_from(TASKS), min_size=1, max_size=2, unique=True)))
    where = draw(st.sampled_from(["at(H)", "at(A)", "at(here)"]))
    present = {where, *draw(st.sets(st.sampled_from("xy")))}
    asked = asking(task, [*moves, *extra, WAIT], [present])
    risen = facts_of(*draw(st.sets(st.sampled_from("xy"), min_size=1)))
    return asked, risen - asked.facts


def last(asked: Problem, objective: Objective) -> Solution | None:
    found = list(Search(asked.actions).solutions(asked, objective))
    return found[-1] if found else None


def best_of_first_actions(asked: Problem, unread: Letter) -> tuple[int, int] | None:
    """Lap and prefix of the best plan that begins with an action and goes on after its letter."""
    found = []
    for first in asked.actions:
        if first.is_applicable(asked.facts):
            after = first.apply(asked.facts)
            states = tuple(
                successors(conjunct.automaton, own, after | unread)
                for conjunct, own in zip(asked.conjuncts, asked.automaton_states, strict=True)
            )
            rest = last(replace(asked, facts=after, automaton_states=states), Objective.LAP)
            if rest is not None:
                lasso = rest.lasso
                found.append((lasso.lap_cost_ms, first.cost_ms + lasso.prefix_cost_ms))
    return min(found, default=None)


@drawn(200)
@given(problems())
def test_the_best_plan_is_the_best_first_action_and_the_best_plan_after_it(
    asked: tuple[Problem, Letter],
) -> None:
    plain, unread = asked
    told = UnreadRises().with_unread(plain, unread)
    found, best = last(told, Objective.LAP), best_of_first_actions(plain, unread)
    if found is None or best is None:
        assert found is None and best is None
        return
    lasso = found.lasso
    assert fault(told, lasso, histories(told)) is None
    assert lasso.lap_cost_ms == best[0]
    assert lasso.prefix_cost_ms == best[1] or not lasso.prefix


@pytest.mark.slow
@drawn(40)
@given(problems(), st.sampled_from(Encoding))
def test_every_encoding_has_them_in_the_first_letter(
    drawn: tuple[Problem, Letter], encoding: Encoding
) -> None:
    asked = UnreadRises().with_unread(*drawn)
    if encoding is Encoding.V5:
        asked = replace(asked, actions=tuple(a for a in asked.actions if not a.conditional))
    best = last(asked, Objective.SUM)
    told = monolithic(asked, histories(asked)) if encoding is Encoding.V1 else asked
    planned = outcome(asked, encode(told, encoding, Objective.SUM))
    if best is None or planned.lasso is None:
        assert best is None and planned.names is None
        return
    assert fault(asked, planned.lasso, histories(asked)) is None
    cost_ms = planned.lasso.prefix_cost_ms + planned.lasso.lap_cost_ms
    assert cost_ms >= best.cost_ms, "encodings close a loop only where automata are as before"


def test_a_request_on_the_way_is_answered_although_it_is_over() -> None:
    moves = [move(a, b, 1.0) for a, b in itertools.product(["here", *"HAB"], "HAB") if a != b]
    asked = asking("G (x -> F at(H)) & G F at(A) & G F at(B)", [*moves, WAIT], [{"at(here)"}])
    assert names(find_lasso(asked)) == (["move(here, A)"], ["move(A, B)", "move(B, A)"])
    requested = UnreadRises().with_unread(asked, facts_of("x"))
    prefix, loop = names(find_lasso(requested))
    assert "at(H)" in {name.rpartition(" ")[2].join(["at(", ""]) for name in prefix}
    assert sorted(loop) == ["move(A, B)", "move(B, A)"]


def test_without_a_prefix_the_first_lap_is_read_once() -> None:
    asked = UnreadRises().with_unread(asking("G F x", [WAIT], [{"at(H)"}]), facts_of("x"))
    first, lap = facts_of("at(H)", "x"), facts_of("at(H)")
    assert word(asked, Lasso((), (WAIT, WAIT))) == ([first, lap], [lap, lap])
    assert find_lasso(asked) is None, "one rise is not one again and again"
