"""The checked skills of a mission, made from their entries in its file.

Every name in a skill is checked here: its sets, the arguments of its facts, the component and
command that it executes. The facts that skills name become part of the mission's vocabulary.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TypeVar

from companion.documents import Document, MistakeGathering, did_you_mean
from companion.errors import MissionError
from companion.mission.charging import charge_rate_of, refuse_charge_nowhere
from companion.mission.conditions import parse_condition
from companion.mission.coordinates import Coordinates
from companion.mission.execution import KINDS, parse_execution
from companion.mission.facts import Atom, spelled
from companion.mission.literals import parse_effect, parse_fact, parse_literals
from companion.mission.looking import gimbal_of, look_at
from companion.mission.model import Do, Execution, Fly, LandOn, PointOfInterest, Skill
from companion.mission.python_call import PythonCall, check_names
from companion.mission.schema import MissionFile
from companion.mission.signals import Condition, Silence
from companion.mission.skill_schema import SkillEntry
from companion.mission.vocabulary import Domain, Vocabulary

MAX_INSTANCES = 50_000  # actions of all skills; 220 places give `move` about that many
MAX_CONDITIONAL = 50_000  # conditional effects of all actions
MAX_STEPS = 100_000  # of all actions, refined down to primitives
DEFAULT_COST_S = 1.0
WAIT = "wait"  # the planner's own action, one step of rest

T = TypeVar("T")


def build_skills(
    file: MissionFile, document: Document, vocabulary: Vocabulary, coordinates: Coordinates
) -> dict[str, Skill]:
    """Returns the skills of a mission file; their facts are added to the vocabulary.

    Raises:
        MissionError: at the skills that cannot be used.
    """
    skills: dict[str, Skill] = {}
    instances = effects = 0
    mistakes = MistakeGathering()
    for name, entry in file.skills.items():
        builder = _SkillBuilder(name, entry, file, document, vocabulary, coordinates)
        if built := mistakes.read(builder.build):
            skills[name] = built
    mistakes.tell()
    for name, entry in file.skills.items():
        own = math.prod(len(file.sets[s]) for s in entry.parameters.values())
        instances += own
        effects += own * len(skills[name].conditional)
        for count, limit, what in (
            (instances, MAX_INSTANCES, "instances"),
            (effects, MAX_CONDITIONAL, "conditional effects"),
        ):
            if count > limit:
                raise MissionError(
                    f"with {name} the skills have {count} {what}, at most {limit} "
                    "can be planned with",
                    document.key_at("skills", name),
                    "give the skill fewer parameters, or smaller sets",
                )
    for name in skills:
        _check_calls(name, skills, file, document)
    _check_steps(skills, file, document)
    return skills


def _check_steps(skills: Mapping[str, Skill], file: MissionFile, document: Document) -> None:
    """Refuses refinements that multiply: of 20 skills, each done by the next one twice."""

    @cache
    def steps(name: str) -> int:
        return sum(1 + steps(x.skill) if isinstance(x, Do) else 1 for x in skills[name].execute)

    count = 0
    for name, entry in file.skills.items():
        count += steps(name) * math.prod(len(file.sets[s]) for s in entry.parameters.values())
        if count > MAX_STEPS:
            raise MissionError(
                f"with {name} the actions have {count} steps, at most {MAX_STEPS} can be planned "
                "with",
                document.key_at("skills", name),
                "refine it into fewer skills, or give it fewer parameters",
            )


def _check_calls(
    name: str, skills: Mapping[str, Skill], file: MissionFile, document: Document
) -> None:
    """Refuses calls with a wrong number of arguments, and calls that lead back to the skill."""
    constants = {*file.places, *file.objects}
    for index, step in enumerate(skills[name].execute):
        where = document.where("skills", name, "execute", index)
        known = {parameter for parameter, _ in skills[name].parameters} | constants
        if isinstance(step, PythonCall):
            check_names(step, name, known, where)
        if not isinstance(step, Do):
            continue
        wanted = [parameter for parameter, _ in skills[step.skill].parameters]
        if len(wanted) != len(step.arguments):
            raise MissionError(
                f"{step.skill} is called with {len(step.arguments)} arguments",
                where,
                f"write {spelled(step.skill, tuple(wanted))}",
            )
        for argument in step.arguments:
            if argument not in known:
                raise MissionError(
                    f"{argument} is no parameter of {name}, place or object",
                    where,
                    did_you_mean(argument, sorted(known)),
                )
        if name in _called(step.skill, skills, frozenset()):
            raise MissionError(
                f"{name} is refined into itself", where, "a refinement has to end in primitives"
            )


def _called(name: str, skills: Mapping[str, Skill], seen: frozenset[str]) -> frozenset[str]:
    """Returns a skill and all that refine it, directly or not."""
    if name in seen:
        return seen
    seen |= {name}
    for step in skills[name].execute:
        if isinstance(step, Do):
            seen |= _called(step.skill, skills, seen)
    return seen


@dataclass(frozen=True, slots=True)
class _SkillBuilder:
    name: str
    entry: SkillEntry
    file: MissionFile
    document: Document
    vocabulary: Vocabulary
    coordinates: Coordinates

    def build(self) -> Skill:
        entry = self.entry
        if self.name == WAIT:
            raise MissionError(
                "a skill cannot be called wait",
                self.document.key_at("skills", WAIT),
                "resting for one step is a skill that every mission has; choose another name",
            )
        domains = self._domains()
        precondition = (
            self._facts(entry.precondition, domains, parse_literals, "precondition")
            if entry.precondition is not None
            else ()
        )
        assumes = self._assumes(domains)
        if entry.effect is None and entry.planned:
            raise MissionError(
                f"{self.name} has no effect",
                self.document.key_at("skills", self.name),
                "add effect: FACTS, what holds afterwards; a skill without one changes nothing",
            )
        effect, conditional = (
            self._facts(entry.effect, domains, parse_effect, "effect") if entry.effect else ((), ())
        )
        changed = [*effect, *(literal for when in conditional for literal in when.effect)]
        self._refuse_events([literal.atom for literal in changed], "effect")
        self._refuse_unknown_distinct()
        execute = self._execute(domains)
        self._refuse_flights_to_objects(execute, domains)
        conditions = [literal for when in conditional for literal in when.condition]
        literals = (*precondition, *changed, *conditions)
        mentioned = [*(literal.atom for literal in literals), *assumes]
        looked_at = look_at(self.name, entry, self.file, self.document, self.coordinates)
        self._refuse_unused(mentioned, execute, looked_at)
        skill = Skill(
            name=self.name,
            parameters=tuple(entry.parameters.items()),
            precondition=precondition,
            assumes=assumes,
            effect=effect,
            cost_s=self._cost_s(execute),
            execute=execute,
            tries=entry.tries,
            timeout_s=entry.timeout_s,
            conditional=conditional,
            distinct=tuple(map(tuple, entry.distinct)),
            is_planned=entry.planned,
            retry_after_s=entry.retry_after_s,
            look_at=looked_at,
            is_repeatable=entry.repeatable,
            confirmed_by=self._confirmed_by(),
            gimbal=gimbal_of(self.name, entry, self.file, self.document),
            energy_wh=entry.energy_wh,
            charge_rate=charge_rate_of(self.name, entry, execute, self.file, self.document),
        )
        refuse_charge_nowhere(skill, self.document)
        return skill

    def _confirmed_by(self) -> Condition | None:
        text, keys = self.entry.confirmed_by, ("skills", self.name, "confirmed_by")
        if text is None:
            return None
        with self.document.locating(*keys):
            condition = parse_condition(text)
        if isinstance(condition, Silence):
            hint = "write what has to be heard, e.g. NAMED_VALUE_INT[load].value > 0"
            raise MissionError("silence confirms nothing", self.document.where(*keys), hint)
        return condition

    def _execute(self, domains: Mapping[str, Domain]) -> tuple[Execution, ...]:
        steps = []
        skills = [name for name in self.file.skills if name != self.name or name not in KINDS]
        for index, text in enumerate(self.entry.execute):
            with self.document.locating("skills", self.name, "execute", index):
                steps.append(parse_execution(text, list(domains), self.file.components, skills))
        return tuple(steps)

    def _domains(self) -> Mapping[str, Domain]:
        for parameter, set_name in self.entry.parameters.items():
            keys = ("skills", self.name, "parameters", parameter)
            if set_name not in self.file.sets:
                listing = ", ".join(self.file.sets) or "none yet"
                hint = f"sets are {listing}. {did_you_mean(set_name, self.file.sets)}".rstrip()
                raise MissionError(f"unknown set {set_name}", self.document.where(*keys), hint)
            for kind, names in (("a place", self.file.places), ("an object", self.file.objects)):
                if parameter in names:
                    raise MissionError(
                        f"the parameter {parameter} has the name of {kind}",
                        self.document.key_at(*keys),
                        f"choose another name: facts about {parameter} would have two meanings",
                    )
        return {p: tuple(self.file.sets[s]) for p, s in self.entry.parameters.items()}

    def _refuse_unknown_distinct(self) -> None:
        known = [*self.entry.parameters, *self.file.places, *self.file.objects]
        for group, names in enumerate(self.entry.distinct):
            for index, name in enumerate(names):
                if name not in known:
                    raise MissionError(
                        f"{self.name} has no parameter {name}",
                        self.document.where("skills", self.name, "distinct", group, index),
                        f"its parameters are {', '.join(self.entry.parameters)}; places and "
                        f"objects may stand here too. {did_you_mean(name, known)}".rstrip(),
                    )

    def _refuse_flights_to_objects(
        self, execute: tuple[Execution, ...], domains: Mapping[str, Domain]
    ) -> None:
        for step in execute:
            for member in domains[step.place] if isinstance(step, Fly | LandOn) else ():
                if member not in self.file.places:
                    raise MissionError(
                        f"{self.name} cannot fly to {member}, which is no place",
                        self.document.where("skills", self.name, "execute"),
                        f"places are {', '.join(self.file.places)}",
                    )

    def _facts(
        self,
        text: str,
        domains: Mapping[str, Domain],
        parse: Callable[[str], T],
        *keys: str | int,
    ) -> T:
        with self.document.locating("skills", self.name, *keys):
            parsed = parse(text)
            self.vocabulary.learn(text, domains)
        return parsed

    def _assumes(self, domains: Mapping[str, Domain]) -> tuple[Atom, ...]:
        """The beliefs, whose key may hold one text or a list."""
        atoms = []
        for index, text in enumerate(self.entry.assumes):
            atom = self._facts(text, domains, parse_fact, "assumes", index)
            self._refuse_events([atom], "assumes", index)
            atoms.append(atom)
        return tuple(atoms)

    def _refuse_events(self, atoms: list[Atom], *keys: str | int) -> None:
        for atom in atoms:
            if atom.predicate in self.file.events:
                raise MissionError(
                    f"{atom.predicate} is an event, so the skill {self.name} cannot set it",
                    self.document.where("skills", self.name, *keys),
                    "an event is read off MAVLink; use another fact, or remove the event in "
                    f"{self.document.key_at('events', atom.predicate).inside}",
                )

    def _refuse_unused(
        self,
        atoms: list[Atom],
        execute: tuple[Execution, ...],
        looked_at: str | PointOfInterest | None,
    ) -> None:
        used: set[str | PointOfInterest | None] = {looked_at}
        used |= {argument for atom in atoms for argument in atom.arguments}
        used |= {step.place for step in execute if isinstance(step, Fly | LandOn)}
        used |= {word for step in execute if isinstance(step, Do) for word in step.arguments}
        used |= {word for step in execute if isinstance(step, PythonCall) for word in step.names}
        for parameter in self.entry.parameters:
            if parameter not in used:
                raise MissionError(
                    f"the parameter {parameter} of {self.name} is not used",
                    self.document.key_at("skills", self.name, "parameters", parameter),
                    "use it in precondition, assumes, effect, execute or look_at, or remove it",
                )

    def _cost_s(self, execute: tuple[Execution, ...]) -> float | None:
        cost = self.entry.cost
        flies = any(isinstance(step, Fly) for step in execute)
        if cost is None:
            return None if flies else DEFAULT_COST_S
        where = self.document.where("skills", self.name, "cost")
        if cost == "flight_time" and not flies:
            raise MissionError(
                f"{self.name} does not fly, so it has no flight time", where, "write seconds"
            )
        if isinstance(cost, float | int) and not 0 < cost <= 1e6:
            raise MissionError(f"cost is {cost:g}", where, "write seconds, more than 0")
        return None if isinstance(cost, str) else float(cost)
