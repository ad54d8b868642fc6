"""Reads the texts of a skill, each by itself: facts, effects, beliefs and steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import MissionError
from companion.mission.execution import KINDS, parse_execution
from companion.mission.facts import Atom
from companion.mission.literals import parse_effect, parse_fact, parse_literals
from companion.mission.schema import MissionFile
from companion.mission.skill_schema import SkillEntry
from companion.mission.skills import ConditionalEffectTemplate, Literal
from companion.mission.steps import Execution
from companion.mission.vocabulary import Domain, Vocabulary

T = TypeVar("T")

Effect = tuple[tuple[Literal, ...], tuple[ConditionalEffectTemplate, ...]]
"""The literals of an effect, and its conditional parts."""


class SkillTexts(NamedTuple):
    """What the texts of a skill say.

    Attributes:
        domains: the possible values of its parameters, by name.
    """

    domains: Mapping[str, Domain]
    precondition: tuple[Literal, ...]
    assumes: tuple[Atom, ...]
    effect: tuple[Literal, ...]
    conditional: tuple[ConditionalEffectTemplate, ...]
    execute: tuple[Execution, ...]


@dataclass(frozen=True, slots=True)
class SkillTextReader:
    """Reads the texts of one skill, and adds its facts to the vocabulary."""

    name: str
    entry: SkillEntry
    file: MissionFile
    document: Document
    vocabulary: Vocabulary
    reading: DocumentReading

    def texts(self) -> SkillTexts | None:
        """The texts of the skill, each key parsed by itself; None if one of them cannot be read."""
        read, knows = self.reading.read, self.reading.knows
        ranges = [name for name in self.entry.parameters.values() if name in self.file.sets]
        has_sets = knows("sets") and all(self.reading.is_whole("sets", name) for name in ranges)
        domains = read(self._keys("parameters"), self._domains) if has_sets else None
        precondition = read(self._keys("precondition"), self._precondition, domains)
        assumes = read(self._keys("assumes"), self._assumes, domains)
        effect = read(self._keys("effect"), self._effect, domains)
        execute = None
        if self.reading.is_whole("components") and knows("skills"):
            execute = read(self._keys("execute"), self._execute)
        if domains is None or precondition is None or assumes is None or effect is None:
            self.vocabulary.leave_open()
            return None
        return SkillTexts(domains, precondition, assumes, *effect, execute) if execute else None

    def _keys(self, *keys: str | int) -> tuple[str | int, ...]:
        return ("skills", self.name, *keys)

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

    def _precondition(self, domains: Mapping[str, Domain] | None) -> tuple[Literal, ...]:
        text = self.entry.precondition
        return () if text is None else self._facts(text, domains, parse_literals, "precondition")

    def _assumes(self, domains: Mapping[str, Domain] | None) -> tuple[Atom, ...]:
        """The beliefs; the key may hold one text or a list."""
        atoms = []
        for index, text in enumerate(self.entry.assumes):
            atom = self._facts(text, domains, parse_fact, "assumes", index)
            refuse_events([atom], self.name, self.file, self.document, "assumes", index)
            atoms.append(atom)
        return tuple(atoms)

    def _effect(self, domains: Mapping[str, Domain] | None) -> Effect:
        text = self.entry.effect
        if text is None and self.entry.planned:
            raise MissionError(
                f"{self.name} has no effect",
                self.document.key_at("skills", self.name),
                "add effect: FACTS, what holds afterwards; a skill without one changes nothing",
            )
        return ((), ()) if text is None else self._facts(text, domains, parse_effect, "effect")

    def _execute(self) -> tuple[Execution, ...]:
        steps = []
        parameters = list(self.entry.parameters)
        skills = [name for name in self.file.skills if name != self.name or name not in KINDS]
        for index, text in enumerate(self.entry.execute):
            with self.document.locating("skills", self.name, "execute", index):
                steps.append(parse_execution(text, parameters, self.file.components, skills))
        return tuple(steps)

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


def refuse_events(
    atoms: Iterable[Atom], skill: str, file: MissionFile, document: Document, *keys: str | int
) -> None:
    """Refuses a skill that sets events, under some of its keys.

    Raises:
        MissionError: at the first event.
    """
    for atom in atoms:
        if atom.predicate in file.events:
            raise MissionError(
                f"{atom.predicate} is an event, so the skill {skill} cannot set it",
                document.where("skills", skill, *keys),
                "an event is read off MAVLink; use another fact, or remove the event in "
                f"{document.key_at('events', atom.predicate).inside}",
            )
