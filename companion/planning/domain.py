"""Actions: what the vehicle can do, as STRIPS operators over facts, with beliefs and costs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

from companion.mission.facts import ANYWHERE, AT, HERE, Atom, Fact, at, spelled
from companion.mission.places import PointOfInterest
from companion.mission.signals import Condition
from companion.mission.steps import Fly, Primitive, Wait
from companion.planning.charger import Charger

REST_S = 1.0
"""Duration of one step of rest."""
UNIT_MS = 100
"""Costs are multiples of this. Rest costs one unit and every other action more, whatever a mission
says. So no plan repeats a skill for ever where it could rest."""


P = TypeVar("P", bound=str, covariant=True)
"""The type of propositions of an effect: facts, or the fluents of a classical problem."""


@dataclass(frozen=True, slots=True)
class ConditionalEffect(Generic[P]):
    """What an action does in addition, if a condition holds before it."""

    requires: frozenset[P]
    forbids: frozenset[P]
    adds: frozenset[P]
    deletes: frozenset[P]

    def is_met(self, facts: frozenset[str]) -> bool:
        """Whether the condition holds."""
        return self.requires <= facts and not self.forbids & facts


@dataclass(frozen=True, slots=True)
class Refinement:
    """How a skill that refines another one is executed: its steps, tries and time limit.

    Attributes:
        look_at: what the vehicle looks at meanwhile; None for what the refined skill says.
        confirmed_by: what has to be heard after the last step.
        enough_percent: charge from which on the skill is skipped in the air; None for never.
    """

    name: str
    steps: tuple[Step, ...]
    tries: int
    timeout_s: float | None
    look_at: PointOfInterest | None = None
    confirmed_by: Condition | None = None
    enough_percent: int | None = None


Step = Primitive | Refinement


@dataclass(frozen=True, slots=True)
class Action:
    """An instance of a skill: all its parameters are bound.

    Attributes:
        name: skill and arguments, e.g. "move(A, B)".
        skill: name of the skill.
        arguments: the values of the skill's parameters.
        requires: facts that must hold, beliefs included.
        forbids: facts that must not hold.
        assumes: the beliefs among `requires`; they are withdrawn when the action fails.
        cost_ms: cost in milliseconds.
        execute: the steps of the vehicle, in order, with places filled in.
        conditional: effects that depend on the facts before the action.
        retry_after_s: time after which its withdrawn beliefs are held again; None for never.
        look_at: what the vehicle looks at meanwhile; None if the action does not say.
        is_repeatable: whether its commands may be sent again if it is unknown whether they were
            done.
        confirmed_by: what has to be heard after the last step; None for nothing.
        drain: energy that it takes, in units; 0 if the plan does not consider energy.
        charger: the dock where it charges to the level that the plan says; None if it does not.
            With a charger, `cost_ms` is the cost of landing and taking off, and `drain` is ignored.
        charge_to: the level after charging, in units; None if it does not charge or it is unknown.
        departure: which of the arguments is the place from which it flies; None if none is.
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
    is_repeatable: bool = False
    confirmed_by: Condition | None = None
    drain: int = 0
    charger: Charger | None = None
    charge_to: int | None = None
    departure: int | None = None
    name: str = field(init=False, compare=False)

    def __post_init__(self) -> None:
        """Builds the name once, because plans are compared by names a thousand times in flight."""
        object.__setattr__(self, "name", spelled(self.skill, self.arguments))

    @property
    def from_anywhere(self) -> str:
        """The name with `*` for the place from which it flies: the same for each such place.

        An action that is interrupted in flight goes on as one that begins at `here`.

        >>> reach("North").name, reach("North").from_anywhere
        ('reach(here, North)', 'reach(*, North)')
        """
        arguments = [*self.arguments]
        if self.departure is not None:
            arguments[self.departure] = ANYWHERE
        return spelled(self.skill, tuple(arguments))

    @property
    def destination(self) -> str | None:
        """The last place that the action flies to; None if it flies nowhere."""
        return destination(self.execute)

    def is_applicable(self, facts: frozenset[Fact]) -> bool:
        """Whether the precondition holds."""
        return self.requires <= facts and not self.forbids & facts

    def apply(self, facts: frozenset[Fact]) -> frozenset[Fact]:
        """The facts afterwards; a fact that is both added and deleted is added."""
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


def duration_ms(action: Action) -> int:
    """What an action takes: its cost, except for rest, which takes longer than it costs.

    >>> duration_ms(WAIT)
    1000
    """
    return round(1000 * REST_S) if action is WAIT else action.cost_ms


TRIES = 3
"""Number of waypoints of a place that are tried (MAX_TRY, Fig. 6)."""


def reach(place: str) -> Action:
    """The flight from `here` to a place to which no skill of the mission flies.

    >>> reach("North").name
    'reach(here, North)'
    """
    return Action(
        skill="reach",
        arguments=(HERE, place),
        requires=frozenset(),
        forbids=frozenset(),
        assumes=frozenset(),
        adds=frozenset({at(place)}),
        deletes=frozenset({at(HERE)}),
        cost_ms=2 * UNIT_MS,
        execute=(Fly(place),),
        tries=TRIES,
        timeout_s=None,
        departure=0,
    )


def is_named(action: Action, name: str) -> bool:
    """Whether an action has this name, in which `*` may stand for arguments.

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


def ends_of(action: Action) -> tuple[str | None, str | None]:
    """The places where an action begins and ends; None for any place.

    >>> ends_of(reach("North"))
    (None, 'North')
    """
    begin = next((f.arguments[0] for f in action.requires if f.predicate == AT), None)
    return begin, next((f.arguments[0] for f in action.adds if f.predicate == AT), begin)


def destination(steps: tuple[Step, ...]) -> str | None:
    """The last place that some steps fly to; None if they fly nowhere."""
    for step in reversed(steps):
        if isinstance(step, Fly):
            return step.place
        if isinstance(step, Refinement) and (place := destination(step.steps)) is not None:
            return place
    return None


def is_one_flight(steps: tuple[Step, ...]) -> bool:
    """Whether they are a flight to a place and nothing else.

    >>> is_one_flight(reach("North").execute), is_one_flight(WAIT.execute)
    (True, False)
    """
    match steps:
        case (Fly(),):
            return True
        case (Refinement(steps=refined),):
            return is_one_flight(refined)
    return False
