"""The skills of a mission as values; skill_entries.py reads them."""

from __future__ import annotations

from dataclasses import dataclass

from companion.battery_profile import Points
from companion.mission.facts import AT, Atom, spelled
from companion.mission.places import PointOfInterest
from companion.mission.signals import Condition
from companion.mission.steps import Execution

WAIT = "wait"
"""The planner's own skill: one step of rest."""


@dataclass(frozen=True, slots=True)
class Literal:
    """An atom or its negation."""

    atom: Atom
    is_positive: bool


@dataclass(frozen=True, slots=True)
class ConditionalEffectTemplate:
    """An effect that happens only if a condition holds before the skill."""

    condition: tuple[Literal, ...]
    effect: tuple[Literal, ...]


@dataclass(frozen=True, slots=True)
class Skill:
    """The paper's action template (Section II-E), with beliefs and a refinement.

    Attributes:
        parameters: (parameter name, set name), in order.
        precondition: conjunction of literals over the parameters.
        assumes: beliefs that are assumed to be true until the skill fails.
        effect: literals that hold afterwards.
        conditional: further effects, each with a condition.
        distinct: groups of parameters, places and objects whose members must all differ.
        cost_s: constant cost in seconds; None for the time of its steps, with flights on the map.
        execute: its refinement, a sequence of steps.
        tries: how often the refinement is tried before the skill fails (MAX_TRY, Fig. 6).
        timeout_s: longest duration of one try; None for no limit.
        is_planned: whether the planner may use it; if not, it only refines other skills.
        retry_after_s: time after which beliefs that its failure withdrew are held again.
        look_at: what the vehicle looks at meanwhile: the place of a parameter, or a fixed point.
        is_repeatable: whether commands may be sent again if it is unknown whether they were done.
        confirmed_by: the condition that has to be heard after its last step; None for nothing.
        gimbal: component that also looks at it; None if only the vehicle turns.
        energy_wh: the energy that it takes in addition to flying or hovering.
        charge_rate: pairs of the charge (0 to 1) and its rise per second, which falls.
    """

    name: str
    parameters: tuple[tuple[str, str], ...]
    precondition: tuple[Literal, ...]
    assumes: tuple[Atom, ...]
    effect: tuple[Literal, ...]
    cost_s: float | None
    execute: tuple[Execution, ...]
    tries: int
    timeout_s: float | None
    conditional: tuple[ConditionalEffectTemplate, ...] = ()
    distinct: tuple[tuple[str, ...], ...] = ()
    is_planned: bool = True
    retry_after_s: float | None = None
    look_at: str | PointOfInterest | None = None
    is_repeatable: bool = False
    confirmed_by: Condition | None = None
    gimbal: int | None = None
    energy_wh: float = 0.0
    charge_rate: Points | None = None

    @property
    def signature(self) -> str:
        """How the skill is called, with the names of its parameters, e.g. move(from, to)."""
        return spelled(self.name, tuple(name for name, _ in self.parameters))

    @property
    def origin(self) -> str | None:
        """The parameter p of a precondition at(p), where the skill begins; None without one."""
        names = [name for name, _ in self.parameters]
        for literal in self.precondition:
            atom = literal.atom
            if literal.is_positive and atom.predicate == AT and atom.arguments[0] in names:
                return atom.arguments[0]
        return None
