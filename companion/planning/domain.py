"""The task model: skills instantiated to STRIPS actions over facts, with beliefs and costs.

Skills become actions by binding their parameters to the members of their sets (the paper's
action templates, Section II-E). What a skill `assumes` is a further precondition that is taken
for true until the skill fails (Section IV-C). Two things are added that the mission file does
not write down:

- `wait`, one step of rest, is an ordinary action. The paper's actNop, allowed once and only
  at the end of a plan, cannot express a task whose loop is rest.
- `here`, the place between places. A move that was interrupted leaves the vehicle at no place,
  and then moves from `here` to every place exist, with the cost from where it is.

Costs are whole milliseconds of flight, rounded to tenths of a second, so that both ways round
the same lap cost the same and ties fall to the order of the mission file.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from companion.mission.facts import ANYWHERE, HERE, Atom, Fact, spelled
from companion.mission.model import (
    Do,
    Fly,
    Literal,
    Mission,
    PointOfInterest,
    Primitive,
    Skill,
    Wait,
    flies,
)

FlightTime = Callable[[str, str], float]
"""Seconds of flight from one place to another; inf where no route exists."""

REST_S = 1.0
"""Length of one step of rest."""
UNIT_MS = 100
"""Costs are multiples of this. Rest costs one and all else more, whatever a mission says, so that
no skill is repeated for ever in place of rest."""


P = TypeVar("P", bound=str, covariant=True)
"""The propositions of an effect: facts, or the fluents of a classical problem."""


@dataclass(frozen=True, slots=True)
class ConditionalEffect(Generic[P]):
    """What an action does besides, if a condition holds before it."""

    requires: frozenset[P]
    forbids: frozenset[P]
    adds: frozenset[P]
    deletes: frozenset[P]

    def is_met(self, facts: frozenset[str]) -> bool:
        """Whether the condition holds."""
        return self.requires <= facts and not self.forbids & facts


@dataclass(frozen=True, slots=True)
class Refinement:
    """What a skill that refines another one does, how often it is tried, and how long each time.

    Attributes:
        look_at: what the vehicle looks at meanwhile; None for what the skill that it refines says.
    """

    name: str
    steps: tuple[Step, ...]
    tries: int
    timeout_s: float | None
    look_at: PointOfInterest | None = None


Step = Primitive | Refinement


@dataclass(frozen=True, slots=True)
class Action:
    """An instance of a skill: all its parameters are bound.

    Attributes:
        name: skill and arguments, e.g. "move(A, B)".
        skill: its name.
        arguments: what its parameters are bound to.
        requires: facts that must hold, beliefs included.
        forbids: facts that must not hold.
        assumes: the beliefs among `requires`; withdrawn when the action fails.
        cost_ms: milliseconds.
        execute: what the vehicle does, one step after the other, with places filled in.
        conditional: effects that depend on the facts before the action.
        retry_after_s: time after which what it assumes is believed again; None is never.
        look_at: what the vehicle looks at meanwhile; None for nothing of its own.
    """

    skill: str
    arguments: tuple[str, ...]
    requires: frozenset[Fact]
    forbids: frozenset[Fact]
    assumes: frozenset[Fact]
    adds: frozenset[Fact]
    deletes: frozenset[Fact]
    cost_ms: int
    execute: tuple[Step, ...]
    tries: int
    timeout_s: float | None
    conditional: tuple[ConditionalEffect[Fact], ...] = ()
    retry_after_s: float | None = None
    look_at: PointOfInterest | None = None
    name: str = field(init=False, compare=False)

    def __post_init__(self) -> None:
        """Spells the name once: plans are compared by names, a thousand at a time, in flight."""
        object.__setattr__(self, "name", spelled(self.skill, self.arguments))

    @property
    def destination(self) -> str | None:
        """The place that it flies to last; None if it flies nowhere."""
        return _destination(self.execute)

    def is_applicable(self, facts: frozenset[Fact]) -> bool:
        """Whether the precondition holds."""
        return self.requires <= facts and not self.forbids & facts

    def apply(self, facts: frozenset[Fact]) -> frozenset[Fact]:
        """The facts afterwards; what is both added and deleted is added."""
        adds, deletes = self.adds, self.deletes
        for effect in self.conditional:
            if effect.is_met(facts):
                adds, deletes = adds | effect.adds, deletes | effect.deletes
        return (facts - deletes) | adds


WAIT = Action(
    skill="wait",
    arguments=(),
    requires=frozenset(),
    forbids=frozenset(),
    assumes=frozenset(),
    adds=frozenset(),
    deletes=frozenset(),
    cost_ms=UNIT_MS,
    execute=(Wait(REST_S),),
    tries=1,
    timeout_s=None,
)


@dataclass(frozen=True)
class TaskModel:
    """The mission's transition system, determinised: events keep their value, beliefs hold.

    Attributes:
        actions: instances of the skills, in the order of the mission file, `wait` last.
        beliefs: all facts that some action assumes.
    """

    actions: tuple[Action, ...]
    beliefs: frozenset[Fact]


def instantiate(mission: Mission, flight_time: FlightTime) -> TaskModel:
    """The task model of a mission. A move whose flight time is infinite does not exist."""
    actions = [
        action
        for skill in mission.skills.values()
        if skill.is_planned
        for binding in _bindings(mission, skill)
        if (action := _instance(mission, skill, binding, flight_time)) is not None
    ]
    beliefs = frozenset().union(*(a.assumes for a in actions))
    return TaskModel((*actions, WAIT), beliefs)


def departures(mission: Mission, flight_time: FlightTime) -> tuple[Action, ...]:
    """The moves from `here`: one per flying skill and place.

    Args:
        mission: the mission.
        flight_time: called with `here` as the first place.
    """
    return tuple(
        action
        for skill in mission.skills.values()
        if skill.is_planned and flies(skill, mission.skills)
        for binding in _bindings(mission, skill, origin=HERE)
        if (action := _instance(mission, skill, binding, flight_time)) is not None
    )


def is_named(action: Action, name: str) -> bool:
    """Whether a name is that of an action, or has `*` in place of arguments of it.

    >>> is_named(WAIT, "wait"), is_named(WAIT, "rest")
    (True, False)
    """
    if ANYWHERE not in name:
        return action.name == name
    atom = Atom.parse(name)
    return (action.skill, len(action.arguments)) == (atom.predicate, len(atom.arguments)) and all(
        written in (ANYWHERE, bound)
        for written, bound in zip(atom.arguments, action.arguments, strict=True)
    )


def _bindings(
    mission: Mission, skill: Skill, origin: str | None = None
) -> Iterator[dict[str, str]]:
    """All bindings of a skill's parameters; `origin` fixes the place where it starts."""
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
    """What a skill and those that refine it assume."""
    assumed = {atom.instantiate(binding) for atom in skill.assumes}
    for step in skill.execute:
        if isinstance(step, Do):
            inner = mission.skills[step.skill]
            assumed |= _beliefs(mission, inner, _own(inner, step, binding))
    return frozenset(assumed)


