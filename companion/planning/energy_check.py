"""The independent check of a plan's energy: it executes the plan on levels, without any search."""

from __future__ import annotations

from companion.mission.facts import AT, Fact
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Energy, Lasso, Problem


def energy_fault(problem: Problem, lasso: Lasso) -> str | None:
    """What is wrong with the energy of a plan, in words; None if it lasts for ever.

    A plan is right if three things hold:
    1. Before each action the level covers the reserve, the energy to land at a safe place, and what
       ready lines keep.
    2. Some lap ends with at least the level with which it began.
    3. Where the plan rests, the vehicle can land.

    Args:
        problem: the problem that the plan solves, with energy.
        lasso: the plan.
    """
    energy = problem.energy
    assert energy is not None
    level, facts = energy.level, problem.facts
    for action in lasso.prefix:
        if wrong := _missing(energy, level, facts, action, in_loop=False):
            return wrong
        level, facts = level_after(energy, level, action), action.apply(facts)
    if lasso.ends_at_rest:
        needed = energy.rests.get(place_of(facts))
        is_enough = needed is not None and level >= needed
        return None if is_enough else f"landing at {place_of(facts)} would take the reserve"
    begun = level + 1
    while level < begun:  # the first laps use up surplus, until each lap is like the one before
        begun = level
        for action in lasso.loop:
            if wrong := _missing(energy, level, facts, action, in_loop=True):
                return wrong
            level, facts = level_after(energy, level, action), action.apply(facts)
    return None


def required_levels(energy: Energy, facts: frozenset[Fact], lasso: Lasso) -> tuple[int, ...]:
    """The level needed before each action of a plan, prefix and loop, so that it can go on.

    Args:
        energy: the energy of the problem that the plan solves.
        facts: the facts at the beginning of the plan.
        lasso: the plan.
    """
    actions = (*lasso.prefix, *lasso.loop)
    places = []
    for action in actions:
        places.append(place_of(facts))
        facts = action.apply(facts)
    if lasso.ends_at_rest:
        after = energy.rests.get(place_of(facts), 0)
        kept = len(lasso.prefix)
        levels = [after] * len(lasso.loop)
    else:
        kept, after, levels = len(actions), 0, []
        for action in lasso.loop[::-1]:  # starts with what the next lap needs at its beginning
            after = _before(energy, action, after, 0)
    for action, place in zip(actions[:kept][::-1], places[:kept][::-1], strict=True):
        in_loop = len(levels) < len(lasso.loop)
        after = _before(energy, action, after, energy.floor(place, in_loop) or 0)
        levels.append(after)
    rest = len(lasso.loop) if lasso.ends_at_rest else 0
    return (*levels[rest:][::-1], *levels[:rest])


def of_reserve(energy: Energy, facts: frozenset[Fact], lasso: Lasso) -> int:
    """How much of the reserve a plan uses, in units; arguments as of `required_levels`."""
    return max(0, required_levels(energy, facts, lasso)[0] - energy.level)


def _before(energy: Energy, action: Action, after: int, floor: int) -> int:
    if action.charger is not None:
        return max(floor, action.charger.floor)
    return max(floor, after + (energy.rest if action is WAIT else action.drain))


def _missing(
    energy: Energy, level: int, facts: frozenset[Fact], action: Action, in_loop: bool
) -> str | None:
    """What is missing before an action, in words; None if nothing is."""
    place = place_of(facts)
    floor, needed = energy.floors.get(place), energy.floor(place, in_loop)
    if floor is None or needed is None:
        return f"from {place or 'nowhere'} no safe place can be reached"
    if level < floor:
        return f"at {place} {_wh(floor - level)} are missing to land at a safe place"
    if level < needed:
        return f"at {place} {_wh(needed - level)} are missing to be ready"
    if action.charger is None:
        return None
    if action.charge_to is None or action.charge_to > action.charger.highest:
        return f"{action.name} does not say how far it charges, or too far"
    if level < action.charger.floor:
        return f"{_wh(action.charger.floor - level)} are missing to land for {action.name}"
    return None


def level_after(energy: Energy, level: int, action: Action) -> int:
    """The level after an action."""
    if action.charge_to is not None and action.charger is not None:
        least = level - action.charger.landing - action.charger.take_off
        return max(action.charge_to, least)
    return level - (energy.rest if action is WAIT else action.drain)


def place_of(facts: frozenset[Fact]) -> str:
    """The place of the vehicle; "" if it is at none."""
    return next((fact.arguments[0] for fact in facts if fact.predicate == AT), "")


def _wh(units: int) -> str:
    return f"{units / UNITS_PER_WH:.2f} Wh"
