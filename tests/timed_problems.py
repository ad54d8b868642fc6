"""Random small problems with bounds in time, of which every clock can be looked at."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from random import Random

from problems import asking, move

from companion.ltl.automaton import successors
from companion.ltl.parser import parse
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within
from companion.ltl.translate import translate
from companion.mission.facts import Fact
from companion.planning.bound_clocks import after, begun
from companion.planning.domain import WAIT
from companion.planning.lasso import Conjunct, Letter, Problem
from companion.planning.unread_rises import UnreadRises

TASKS = (
    "patrolling({every})",
    "patrolling({every})",
    "patrolling({every})",
    "patrolling({some})",
    "ordered_patrolling({some})",
    "F at({a}) & F at({b})",
    "F at({a}) & F G at(H)",
    "G F at({a}) & G !at({b})",
    "G (at({a}) -> X at({b})) & G F at({a})",
    "G F (at({a}) | at({b})) & G F at(H)",
    "G F at({a}) | F G at({b})",
)


def with_bounds(asked: Problem, bounds: dict[str, TimeBound], letter: Letter) -> Problem:
    """A problem with bounded lines besides, which have read one letter."""
    states = list(asked.automaton_states)
    conjuncts = list(asked.conjuncts)
    shown: list[int | None] = [None] * len(states)
    for name, bound in bounds.items():
        automaton = translate(bound.untimed)
        conjuncts.append(Conjunct(name, bound.untimed, automaton, bound))
        before = asking(str(bound.untimed), (), [letter])
        states.append(before.automaton_states[0])
        shown += begun(conjuncts[-1:], letter)
    return replace(
        asked,
        conjuncts=tuple(conjuncts),
        automaton_states=tuple(states),
        clocks_ms=tuple(shown),
    )


def at(place: str) -> str:
    """The fact as a text."""
    return f"at({place})"


def timed_problem(seed: int) -> Problem:
    """A map, sites, a task, and bounds between too short and long enough."""
    chance = Random(seed)
    sites = "ABCDE"[: chance.choice((2, 3, 3, 4, 4, 5))]
    places = "H" + sites
    legs = _legs(chance, places)
    pairs = (pair for pair in itertools.permutations(places, 2) if pair in legs)
    actions = [move(*pair, legs[pair]) for pair in pairs]
    some = chance.sample(sites, min(2, len(sites)))
    a, b, *_ = chance.sample(sites, len(sites))
    task = chance.choice(TASKS).format(every=", ".join(sites), some=", ".join(some), a=a, b=b)
    letter = frozenset({Fact.parse("at(H)")})
    if chance.random() < 0.4:
        letter |= {Fact.parse("alarm")}
    asked = asking(task, [*actions, WAIT], [letter])
    tour_s = _tour_s(legs, places)
    bounds: dict[str, TimeBound] = {}
    for number in range(chance.choice((1, 1, 2, 2, 3))):
        limit_ms = 1000 * round(chance.uniform(0.5, 1.3) * tour_s) + 2000
        goal, trigger = (parse(at(p)) for p in chance.sample(sites, 2))
        kind = chance.choice(("revisit", "revisit", "revisit", "response", "alarm", "within"))
        if kind == "revisit":
            bounds[f"bound{number}"] = Revisit(goal, limit_ms)
        elif kind == "within":
            bounds[f"bound{number}"] = Within(goal, limit_ms)
        else:
            when = trigger if kind == "response" else parse("alarm")
            bounds[f"bound{number}"] = Response(goal, limit_ms, when)
    return with_bounds(asked, bounds, letter)


def _legs(chance: Random, places: str) -> dict[tuple[str, str], float]:
    where = {place: (chance.uniform(0, 9), chance.uniform(0, 9)) for place in places}
    share, wind = chance.choice((1.0, 1.0, 0.85)), chance.choice((1.0, 1.0, 1.5))
    legs = {}
    for a, b in itertools.combinations(places, 2):
        there = max(1, round(math.dist(where[a], where[b])))
        back = max(1, round(there * chance.uniform(1, wind)))
        for pair, seconds in (((a, b), there), ((b, a), back)):
            if chance.random() <= share:
                legs[pair] = float(seconds)
    return legs


def _tour_s(legs: dict[tuple[str, str], float], places: str) -> float:
    sites = places[1:]
    tours = (
        sum(legs.get(pair, 15.0) for pair in itertools.pairwise((sites[0], *rest, sites[0])))
        for rest in itertools.permutations(sites[1:])
    )
    return min(tours)


def later(asked: Problem, seed: int) -> tuple[Problem, list[Letter]] | None:
    """The same after some random flights, maybe with an alarm that has come and gone meanwhile.

    Returns:
        The problem, and the letters that were read; None where a bound or a line was broken.
    """
    chance = Random(seed)
    facts, states, clocks = asked.facts, asked.automaton_states, asked.clocks_ms
    letters = [facts]
    for _ in range(chance.randint(1, 4)):
        flights = [a for a in asked.actions if a.is_applicable(facts) and a is not WAIT]
        if not flights:
            break
        flight = chance.choice(flights)
        facts = flight.apply(facts)
        letters.append(facts)
        states = tuple(
            successors(conjunct.automaton, before, facts)
            for conjunct, before in zip(asked.conjuncts, states, strict=True)
        )
        shown: list[int | None] = []
        for conjunct, elapsed_ms in zip(asked.conjuncts, clocks, strict=True):
            bound, now = conjunct.bound, elapsed_ms
            if bound is not None:
                now = None if now is None else now + flight.cost_ms
                if now is not None and now > bound.planned_ms:
                    return None
                now = after(bound, now, facts)
            shown.append(now)
        clocks = tuple(shown)
        if not all(states):
            return None
    found = replace(asked, facts=facts, automaton_states=states, clocks_ms=clocks)
    alarm = Fact.parse("alarm")
    if alarm not in facts and chance.random() < 0.4:
        found = UnreadRises().with_unread(found, frozenset({alarm}))
    return found, letters
