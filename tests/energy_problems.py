"""Random small problems with a battery, of which every level can be looked at."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from random import Random

import numpy as np
from problems import Legs, action, asking, move

from companion.ltl.patterns import PATTERNS
from companion.mission.facts import Fact
from companion.planning.charger import Charger
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Energy, Problem

TASKS = (
    "patrolling({every})",
    "patrolling({every})",
    "patrolling({every}) & G !at({b})",
    "ordered_patrolling({some})",
    "sequenced_patrolling({some})",
    "F at({a}) & F at({b}) & F G at(H)",
    "F (at({a}) & F at({b}))",
    "F G at(H)",
    "G F at({a}) & F G !at(H)",
    "G F at({a}) & G !at({b}) & G F at(H)",
    "G F (at({a}) | at({b})) & G F at(H)",
    "G F (at({a}) | at({b})) & G F (at({c}) | at(H))",
    "G F at({a}) | F G at({b})",
    "G (at({a}) -> X at({b})) & G F at({a})",
    "G (at({a}) -> X (!at({a}) W at({b}))) & G F at({a}) & G F at(H)",
    "G F seen & G F at({a}) & G F !seen",
    "G F at({d}) & G F at({a})",
    "(!at({a})) U at({b}) & G F at({a}) & G F at({b})",
    "F at({a}) & G (at({a}) -> X at({b})) & G (at({b}) -> X (at({d}) & X (at({d}) & X at({a}))))",
)
assert {"patrolling", "ordered_patrolling", "sequenced_patrolling"} <= PATTERNS.keys()


def _rates(chance: Random, full: int) -> np.ndarray:
    steps = np.sort(np.array([chance.randint(100, 900) for _ in range(full)]))
    return np.concatenate(([0], np.cumsum(steps))).astype(np.int64)


def energy_problem(seed: int) -> Problem:
    """A map, sites and docks, a task, and a battery that is too small for most of it at once."""
    chance = Random(seed)
    sites = "ABCDE"[: chance.choice((2, 2, 3, 3, 4))]
    docks = "XY"[: chance.choice((1, 1, 2))]
    full, reserve = chance.randint(12, 24), chance.randint(0, 3)
    places = "H" + sites + docks
    legs, drains = _legs(chance, places)
    landings = {place: chance.randint(0, 2) for place in places}
    safe = [*docks, *("H" if chance.random() < 0.8 else "")]
    needs = _needs(places, drains, safe, landings)
    floors = {place: reserve + need for place, need in needs.items()}
    energy = Energy(
        level=chance.choice((full, full, chance.randint(reserve, full))),
        floors=floors,
        rests={place: reserve + landing for place, landing in landings.items()},
        rest=1,
        percents=[100 * level / full for level in range(full + 1)],
    )
    actions = [
        replace(move(a, b, legs[a, b]), drain=drains[a, b])
        for a, b in itertools.permutations(places, 2)
        if (a, b) in legs
    ]
    actions += _charges(chance, docks, full, reserve, landings)
    task = chance.choice(TASKS)
    if "seen" in task:
        where = f"at({chance.choice(sites)})"
        drain = chance.randint(0, 3)
        actions.append(replace(action("look", where, "seen", 1.0), drain=drain))
        actions.append(replace(action("forget", "at(H)", "!seen", 0.5), drain=1))
    some = chance.sample(sites, min(2, len(sites)))
    a, b, c, *_ = [*chance.sample(sites, len(sites)), "H"]
    text = task.format(every=", ".join(sites), some=", ".join(some), a=a, b=b, c=c, d=docks[0])
    return replace(asking(text, [*actions, WAIT], [{"at(H)"}]), energy=energy)


MADE = ("f0", "f1", "f2")
"""Facts that the skills of `with_skills` read and make."""

MORE = ("", "", " & G F f0", " & F (f0 & X f1)", " & X X X !f2", " & G (alarm -> F f1)")


def with_skills(asked: Problem, seed: int) -> Problem:
    """A problem with skills besides, and lines, docks and flights that may ask for what they make.

    Some are done in two ways, one quicker and one thriftier.
    """
    chance = Random(f"skills {seed}")
    places = sorted(asked.energy.floors if asked.energy else ())
    actions = [*asked.actions[:-1], *(_skill(chance, i, places) for i in range(3))]
    key = frozenset({Fact.parse(chance.choice(MADE))})
    if chance.random() < 0.4:
        is_used_up = chance.random() < 0.3
        for number, each in enumerate(actions):
            if each.charger is not None:
                deletes = each.deletes | key if is_used_up else each.deletes
                actions[number] = replace(each, requires=each.requires | key, deletes=deletes)
    if chance.random() < 0.3:  # a place that is never left
        last = chance.choice(places)
        actions = [a for a in actions if a.skill != "move" or a.arguments[0] != last]
    actions += [
        _other_way(chance, a) for a in actions if a.charger is None and chance.random() < 0.3
    ]
    chance.shuffle(actions)
    task = " & ".join(str(each.formula) for each in asked.conjuncts)
    task += chance.choice(
        ("", "", " & G F f0", " & F (f0 & X f1)", " & X X X !f2", " & G (x -> F f1)")
    )
    return replace(asking(task, [*actions, WAIT], [{"at(H)"}]), energy=asked.energy)


def _skill(chance: Random, number: int, places: Sequence[str]) -> Action:
    def literals(most: int) -> str:
        drawn = chance.sample(MADE, chance.randint(0, most))
        return " & ".join(chance.choice(("", "", "!")) + name for name in drawn)

    where = chance.choice(("", f"at({chance.choice(places)})"))
    when = " & ".join(part for part in (where, literals(2)) if part)
    skill = action(f"do{number}", when, literals(2), chance.choice((0.2, 0.5, 2.0)))
    return replace(skill, drain=chance.choice((0, 1, 1, 2, 3)))


def _other_way(chance: Random, each: Action) -> Action:
    """The same by another skill: a flight takes no less than what floors reckon with."""
    cost_ms = max(200, 100 * round(each.cost_ms * chance.choice((0.3, 0.6, 1, 2, 3)) / 100))
    more = chance.choice((0, 1, 2, 4) if each.skill == "move" else (-3, -1, 0, 1, 2, 4))
    return replace(each, skill=f"{each.skill}_", cost_ms=cost_ms, drain=max(0, each.drain + more))


def _legs(chance: Random, places: str) -> tuple[Legs, dict[tuple[str, str], int]]:
    where = {place: (chance.uniform(0, 10), chance.uniform(0, 10)) for place in places}
    share, wind = chance.choice((1.0, 1.0, 0.85)), chance.choice((1.0, 1.3))
    scale = chance.uniform(0.2, 0.8)
    legs, drains = {}, {}
    for a, b in itertools.permutations(places, 2):
        if chance.random() > share:
            continue
        distance = math.dist(where[a], where[b]) + 0.5
        legs[a, b] = round(distance * chance.uniform(1, wind), 1)
        drains[a, b] = math.ceil(scale * distance * chance.uniform(1, wind))
    return legs, drains


def _needs(
    places: str,
    drains: dict[tuple[str, str], int],
    safe: list[str],
    landings: dict[str, int],
) -> dict[str, int]:
    """By the cheapest way of any number of legs, as floors that agree with all routes are."""
    far = 1 << 20
    needs = {place: landings[place] if place in safe else far for place in places}
    for _ in places:
        for (a, b), drain in drains.items():
            needs[a] = min(needs[a], drain + needs[b])
    return {place: need for place, need in needs.items() if need < far}


def _charges(
    chance: Random, docks: str, full: int, reserve: int, landings: dict[str, int]
) -> list[Action]:
    shared, differ = _rates(chance, full), chance.random() < 0.25
    found = []
    for dock in docks:
        landing, take_off = landings[dock], chance.randint(0, 2)
        times_ms = _rates(chance, full) if differ else shared
        overhead_ms = 100 * chance.randint(2, 60)
        charger = Charger(reserve + landing, landing, take_off, overhead_ms, times_ms)
        charge = action(f"recharge({dock})", f"at({dock})", f"at({dock})", overhead_ms / 1000)
        found.append(replace(charge, charger=charger))
    return found
