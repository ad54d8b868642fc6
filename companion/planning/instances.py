"""The instances of a mission's skills, and which of them exist given the flight times.

Skills become actions by binding their parameters to the members of their sets (the paper's action
templates, Section II-E). A belief that a skill `assumes` is a further precondition, held to be true
until the skill fails (Section IV-C). Two things are added that the mission file does not contain:

- `wait`, one step of rest, is an ordinary action. The paper's actNop, allowed only once at the end
  of a plan, cannot express a task whose loop is rest.
- `here` is the pseudo-place between places. An interrupted move leaves the vehicle at no place.
  Then moves exist from `here` to every place, with the cost from the vehicle's position.

Costs are whole milliseconds of flight, rounded to tenths of a second. So both directions around the
same lap cost the same, and ties are decided by the order of the mission file.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

from companion.mission.facts import HERE, Fact, spelled
from companion.mission.model import Mission
from companion.mission.places import PointOfInterest
from companion.mission.python_call import PythonCall
from companion.mission.refinement import flies
from companion.mission.skills import Literal, Skill
from companion.mission.steps import Do, Fly, LandOn
from companion.planning.domain import (
    UNIT_MS,
    WAIT,
    Action,
    ConditionalEffect,
    Refinement,
    Step,
    destination,
)
from companion.planning.step_times import on_the_spot_s, waits_s
from companion.slices import spent

FlightTime = Callable[[str, str], float]
"""Seconds of flight from one place to another; inf where no route exists."""


class Drains(Protocol):
    """How much energy actions take from the battery."""

    def of(
        self, skill: Skill, action: Action, flight: tuple[str, str] | None, place: str | None
    ) -> Action:
        """The action with the energy that it takes.

        Args:
            skill: the skill of which it is an instance.
            action: the action, with its cost.
            flight: the flight that the action contains.
            place: where the action is done.
        """


_BINDING_US = 30
_COSTING_US = 2
_BELIEVING_US = 1


@dataclass(frozen=True)
class TaskModel:
    """The mission's transition system, made deterministic: events keep their value, beliefs hold.

    Attributes:
        actions: instances of the skills, in the order of the mission file, `wait` last.
        beliefs: all facts that some action assumes.
    """

    actions: tuple[Action, ...]
    beliefs: frozenset[Fact]


@dataclass(slots=True)
class _Instance:
    """An action, with the flight that it contains.

    Attributes:
        flight: None for an action that does not fly.
        place: where it is done; None for anywhere.
    """

    skill: Skill
    action: Action
    flight: tuple[str, str] | None
    place: str | None


class Instances:
    """All instances of some skills of a mission; without a route an instance is not an action.

    In flight, flight times change with the map and the speed limit; everything else is made once.

    Args:
        mission: the mission with the skills.
        origin: `here` for the moves from there only, one for each flying skill and place; None for
            all instances of all skills.
        drains: the energy that they take; None if plans do not consider energy.
    """

    def __init__(
        self, mission: Mission, origin: str | None = None, drains: Drains | None = None
    ) -> None:
        self._instances = list(_instances(mission, origin))
        self._drains = drains

    def actions(self, flight_time: FlightTime) -> tuple[Action, ...]:
        """The actions in the order of the mission file; an action with an unchanged cost stays the
        same object.
        """
        found = []
        for instance in self._instances:
            if instance.flight is not None:
                cost_s = flight_time(*instance.flight) + waits_s(instance.action.execute)
                spent(_COSTING_US)
                if math.isinf(cost_s):
                    continue
                if (cost_ms := _cost_ms(cost_s)) != instance.action.cost_ms:
                    instance.action = replace(instance.action, cost_ms=cost_ms)
            action = instance.action
            if self._drains is not None:
                action = self._drains.of(instance.skill, action, instance.flight, instance.place)
            found.append(action)
        return tuple(found)

    @cached_property
    def beliefs(self) -> frozenset[Fact]:
        """All facts that some instance assumes."""
        return frozenset[Fact]().union(*(each.action.assumes for each in self._instances))


def instantiate(
    mission: Mission, flight_time: FlightTime, drains: Drains | None = None
) -> TaskModel:
    """The task model of a mission. A move with an infinite flight time is left out."""
    return task_model(Instances(mission, drains=drains), flight_time)


def task_model(instances: Instances, flight_time: FlightTime) -> TaskModel:
    """The task model with the present flight times."""
    actions = instances.actions(flight_time)
    spent(_BELIEVING_US * len(actions))
    beliefs = frozenset[Fact]().union(*(action.assumes for action in actions))
    return TaskModel((*actions, WAIT), beliefs)


def departures(mission: Mission, flight_time: FlightTime) -> tuple[Action, ...]:
    """The moves from `here`: one for each flying skill and place.

    Args:
        mission: the mission.
        flight_time: called with `here` as the first place.
    """
    return Instances(mission, HERE).actions(flight_time)


def _instances(mission: Mission, origin: str | None) -> Iterator[_Instance]:
    for skill in mission.skills.values():
        if skill.is_planned and (origin is None or flies(skill, mission.skills)):
            for binding in _bindings(mission, skill, origin):
                spent(_BINDING_US)
                instance = _instance(mission, skill, binding)
                if instance is not None:
                    yield instance


def _bindings(
    mission: Mission, skill: Skill, origin: str | None = None
) -> Iterator[dict[str, str]]:
    """All bindings of a skill's parameters; `origin` fixes the place where the skill starts."""
    start = skill.origin if origin else None
    if origin and start is None:
        return
    names = [name for name, _ in skill.parameters]
    domains = [
        (origin,) if origin and name == start else mission.sets[set_name]
        for name, set_name in skill.parameters
    ]
    for values in itertools.product(*domains):
        binding = dict(zip(names, values, strict=True))
        if all(len({binding.get(p, p) for p in g}) == len(g) for g in skill.distinct):
            yield binding


