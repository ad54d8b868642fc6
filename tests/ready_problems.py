"""Random small problems with a battery and a line that is ready, and what that means by definition.

Wherever the event comes, the step under way is finished; then the vehicle flies the quickest way to
the answer, and from there to a dock that charges, or else to a safe place. All ways are looked at.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from random import Random

from energy_problems import energy_problem

from companion.ltl.parser import atom
from companion.ltl.time_bounds import Response
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Problem
from companion.planning.readiness import Readiness, ReadyLine


def ready_problem(seed: int) -> tuple[Problem, ReadyLine]:
    """A problem, and a line with a limit between too short and long enough."""
    asked, chance = energy_problem(seed), Random(seed)
    place = chance.choice(sorted({action.arguments[-1] for action in _moves(asked)}))
    ways_s = [action.cost_ms / 1000 for action in _moves(asked)]
    limit_ms = round(1000 * chance.uniform(1.2, 3.5) * max(ways_s)) + 2000
    return asked, ReadyLine(
        "answer", Response(atom(f"at({place})"), limit_ms, atom("alarm")), place
    )


def planned_for(asked: Problem, line: ReadyLine) -> Problem:
    """The problem as a planner sees it."""
    readiness = Readiness([line])
    assert asked.energy is not None
    actions, energy = readiness.on_battery(readiness.allowed(asked.actions), asked.energy)
    return replace(asked, actions=actions, energy=energy)


def by_definition(asked: Problem, line: ReadyLine) -> Problem:
    """The problem in which each place and each dock keeps what the line asks for."""
    energy = asked.energy
    assert energy is not None
    actions = [a for a in asked.actions if a is WAIT or _is_in_time(asked, a, line)]
    allowed = replace(asked, actions=tuple(actions))
    docks = [a for a in actions if a.charger is not None]
    onward = [
        _level(way, energy.floors, dock.charger.floor)
        for dock in docks
        if dock.charger is not None
        for way in _ways(allowed, line.place, dock.arguments[0])
    ]
    after = min(onward, default=energy.floors.get(line.place, 1 << 20))
    kept = {}
    for place, floor in energy.floors.items():
        ways = [
            (_took_ms(way), _level(way, energy.floors, after))
            for way in _ways(allowed, place, line.place)
        ]
        kept[place] = max(floor, min(ways)[1] if ways else 0)
    for number, action in enumerate(actions):
        if (charger := action.charger) is not None:
            own = charger.landing + charger.take_off + kept[action.arguments[0]]
            charger = replace(charger, floor=max(charger.floor, own))
            actions[number] = replace(action, charger=charger)
    return replace(asked, actions=tuple(actions), energy=replace(energy, floors=kept))


def _is_in_time(asked: Problem, action: Action, line: ReadyLine) -> bool:
    places = [fact.arguments[0] for fact in (*action.requires, *action.adds) if fact.arguments]
    end = action.arguments[-1] if action.skill == "move" else places[0]
    ways = [_took_ms(way) for way in _ways(asked, end, line.place)]
    return bool(ways) and action.cost_ms + min(ways) <= line.bound.planned_ms


def _moves(asked: Problem) -> list[Action]:
    return [action for action in asked.actions if action.skill == "move"]


def _ways(asked: Problem, start: str, end: str) -> Iterator[list[Action]]:
    """All ways that pass no place twice."""
    moves, pending = _moves(asked), [(start, list[Action](), {start})]
    while pending:
        here, way, passed = pending.pop()
        if here == end:
            yield way
            continue
        for move in moves:
            if move.arguments[0] == here and move.arguments[1] not in passed:
                goal = move.arguments[1]
                pending.append((goal, [*way, move], passed | {goal}))


def _took_ms(way: list[Action]) -> int:
    return sum(move.cost_ms for move in way)


def _level(way: list[Action], floors: Mapping[str, int], after: int) -> int:
    for move in way[::-1]:
        after = max(floors.get(move.arguments[0], 0), after + move.drain)
    return after
