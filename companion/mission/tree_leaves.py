"""Reads the leaves of a tree written by hand: actions, facts to hold, and waits."""

from __future__ import annotations

from dataclasses import dataclass

from companion.documents import Document, did_you_mean
from companion.errors import Keys, MissionError
from companion.mission.calls import read_call
from companion.mission.execution import parse_execution
from companion.mission.facts import ANYWHERE, HERE, Fact, spelled
from companion.mission.literals import is_begun, parse_literals
from companion.mission.parts import MissionParts
from companion.mission.refinement import flies
from companion.mission.skills import WAIT
from companion.mission.steps import Wait
from companion.mission.tree_nodes import Act, Check, WaitFor


@dataclass(frozen=True, slots=True)
class LeafReader:
    """Reads the texts of a tree.

    Attributes:
        document: contains the tree.
        parts: the parts of its mission.
        advice: what a node may be, for messages.
    """

    document: Document
    parts: MissionParts
    advice: str

    def read(self, text: str, keys: Keys) -> Act | Check | WaitFor:
        """The leaf that a text stands for.

        Raises:
            MissionError: it is no action, no facts and no wait.
        """
        if is_begun(text):
            hint = 'inside [ ] put quotes around an action with a comma: "move(A, B)"'
            raise MissionError(f"{text} is half an action", self.document.where(*keys), hint)
        name = text.partition("(")[0].strip()
        if name == WAIT:
            return self._delay(text, keys)
        return self._act(text, keys) if name in self.parts.skills else self.facts(text, keys)

    def _delay(self, text: str, keys: Keys) -> WaitFor:
        if "(" not in text:
            where = self.document.where(*keys)
            raise MissionError("wait has no time", where, "write wait(seconds), e.g. wait(5)")
        with self.document.locating(*keys):
            step = parse_execution(text, (), {})
        assert isinstance(step, Wait)
        return WaitFor(step.duration_s)

    def facts(self, text: str, keys: Keys) -> Check:
        """Facts that have to hold, and facts that must not.

        Raises:
            MissionError: they are no facts, or are true only for a moment.
        """
        with self.document.locating(*keys):
            literals = parse_literals(text)
            self.parts.vocabulary.check(text)
        facts = {True: set[Fact](), False: set[Fact]()}
        for literal in literals:
            event = self.parts.events.get(name := literal.atom.predicate)
            if event is not None and event.is_pulse:
                what = f"{name} is there for a moment, which no node of a tree sees"
                hint = f"give {name} latch: true, or until:"
                raise MissionError(what, self.document.where(*keys), hint)
            facts[literal.is_positive].add(literal.atom.instantiate({}))
        return Check(text, frozenset(facts[True]), frozenset(facts[False]))

    def _act(self, text: str, keys: Keys) -> Act:
        name, arguments = self._call(text, keys)
        skill = self.parts.skills[name]
        if not skill.is_planned:
            raise self._error(f"{name} only refines other skills", keys)
        if len(arguments) != len(skill.parameters):
            what = f"{text} has not the arguments of {skill.signature}"
            raise self._error(what, keys)
        origin = skill.origin if flies(skill, self.parts.skills) else None
        for argument, (parameter, members) in zip(arguments, skill.parameters, strict=True):
            is_departure = parameter == origin and argument in (HERE, ANYWHERE)
            if argument not in self.parts.sets[members] and not is_departure:
                raise self._wrong_argument(argument, parameter, members, parameter == origin, keys)
        return Act(spelled(name, arguments))

    def _call(self, text: str, keys: Keys) -> tuple[str, tuple[str, ...]]:
        """The name of a skill, and its arguments; a skill without any is a name alone."""
        if text.strip() in self.parts.skills:
            return text.strip(), ()
        forms = {name: skill.signature for name, skill in self.parts.skills.items()}
        with self.document.locating(*keys):
            call = read_call(text, "not an action", forms)
            call.refuse_names(forms[call.name])
        return str(call.name), call.words

    def _wrong_argument(
        self, argument: str, parameter: str, set_name: str, is_origin: bool, keys: Keys
    ) -> MissionError:
        members = [*self.parts.sets[set_name], *([HERE, ANYWHERE] if is_origin else [])]
        hint = f"{parameter} is one of {', '.join(members)}. {did_you_mean(argument, members)}"
        where = self.document.where(*keys)
        return MissionError(f"{argument} is not in {set_name}", where, hint.rstrip())

    def _error(self, what: str, keys: Keys) -> MissionError:
        return MissionError(what, self.document.where(*keys), self.advice)
