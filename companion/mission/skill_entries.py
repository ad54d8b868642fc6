"""Makes the checked skills of a mission from their entries in its file.

Every name in a skill is checked here: its sets, the arguments of its facts, the component and the
command that it uses. The facts that skills name are added to the mission's vocabulary.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeVar

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import MissionError
from companion.mission.charging import charge_rate_of, refuse_charge_nowhere
from companion.mission.conditions import parse_condition
from companion.mission.coordinates import Coordinates
from companion.mission.execution import KINDS, parse_execution
from companion.mission.facts import Atom
from companion.mission.literals import parse_effect, parse_fact, parse_literals
from companion.mission.looking import gimbal_of, look_at
from companion.mission.places import PointOfInterest
from companion.mission.python_call import PythonCall
from companion.mission.schema import MissionFile
from companion.mission.signals import Condition, Silence
from companion.mission.skill_numbers import check_skills
from companion.mission.skill_schema import SkillEntry
from companion.mission.skills import WAIT, ConditionalEffectTemplate, Literal, Skill
from companion.mission.steps import Do, Execution, Fly, LandOn
from companion.mission.vocabulary import Domain, Vocabulary

T = TypeVar("T")


def build_skills(
    file: MissionFile,
    document: Document,
    vocabulary: Vocabulary,
    coordinates: Coordinates | None,
    reading: DocumentReading,
) -> dict[str, Skill]:
    """Returns the skills of a mission file, and adds their facts to the vocabulary.

    Unusable skills are left out; then the vocabulary stays open for the facts that they may
    contain.

    Args:
        coordinates: None if their meaning is unknown.
    """
    skills: dict[str, Skill] = {}
    for name, entry in file.skills.items():
        builder = _SkillBuilder(name, entry, file, document, vocabulary, coordinates, reading)
        if built := builder.build():
            skills[name] = built
    if len(skills) == len(file.skills):
        reading.read(partial(check_skills, skills, file, document), "skills")
    return skills


Effect = tuple[tuple[Literal, ...], tuple[ConditionalEffectTemplate, ...]]
"""The literals of an effect, and its conditional parts."""


class _Texts(NamedTuple):
    """The texts of a skill, each parsed by itself."""

    domains: Mapping[str, Domain]
    precondition: tuple[Literal, ...]
    assumes: tuple[Atom, ...]
    effect: tuple[Literal, ...]
    conditional: tuple[ConditionalEffectTemplate, ...]
    execute: tuple[Execution, ...]


@dataclass(frozen=True, slots=True)
class _SkillBuilder:
    name: str
    entry: SkillEntry
    file: MissionFile
    document: Document
    vocabulary: Vocabulary
    coordinates: Coordinates | None
    reading: DocumentReading

    def build(self) -> Skill | None:
        """The skill; None if something in it, or something that it needs, is unusable."""
        texts, reading = self._texts(), self.reading
        has_names = all(map(reading.knows, ("places", "sets", "components")))
        if texts is None or self.coordinates is None or not has_names:
            return None
        if not reading.is_whole("battery") or not reading.is_whole("objects"):
            return None
        return self.reading.read(partial(self._checked, texts, self.coordinates), *self._keys())

    def _keys(self, *keys: str | int) -> tuple[str | int, ...]:
        return ("skills", self.name, *keys)

    def _texts(self) -> _Texts | None:
        """The texts of the skill, each key parsed by itself; None if one of them cannot be read."""
        read, knows = self.reading.read, self.reading.knows
        ranges = [name for name in self.entry.parameters.values() if name in self.file.sets]
        has_sets = knows("sets") and all(self.reading.is_whole("sets", name) for name in ranges)
        domains = read(self._domains, *self._keys("parameters")) if has_sets else None
        precondition = read(partial(self._precondition, domains), *self._keys("precondition"))
        assumes = read(partial(self._assumes, domains), *self._keys("assumes"))
        effect = read(partial(self._effect, domains), *self._keys("effect"))
        execute = None
        if self.reading.is_whole("components") and knows("skills"):
            execute = read(self._execute, *self._keys("execute"))
        if domains is None or precondition is None or assumes is None or effect is None:
            self.vocabulary.leave_open()
            return None
        return _Texts(domains, precondition, assumes, *effect, execute) if execute else None

    def _checked(self, texts: _Texts, coordinates: Coordinates) -> Skill:
        """The skill, if its texts fit together."""
        entry, execute = self.entry, texts.execute
        effect, conditional = texts.effect, texts.conditional
        if self.name == WAIT:
            raise MissionError(
                "a skill cannot be called wait",
                self.document.key_at("skills", WAIT),
                "resting for one step is a skill that every mission has; choose another name",
            )
        changed = [*effect, *(literal for when in conditional for literal in when.effect)]
        self._refuse_events([literal.atom for literal in changed], "effect")
        self._refuse_unknown_distinct()
        self._refuse_flights_to_objects(execute, texts.domains)
        conditions = [literal for when in conditional for literal in when.condition]
        literals = (*texts.precondition, *changed, *conditions)
        mentioned = [*(literal.atom for literal in literals), *texts.assumes]
        looked_at = look_at(self.name, entry, self.file, self.document, coordinates)
        self._refuse_unused(mentioned, execute, looked_at)
        skill = Skill(
            name=self.name,
            parameters=tuple(entry.parameters.items()),
            precondition=texts.precondition,
            assumes=texts.assumes,
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

    def _precondition(self, domains: Mapping[str, Domain] | None) -> tuple[Literal, ...]:
        text = self.entry.precondition
        return () if text is None else self._facts(text, domains, parse_literals, "precondition")

    def _effect(self, domains: Mapping[str, Domain] | None) -> Effect:
        text = self.entry.effect
        if text is None and self.entry.planned:
            raise MissionError(
                f"{self.name} has no effect",
                self.document.key_at("skills", self.name),
                "add effect: FACTS, what holds afterwards; a skill without one changes nothing",
            )
        return ((), ()) if text is None else self._facts(text, domains, parse_effect, "effect")

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

    def _execute(self) -> tuple[Execution, ...]:
        steps = []
        parameters = list(self.entry.parameters)
        skills = [name for name in self.file.skills if name != self.name or name not in KINDS]
        for index, text in enumerate(self.entry.execute):
            with self.document.locating("skills", self.name, "execute", index):
                steps.append(parse_execution(text, parameters, self.file.components, skills))
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
        domains: Mapping[str, Domain] | None,
        parse: Callable[[str], T],
        *keys: str | int,
    ) -> T:
        """What a text says; its names are checked if the values of the parameters are known."""
        with self.document.locating("skills", self.name, *keys):
            parsed = parse(text)
            if domains is not None:
                self.vocabulary.learn(text, domains)
        return parsed

    def _assumes(self, domains: Mapping[str, Domain] | None) -> tuple[Atom, ...]:
        """The beliefs; the key may hold one text or a list."""
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
        if cost is None:
            return None
        may_fly = any(isinstance(step, Fly | Do) for step in execute)
        where = self.document.where("skills", self.name, "cost")
        if cost == "flight_time" and not may_fly:
            raise MissionError(
                f"{self.name} does not fly, so it has no flight time", where, "write seconds"
            )
        if isinstance(cost, float | int) and not 0 < cost <= 1e6:
            raise MissionError(f"cost is {cost:g}", where, "write seconds, more than 0")
        return None if isinstance(cost, str) else float(cost)