def _own(inner: Skill, call: Do, binding: dict[str, str]) -> dict[str, str]:
    """The binding of a skill that is called under a binding of the caller's."""
    names = (name for name, _ in inner.parameters)
    return dict(zip(names, (binding.get(w, w) for w in call.arguments), strict=True))


def _refined(mission: Mission, skill: Skill, binding: dict[str, str]) -> tuple[Step, ...]:
    """The steps of a skill under a binding, down to primitives."""
    steps: list[Step] = []
    for step in skill.execute:
        if isinstance(step, Fly):
            steps.append(Fly(binding.get(step.place, step.place)))
        elif isinstance(step, Do):
            inner = mission.skills[step.skill]
            own = _own(inner, step, binding)
            name = spelled(inner.name, tuple(own.values()))
            below = _refined(mission, inner, own)
            look_at = _look_at(mission, inner, own)
            steps.append(Refinement(name, below, inner.tries, inner.timeout_s, look_at))
        else:
            steps.append(step)
    return tuple(steps)


def _look_at(mission: Mission, skill: Skill, binding: dict[str, str]) -> PointOfInterest | None:
    if not isinstance(skill.look_at, str):
        return skill.look_at
    return mission.places[binding[skill.look_at]].point


def _destination(steps: tuple[Step, ...]) -> str | None:
    for step in reversed(steps):
        if isinstance(step, Fly):
            return step.place
        if isinstance(step, Refinement) and (place := _destination(step.steps)) is not None:
            return place
    return None


def _instance(
    mission: Mission, skill: Skill, binding: dict[str, str], flight_time: FlightTime
) -> Action | None:
    execute = _refined(mission, skill, binding)
    goal, cost_s = _destination(execute), skill.cost_s
    if goal is not None:
        origin = skill.origin
        if origin is not None and binding[origin] == goal:
            return None  # a flight to where one is; resting is `wait`
        if cost_s is None:
            cost_s = flight_time(binding[origin], goal) if origin else 0.0
        if math.isinf(cost_s):
            return None
    requires, forbids = _facts(skill.precondition, binding)
    adds, deletes = _facts(skill.effect, binding)
    assumes = _beliefs(mission, skill, binding)
    if requires & forbids:
        return None
    return Action(
        skill=skill.name,
        arguments=tuple(binding.values()),
        requires=requires | assumes,
        forbids=forbids,
        assumes=assumes,
        adds=adds,
        deletes=deletes - adds,
        cost_ms=UNIT_MS * max(2, round(1000 * (cost_s or 0.0) / UNIT_MS)),
        execute=execute,
        tries=skill.tries,
        timeout_s=skill.timeout_s,
        conditional=tuple(
            ConditionalEffect(*_facts(when.condition, binding), *_facts(when.effect, binding))
            for when in skill.conditional
        ),
        retry_after_s=skill.retry_after_s,
        look_at=_look_at(mission, skill, binding),
    )


def _facts(
    literals: tuple[Literal, ...], binding: dict[str, str]
) -> tuple[frozenset[Fact], frozenset[Fact]]:
    """The facts of the positive and of the negative literals."""
    return (
        frozenset(x.atom.instantiate(binding) for x in literals if x.is_positive),
        frozenset(x.atom.instantiate(binding) for x in literals if not x.is_positive),
    )
