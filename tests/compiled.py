"""Small tasks for tests of compiled planning, and a planner of a page to solve them.

The planner is uniform-cost search by the definition of PDDL: it takes an encoding at its word,
where some planners hide its mistakes.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable
from typing import NamedTuple

from companion.ltl.automaton import successors
from companion.ltl.conjuncts import conjuncts
from companion.ltl.parser import parse
from companion.ltl.translate import translate
from companion.mission.facts import Atom, Fact, at
from companion.mission.steps import Wait
from companion.planning.check import fault
from companion.planning.compilation.classical import ClassicalProblem
from companion.planning.compilation.decode import decode
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.domain import WAIT, Action, ConditionalEffect
from companion.planning.lasso import Conjunct, Lasso, Letter, Problem
from companion.planning.objective import Encoding, Objective


def action(
    name: str,
    requires: Iterable[str] = (),
    adds: Iterable[str] = (),
    deletes: Iterable[str] = (),
    cost_s: float = 1.0,
    conditional: tuple[ConditionalEffect[Fact], ...] = (),
) -> Action:
    """An action by its facts."""
    called = Atom.parse(name)
    return Action(
        skill=called.predicate,
        arguments=called.arguments,
        requires=_facts(requires),
        forbids=frozenset(),
        assumes=frozenset(),
        adds=_facts(adds),
        deletes=_facts(deletes),
        cost_ms=round(1000 * cost_s),
        execute=(Wait(cost_s),),
        tries=1,
        timeout_s=None,
        conditional=conditional,
    )


def problem(
    places: str,
    cost_s: dict[tuple[str, str], float],
    task: str,
    extra: tuple[Action, ...] = (),
    past: str = "",
) -> Problem:
    """Moves between all places, rest, and a task; the vehicle is at the last place of the past."""
    letters = _letters(past or places[:1])
    parts = [Conjunct(str(f), f, translate(f)) for f in conjuncts(parse(task))]
    moves = [
        action(f"move({a}, {b})", {f"at({a})"}, {f"at({b})"}, {f"at({a})"}, cost_s[a, b])
        for a, b in itertools.permutations(places, 2)
    ]
    states = [part.automaton.initial for part in parts]
    for letter in letters:
        states = [successors(p.automaton, s, letter) for p, s in zip(parts, states, strict=True)]
    return Problem((*moves, *extra, WAIT), tuple(parts), letters[-1], tuple(states))


def _facts(names: Iterable[str]) -> frozenset[Fact]:
    return frozenset(map(Fact.parse, names))


def history(asked: Problem, past: str = "") -> list[list[Letter]]:
    """What each conjunct has read: the past, or the present position alone."""
    return [_letters(past) or [asked.facts] for _ in asked.conjuncts]


def _letters(places: str) -> list[Letter]:
    return [frozenset({at(place)}) for place in places]


def unit_costs(places: str) -> dict[tuple[str, str], float]:
    """One second for each move."""
    return dict.fromkeys(itertools.permutations(places, 2), 1.0)


def cheapest_plan(classical: ClassicalProblem, max_states: int = 200_000) -> list[str] | None:
    """The names of a cheapest plan's actions; None if there is none (Dijkstra)."""
    order = itertools.count()
    todo = [(0, next(order), classical.init)]
    before: dict[frozenset[str], tuple[int, frozenset[str], str]] = {}
    cost_of = {classical.init: 0}
    while todo:
        cost, _, state = heapq.heappop(todo)
        if cost > cost_of[state]:
            continue
        if classical.goal <= state:
            names = []
            while state != classical.init:
                _, state, name = before[state]
                names.append(name)
            return names[::-1]
        assert len(cost_of) < max_states, "too large for this planner"
        for action in classical.actions:
            if action.is_applicable(state):
                after = action.apply(state)
                reached = cost + action.cost
                if reached < cost_of.get(after, reached + 1):
                    cost_of[after] = reached
                    before[after] = (reached, state, action.name)
                    heapq.heappush(todo, (reached, next(order), after))
    return None


class Outcome(NamedTuple):
    """A cheapest plan, its lasso, and what is wrong with it."""

    names: list[str] | None
    lasso: Lasso | None = None
    fault: str | None = None


def outcome(asked: Problem, classical: ClassicalProblem, past: str = "") -> Outcome:
    """What the planner of a page finds, judged by the problem as it was asked."""
    names = cheapest_plan(classical)
    if names is None:
        return Outcome(None)
    lasso = decode(classical, names)
    return Outcome(names, lasso, fault(asked, lasso, history(asked, past)))


def asked_of(encoding: Encoding, asked: Problem, past: str = "") -> Problem:
    """A problem as an encoding takes it: the paper's has one automaton for the whole task."""
    return monolithic(asked, history(asked, past)) if encoding is Encoding.V1 else asked


def planned(asked: Problem, encoding: Encoding, objective: Objective, past: str = "") -> Outcome:
    """The cheapest plan of a problem in an encoding."""
    return outcome(asked, encode(asked_of(encoding, asked, past), encoding, objective), past)
