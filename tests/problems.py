"""Planning problems for tests, made without a mission: actions, maps of places, tasks as text."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterable, Mapping, Sequence
from functools import cache

from companion.ltl.automaton import successors
from companion.ltl.conjuncts import conjuncts
from companion.ltl.formula import Formula
from companion.ltl.parser import parse
from companion.ltl.translate import translate
from companion.mission.facts import Atom, Fact, at
from companion.mission.literals import parse_literals
from companion.mission.steps import Fly, Wait
from companion.planning.builtin.search import Search
from companion.planning.domain import WAIT, Action, ConditionalEffect
from companion.planning.lasso import Conjunct, Lasso, Letter, Problem
from companion.planning.objective import Objective

Legs = Mapping[tuple[str, str], float]
"""Seconds of flight between places; a pair that is not there has no way."""


def action(
    name: str,
    when: str = "",
    effect: str = "",
    cost_s: float = 1.0,
    conditional: Iterable[tuple[str, str]] = (),
) -> Action:
    """An action, its literals written as in a mission file.

    Args:
        conditional: pairs of a condition and an effect.
    """
    called = Atom.parse(name)
    requires, forbids = _facts(when)
    adds, deletes = _facts(effect)
    return Action(
        skill=called.predicate,
        arguments=called.arguments,
        requires=requires,
        forbids=forbids,
        assumes=frozenset(),
        adds=adds,
        deletes=deletes,
        cost_ms=round(1000 * cost_s),
        execute=(Wait(cost_s),),
        tries=1,
        timeout_s=None,
        conditional=tuple(
            ConditionalEffect(*_facts(condition), *_facts(effect))
            for condition, effect in conditional
        ),
    )


def _facts(text: str) -> tuple[frozenset[Fact], frozenset[Fact]]:
    literals = parse_literals(text) if text else ()
    return (
        frozenset(x.atom.instantiate({}) for x in literals if x.is_positive),
        frozenset(x.atom.instantiate({}) for x in literals if not x.is_positive),
    )


def move(origin: str, goal: str, cost_s: float) -> Action:
    """A flight between two places."""
    return Action(
        skill="move",
        arguments=(origin, goal),
        requires=frozenset({at(origin)}),
        forbids=frozenset(),
        assumes=frozenset(),
        adds=frozenset({at(goal)}),
        deletes=frozenset({at(origin)}),
        cost_ms=round(1000 * cost_s),
        execute=(Fly(goal),),
        tries=1,
        timeout_s=None,
    )


def asking(task: str, actions: Iterable[Action], letters: Sequence[Iterable[str]]) -> Problem:
    """The problem after a history, whose last letter is the present position."""
    parts = tuple(_conjunct(formula) for formula in conjuncts(parse(task)))
    history = [frozenset(map(Fact.parse, letter)) for letter in letters]
    return Problem((*actions,), parts, history[-1], tuple(_read(part, history) for part in parts))


@cache  # as in a planner, which translates once
def _conjunct(formula: Formula) -> Conjunct:
    return Conjunct(str(formula), formula, translate(formula))


def _read(conjunct: Conjunct, history: Iterable[Letter]) -> frozenset[int]:
    states = conjunct.automaton.initial
    for letter in history:
        states = successors(conjunct.automaton, states, letter)
    return states


def problem(places: Sequence[str], legs: Legs, task: str, extra: Iterable[Action] = ()) -> Problem:
    """A task on a map, from the first of the places."""
    moves = [move(a, b, legs[a, b]) for a, b in itertools.permutations(places, 2) if (a, b) in legs]
    return asking(task, (*moves, *extra, WAIT), [{at(places[0])}])


def unit_legs(places: Sequence[str]) -> Legs:
    """Every place is one second from every other."""
    return dict.fromkeys(itertools.permutations(places, 2), 1.0)


def random_legs(chance: random.Random, places: Sequence[str], is_symmetric: bool = True) -> Legs:
    """Places on a square of 50 m, flown at 2 m/s; against a wind one way may take longer."""
    where = {place: (chance.uniform(0, 50), chance.uniform(0, 50)) for place in places}

    def seconds(a: str, b: str) -> float:
        wind = 1.0 if is_symmetric else chance.uniform(1.0, 1.6)
        return max(0.2, round(wind * math.dist(where[a], where[b]) / 2, 1))

    legs = {pair: seconds(*pair) for pair in itertools.combinations(places, 2)}
    back = {(b, a): legs[a, b] if is_symmetric else seconds(b, a) for a, b in legs}
    return legs | back


def surveillance(sites: int, legs: Legs) -> Problem:
    """The paper's mission with many sites s0, s1, ... around H: search, upload, return.

    No target has been found, and that is an event: nothing but the search is left to do.
    """
    places = ["H", *(f"s{i}" for i in range(sites))]
    search = " & ".join(f"(F at({place}) | targetFound)" for place in places[1:])
    task = (
        f"G ({search}) & G ((targetFound | targetReported) -> F targetReported)"
        " & G (targetReported -> X at(H))"
    )
    upload = action("upload(H)", "at(H) & targetFound", "targetReported", 10.0)
    return problem(places, legs, task, [upload])


def histories(asked: Problem) -> list[list[Letter]]:
    """At the beginning each conjunct has read the present position and nothing else."""
    return [[asked.facts] for _ in asked.conjuncts]


def find_lasso(asked: Problem, objective: Objective = Objective.LAP) -> Lasso | None:
    """The best lasso that is found, or None if the task cannot be done from here."""
    lasso = None
    for solution in Search().solutions(asked, objective):
        lasso = solution.lasso
    return lasso


def names(lasso: Lasso | None) -> tuple[list[str], list[str]]:
    """The actions of a lasso: prefix and loop."""
    assert lasso is not None
    return [a.name for a in lasso.prefix], [a.name for a in lasso.loop]
