"""The task model: skills grounded to STRIPS actions over facts, with beliefs and costs.

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
from dataclasses import dataclass

from companion.mission.model import Atom, Execution, Fly, Literal, Mission, Skill, Wait

Fact = str
"""A ground atom in the formula language's spelling, e.g. "at(A)"."""

FlightTime = Callable[[str, str], float]
"""Seconds of flight from one place to another; inf where no route exists."""

HERE = "here"
REST_S = 1.0
"""Length of one step of rest."""
UNIT_MS = 100
"""Costs are multiples of this. Rest costs one and all else more, whatever a mission says, so that
no skill is repeated for ever in place of rest."""


@dataclass(frozen=True, slots=True)
class ConditionalEffect:
    """What an action does besides, if a condition holds before it."""

    requires: frozenset[Fact]
    forbids: frozenset[Fact]
    adds: frozenset[Fact]
    deletes: frozenset[Fact]

    def is_met(self, facts: frozenset[Fact]) -> bool:
        """Whether the condition holds."""
        return self.requires <= facts and not self.forbids & facts


@dataclass(frozen=True, slots=True)
class Action:
    """A grounded skill.

    Attributes:
        name: e.g. "move(A, B)".
        requires: facts that must hold, beliefs included.
        forbids: facts that must not hold.
        assumes: the beliefs among `requires`; withdrawn when the action fails.
        cost_ms: milliseconds.
        execute: what the vehicle does, with the place or numbers filled in.
        conditional: effects that depend on the facts before the action.
    """

    name: str
    skill: str
    requires: frozenset[Fact]
    forbids: frozenset[Fact]
    assumes: frozenset[Fact]
    adds: frozenset[Fact]
    deletes: frozenset[Fact]
    cost_ms: int
    execute: Execution
    tries: int
    timeout_s: float | None
    conditional: tuple[ConditionalEffect, ...] = ()

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
    name="wait",
    skill="wait",
    requires=frozenset(),
    forbids=frozenset(),
    assumes=frozenset(),
    adds=frozenset(),
    deletes=frozenset(),
    cost_ms=UNIT_MS,
    execute=Wait(REST_S),
    tries=1,
    timeout_s=None,
)


@dataclass(frozen=True)
class TaskModel:
    """The mission's transition system, determinised: events keep their value, beliefs hold.

    Attributes:
        actions: grounded actions, in the order of the mission file, `wait` last.
        beliefs: all facts that some action assumes.
    """

    actions: tuple[Action, ...]
    beliefs: frozenset[Fact]


def ground(mission: Mission, flight_time: FlightTime) -> TaskModel:
    """The task model of a mission. A move whose flight time is infinite does not exist."""
    actions = [
        action
        for skill in mission.skills.values()
        for binding in _bindings(mission, skill)
        if (action := _instance(skill, binding, flight_time)) is not None
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
        if isinstance(skill.execute, Fly)
        for binding in _bindings(mission, skill, origin=HERE)
        if (action := _instance(skill, binding, flight_time)) is not None
    )


def origin_parameter(skill: Skill) -> str | None:
    """The parameter that names where a flying skill starts: p with precondition at(p)."""
    names = [name for name, _ in skill.parameters]
    for literal in skill.precondition:
        atom = literal.atom
        if literal.is_positive and atom.name == "at" and atom.arguments[0] in names:
            return atom.arguments[0]
    return None


def _bindings(
    mission: Mission, skill: Skill, origin: str | None = None
) -> Iterator[dict[str, str]]:
    """All bindings of a skill's parameters; `origin` fixes the place where it starts."""
    start = origin_parameter(skill) if origin else None
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


def _instance(skill: Skill, binding: dict[str, str], flight_time: FlightTime) -> Action | None:
    execute: Execution = skill.execute
    cost_s = skill.cost_s
    if isinstance(execute, Fly):
        goal = binding.get(execute.place, execute.place)
        origin = origin_parameter(skill)
        if origin is not None and binding[origin] == goal:
            return None  # a flight to where one is; resting is `wait`
        if cost_s is None:
            cost_s = flight_time(binding[origin], goal) if origin else 0.0
        if math.isinf(cost_s):
            return None
        execute = Fly(goal)
    requires, forbids = _facts(skill.precondition, binding)
    adds, deletes = _facts(skill.effect, binding)
    assumes = frozenset(atom.ground(binding) for atom in skill.assumes)
    if requires & forbids:
        return None
    return Action(
        name=Atom(skill.name, tuple(name for name, _ in skill.parameters)).ground(binding),
        skill=skill.name,
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
    )


def _facts(
    literals: tuple[Literal, ...], binding: dict[str, str]
) -> tuple[frozenset[Fact], frozenset[Fact]]:
    """The facts of the positive and of the negative literals."""
    return (
        frozenset(x.atom.ground(binding) for x in literals if x.is_positive),
        frozenset(x.atom.ground(binding) for x in literals if not x.is_positive),
    )