def _beliefs(mission: Mission, skill: Skill, binding: dict[str, str]) -> frozenset[Fact]:
    """The beliefs that a skill and those that refine it assume."""
    assumed = {atom.instantiate(binding) for atom in skill.assumes}
    for step in skill.execute:
        if isinstance(step, Do):
            inner = mission.skills[step.skill]
            assumed |= _beliefs(mission, inner, _own(inner, step, binding))
    return frozenset(assumed)


def _own(inner: Skill, call: Do, binding: dict[str, str]) -> dict[str, str]:
    """The binding of a called skill under the caller's binding."""
    names = (name for name, _ in inner.parameters)
    return dict(zip(names, (binding.get(w, w) for w in call.arguments), strict=True))


def _refined(mission: Mission, skill: Skill, binding: dict[str, str]) -> tuple[Step, ...]:
    """The steps of a skill under a binding, resolved down to primitives."""
    steps: list[Step] = []
    for step in skill.execute:
        if isinstance(step, Fly | LandOn):
            steps.append(type(step)(binding.get(step.place, step.place)))
        elif isinstance(step, PythonCall):
            steps.append(step.bound(binding))
        elif isinstance(step, Do):
            inner = mission.skills[step.skill]
            own = _own(inner, step, binding)
            name = spelled(inner.name, tuple(own.values()))
            below = _refined(mission, inner, own)
            refinement = Refinement(
                name,
                below,
                tries=inner.tries,
                timeout_s=inner.timeout_s,
                look_at=_look_at(mission, inner, own),
                confirmed_by=inner.confirmed_by,
            )
            steps.append(refinement)
        else:
            steps.append(step)
    return tuple(steps)


def _look_at(mission: Mission, skill: Skill, binding: dict[str, str]) -> PointOfInterest | None:
    point = skill.look_at
    if isinstance(point, str):
        point = mission.places[binding[point]].point
    return point and replace(point, gimbal=skill.gimbal)


def _instance(mission: Mission, skill: Skill, binding: dict[str, str]) -> _Instance | None:
    execute = _refined(mission, skill, binding)
    goal, origin, flight, departure = destination(execute), skill.origin, None, None
    if goal is not None and origin is not None:
        if binding[origin] == goal:
            return None  # a flight to the present place; resting is `wait`
        departure = [*binding].index(origin)
        if skill.cost_s is None:
            flight = binding[origin], goal
    requires, forbids = _facts(skill.precondition, binding)
    adds, deletes = _facts(skill.effect, binding)
    assumes = _beliefs(mission, skill, binding)
    if requires & forbids:
        return None
    action = Action(
        skill=skill.name,
        arguments=tuple(binding.values()),
        requires=requires | assumes,
        forbids=forbids,
        assumes=assumes,
        adds=adds,
        deletes=deletes - adds,
        cost_ms=_cost_ms(on_the_spot_s(execute) if skill.cost_s is None else skill.cost_s),
        execute=execute,
        tries=skill.tries,
        timeout_s=skill.timeout_s,
        conditional=tuple(
            ConditionalEffect(*_facts(when.condition, binding), *_facts(when.effect, binding))
            for when in skill.conditional
        ),
        retry_after_s=skill.retry_after_s,
        look_at=_look_at(mission, skill, binding),
        is_repeatable=skill.is_repeatable,
        confirmed_by=skill.confirmed_by,
        departure=departure,
    )
    place = goal or (binding[origin] if origin is not None else None)
    return _Instance(skill, action, flight, place)


def _cost_ms(cost_s: float) -> int:
    return UNIT_MS * max(2, round(1000 * cost_s / UNIT_MS))


def _facts(
    literals: tuple[Literal, ...], binding: dict[str, str]
) -> tuple[frozenset[Fact], frozenset[Fact]]:
    """The facts of the positive and of the negative literals."""
    return (
        frozenset(x.atom.instantiate(binding) for x in literals if x.is_positive),
        frozenset(x.atom.instantiate(binding) for x in literals if not x.is_positive),
    )
