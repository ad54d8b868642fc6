"""Makes the checked skills of a mission from their entries in its file.

First the texts of a skill are read, each by itself (skill_texts.py); then it is checked here that
they fit together. The facts that skills name are added to the mission's vocabulary.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import MissionError
from companion.mission.charging import charge_rate_of, refuse_charge_nowhere
from companion.mission.conditions import parse_condition
from companion.mission.coordinates import Coordinates
from companion.mission.facts import Atom
from companion.mission.looking import gimbal_of, look_at
from companion.mission.places import PointOfInterest
from companion.mission.python_call import PythonCall
from companion.mission.schema import MissionFile
from companion.mission.signals import Condition, Silence
from companion.mission.skill_numbers import check_skills
from companion.mission.skill_schema import SkillEntry
from companion.mission.skill_texts import SkillTextReader, SkillTexts, refuse_events
from companion.mission.skills import WAIT, Skill
from companion.mission.steps import Do, Execution, Fly, LandOn
from companion.mission.vocabulary import Domain, Vocabulary


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
    has_names = all(map(reading.knows, ("places", "sets", "components")))
    is_whole = has_names and reading.is_whole("battery") and reading.is_whole("objects")
    skills: dict[str, Skill] = {}
    for name, entry in file.skills.items():
        texts = SkillTextReader(name, entry, file, document, vocabulary, reading).texts()
        if texts is None or coordinates is None or not is_whole:
            continue
        builder = _SkillBuilder(name, entry, file, document, coordinates)
        if skill := reading.read(("skills", name), builder.skill, texts):
            skills[name] = skill
    if len(skills) == len(file.skills):
        reading.read(("skills",), check_skills, skills, file, document)
    return skills


@dataclass(frozen=True, slots=True)
class _SkillBuilder:
    """Makes one skill from its texts, if they fit together."""

    name: str
    entry: SkillEntry
    file: MissionFile
    document: Document
    coordinates: Coordinates

    def skill(self, texts: SkillTexts) -> Skill:
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
        atoms = [literal.atom for literal in changed]
        refuse_events(atoms, self.name, self.file, self.document, "effect")
        self._refuse_unknown_distinct()
        self._refuse_flights_to_objects(execute, texts.domains)
        conditions = [literal for when in conditional for literal in when.condition]
        literals = (*texts.precondition, *changed, *conditions)
        mentioned = [*(literal.atom for literal in literals), *texts.assumes]
        looked_at = look_at(self.name, entry, self.file, self.document, self.coordinates)
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
                        f"{self.name} cannot fly to {member}, which is not a place",
                        self.document.where("skills", self.name, "execute"),
                        f"places are {', '.join(self.file.places)}",
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
