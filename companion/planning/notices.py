"""Notices: what a mission says, and its author probably did not mean.

None of these is an error: an event may exist only for people to see, a line may be for later use.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from companion.ltl.formula import Operator
from companion.ltl.restriction import restricted
from companion.ltl.timed_formula import TimedFormula
from companion.mission.facts import Fact
from companion.mission.first_place import as_begun_at_zero, begins_at_zero
from companion.mission.model import Mission
from companion.mission.otherwise import LandAtSafePlace
from companion.mission.steps import Charge
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.transition_system import TransitionSystem
from companion.planning.domain import Action, ConditionalEffect, destination
from companion.planning.lasso import Conjunct, Lasso, Solution
from companion.planning.low_places import low_places, too_low
from companion.planning.planner import Planner
from companion.planning.situation import unread_events
from companion.planning.step_times import is_guessed, on_the_spot_s


@dataclass(frozen=True, slots=True)
class Notice:
    """Something for the author to look at.

    Attributes:
        subject: the event, the line of the task, or the places.
        text: what is odd about it, in words.
    """

    subject: str
    text: str

    def __str__(self) -> str:
        return f"{self.subject}: {self.text}"


def notices(planner: Planner, plan: Solution | None) -> tuple[Notice, ...]:
    """What is odd about a mission.

    >>> from companion import load_mission
    >>> planner = Planner(load_mission("missions/surveillance.yaml"))
    >>> notices(planner, planner.plan())
    ()

    Args:
        planner: the mission's planner.
        plan: plan from the first state; None for a tree written by hand.
    """
    mission = planner.mission
    found = [] if mission.tree is not None else [*_unused_events(mission)]
    if plan is not None:
        dropped = {each.line for each in plan.dropped}
        kept = [conjunct for conjunct in planner.conjuncts if conjunct.name not in dropped]
        found += [*_vacuous_lines(planner), *_met_by_rest(kept, plan.lasso)]
        found += _walls_below_the_end(mission, plan.lasso)
    found += [*_begins_elsewhere(mission), *_low_places(planner), *_cut_off_places(planner)]
    return (*found, *_guessed_costs(planner), *_nothing_to_hold_again(mission))


def not_heard(mission: Mission) -> tuple[Notice, ...]:
    """Reports that a mission needs from other programs, `EVENT[name]`; for where none are heard.

    >>> from companion import load_mission
    >>> print(*not_heard(load_mission("missions/lost_person.yaml")))
    not heard: EVENT[person]; --events says where other programs report
    """
    conditions = (each for event in mission.events.values() for each in (event.when, event.until))
    signals = {each.signal for each in conditions if each is not None}
    if reports := sorted(str(each) for each in signals if each.is_report):
        how = "--events says where other programs report"
        return (Notice("not heard", f"{', '.join(reports)}; {how}"),)
    return ()


def _begins_elsewhere(mission: Mission) -> Iterator[Notice]:
    """The place where a mission in metres begins, if it is not the origin of these metres."""
    if mission.anchor is None and not begins_at_zero(mission.home):
        off_m = math.hypot(*mission.home.position[:2])
        yield Notice(
            mission.home.name,
            f"the mission begins there, {off_m:.1f} m from [0, 0], which is the autopilot's home"
            " position, where the vehicle stands at first, and from there no flight begins; "
            + as_begun_at_zero(mission.home),
        )


def _low_places(planner: Planner) -> Iterator[Notice]:
    """Places that are too low for the accuracy of heights, in a mission that needs GPS."""
    if planner.mission.anchor is None:
        return
    if low := low_places(planner):
        yield Notice(", ".join(map(str, low)), too_low(planner.mission.vehicle))


def _cut_off_places(planner: Planner) -> Iterator[Notice]:
    """Safe places to which no clear route leads from where the mission begins."""
    mission, home = planner.mission, planner.mission.home.name
    if isinstance(mission.otherwise, LandAtSafePlace):
        for place in mission.otherwise.places:
            if place != home and math.isinf(planner.actions.flight_time(home, place)):
                yield Notice(place, f"in land_at, and no clear route leads there from {home}")


def _guessed_costs(planner: Planner) -> Iterator[Notice]:
    """Skills with an unknown duration, if the mission has time bounds."""
    mission = planner.mission
    bounded = [name for name, line in mission.task.items() if isinstance(line, TimedFormula)]
    if not bounded or mission.tree is not None:
        return
    steps = {action.skill: action.execute for action in planner.actions.every()}
    for skill in mission.skills.values():
        done = steps.get(skill.name, ())
        if skill.cost_s is None and skill.charge_rate is None and is_guessed(done):
            known = "its flight and waits" if destination(done) else f"{on_the_spot_s(done):g} s"
            yield Notice(
                skill.name,
                f"without cost, so plans assume {known} for it, and the bounds in time of"
                f" {', '.join(bounded)} hold only if it is done by then; write its time",
            )


def _nothing_to_hold_again(mission: Mission) -> Iterator[Notice]:
    """Skills with a time after which beliefs are held again, whose failure withdraws none."""
    for skill in mission.skills.values():
        charges = any(isinstance(step, Charge) for step in skill.execute)
        if skill.retry_after_s is not None and not skill.assumes and not charges:
            yield Notice(
                skill.name, "retry_after_s has no effect: the skill assumes nothing (assumes)"
            )


def _walls_below_the_end(mission: Mission, plan: Lasso) -> Iterator[Notice]:
    """The place where the plan lands, if a low wall stands below it."""
    if plan.ends_at_rest:
        flown_to = [action.destination for action in plan.prefix if action.destination]
        place = mission.places[flown_to[-1] if flown_to else mission.home.name]
        clearance_m = mission.vehicle.clearance_m
        _, highest_m = mission.grid.ground_m(place.position[:2], clearance_m)
        if highest_m > 0:
            yield Notice(
                place.name, f"the plan ends there, and lands above a wall of {highest_m:g} m"
            )


def _unused_events(mission: Mission) -> Iterator[Notice]:
    """Events that neither the task nor a skill mentions, and that restart no line."""
    unread = unread_events(mission)
    for name, event in mission.events.items():
        if event.fact in unread and not event.restores:
            yield Notice(name, "nothing uses this event: no line of the task, no skill")


def _vacuous_lines(planner: Planner) -> Iterator[Notice]:
    """Conjuncts that hold from the start, whatever the vehicle does and whatever happens."""
    model, mission = planner.actions.model, planner.mission
    open_facts = model.beliefs | {event.fact for event in mission.events.values()}
    actions = [_at_some_time(action, open_facts) for action in model.actions]
    system = TransitionSystem(actions, mission.initially, KnownActions())
    again = frozenset().union(*(event.restarts for event in mission.events.values()))
    read = planner.initial_problem()[0].automaton_states
    for conjunct, states in zip(planner.conjuncts, read, strict=True):
        automaton = conjunct.automaton
        constants = {
            name: value
            for name in automaton.propositions
            if name not in open_facts and (value := system.constant_value(name)) is not None
        }
        rest = restricted(automaton, constants)
        at_first = rest.states(automaton.initial if conjunct.name in again else states)
        if rest.everything.intersection(at_first):
            never = sorted(name for name, holds in constants.items() if not holds)
            why = f", for {', '.join(never)} never holds" if never else ""
            text = f"{conjunct.text} holds from the start on, whatever is done{why}"
            yield Notice(conjunct.name, text)


def _at_some_time(action: Action, open_facts: frozenset[Fact]) -> Action:
    """The action as it is if all facts that no skill decides are as it needs them."""
    return replace(
        action,
        requires=action.requires - open_facts,
        forbids=action.forbids - open_facts,
        conditional=tuple(
            ConditionalEffect(e.requires - open_facts, e.forbids - open_facts, e.adds, e.deletes)
            for e in action.conditional
        ),
    )


def _met_by_rest(conjuncts: Sequence[Conjunct], plan: Lasso) -> Iterator[Notice]:
    """Goals that have to recur for ever, although the plan lands and stays."""
    if not plan.ends_at_rest:
        return
    for conjunct in conjuncts:
        formula = conjunct.formula
        again = formula.operator is Operator.ALWAYS and (
            formula.operands[0].operator is Operator.EVENTUALLY
        )
        if again:
            how = "is met by resting for ever: the vehicle lands, and the flight ends"
            yield Notice(conjunct.name, f"{conjunct.text} {how}")
