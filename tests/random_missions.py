"""Random planning problems: a small map, a lamp, tasks of all kinds, and a history.

Costs are few and small, so that many lassos cost the same.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence

from problems import action, asking, move

from companion.ltl.patterns import PATTERNS
from companion.mission.facts import Fact, at
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Letter, Problem

LAMP = "lamp"
UNARY, BINARY = ("!", "X ", "F ", "G ", "F ", "G F ", "F G "), (" U ", " W ", " R ", " & ", " | ")
LINES = (
    "G F {a}",
    "F {a}",
    "G !{a}",
    "F G {a}",
    "G ({a} -> F {b})",
    "G ({a} -> X {b})",
    "G ({a} -> X F {b})",
    "G ({a} -> X (!{a} W {b}))",
    "G ({a} -> X X {b})",
    "(!{a}) U {b}",
    "{a} W {b}",
    "F ({a} & F {b})",
    "F ({a} & X {b})",
    "G F ({a} & X {b})",
    "G F ({a} & X X {b})",
    "G F ({a} & F ({b} & F {c}))",
    "G F {a} -> G F {b}",
    "F G {a} | G F {b}",
    "G ({a} -> (!{b} U {c}))",
    "X X {a}",
)
FOR_PLACES = (
    "visit",
    "sequenced_visit",
    "ordered_visit",
    "strict_ordered_visit",
    "patrolling",
    "sequenced_patrolling",
    "ordered_patrolling",
)


def random_mission(chance: random.Random) -> tuple[Problem, list[Letter]]:
    """A problem, and the letters that every conjunct has read."""
    places = "ABCD"[: chance.choice((2, 3, 3, 4))]
    actions = _actions(chance, places)
    letters = [frozenset({at(chance.choice(places))})]
    if chance.random() < 0.3:
        letters[0] |= {Fact(LAMP)}
    for _ in range(chance.choice((0, 0, 1, 2, 4))):
        able = [a for a in actions if a.is_applicable(letters[-1])]
        if able:
            letters.append(chance.choice(able).apply(letters[-1]))
    lines = [_line(chance, places) for _ in range(chance.choice((1, 1, 2, 2, 3, 4)))]
    return asking(" & ".join(f"({line})" for line in lines), actions, letters), letters


def _actions(chance: random.Random, places: str) -> list[Action]:
    costs = chance.choice(([0.2], [0.2, 0.3], [0.2, 0.3, 0.5, 0.7]))
    share = chance.choice((0.6, 0.8, 1.0))
    actions = [
        move(a, b, chance.choice(costs))
        for a, b in itertools.permutations(places, 2)
        if chance.random() < share
    ]
    if chance.random() < 0.5:
        where, cost_s = f"at({chance.choice(places)})", chance.choice(costs)
        effects = [(LAMP, f"!{LAMP}"), (f"!{LAMP}", LAMP)]
        actions.append(action("toggle", where, "", cost_s, effects))
    if chance.random() < 0.6:
        actions.append(WAIT)
    return actions


def _line(chance: random.Random, places: str) -> str:
    kind = chance.random()
    if kind < 0.5:
        chosen = {name: _literal(chance, places) for name in "abc"}
        return chance.choice(LINES).format(**chosen)
    if kind < 0.7:
        some = chance.sample(places, chance.randint(2, len(places)))
        return f"{chance.choice(FOR_PLACES)}({', '.join(some)})"
    return _formula(chance, places, chance.choice((1, 2, 3)))


def _literal(chance: random.Random, places: Sequence[str]) -> str:
    atom = LAMP if chance.random() < 0.2 else f"at({chance.choice(places)})"
    return atom if chance.random() < 0.8 else f"!{atom}"


def _formula(chance: random.Random, places: str, depth: int) -> str:
    if not depth:
        return _literal(chance, places)
    if chance.random() < 0.5:
        return f"{chance.choice(UNARY)}({_formula(chance, places, depth - 1)})"
    parts = [_formula(chance, places, chance.randrange(depth)) for _ in range(2)]
    return chance.choice(BINARY).join(f"({part})" for part in parts)


assert set(FOR_PLACES) <= PATTERNS.keys()
