"""A plan written by hand: the behaviour tree of a mission file (Section IV-A of the paper).

    text                        an action of a skill, `move(A, B)`, or facts to hold, `lit & !late`
    [node, ...]                 one after the other, until one fails
    {fallback: [node, ...]}     the first that succeeds
    {repeat: [node, ...]}       the sequence for ever, or `times` times; ends when it fails
    {retry: [node, ...], times: n}      the sequence, n times at most, until it succeeds
    {watch: facts, do: [node, ...]}     the sequence while facts hold; it is interrupted if not

An interrupted flight leaves the vehicle between places, at `here`: `move(here, B)` flies on.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from companion.mission.facts import HERE, Atom, Fact
from companion.mission.literals import parse_literals
from companion.mission.model import Fly, Skill
from companion.mission.tree_nodes import Act, Check, Fallback, Repeat, Retry, Steps, Tree, Watch
from companion.mission.vocabulary import Vocabulary

FORMS = {"fallback": {"fallback"}, "repeat": {"repeat", "times"}, "retry": {"retry", "times"}}
FORMS["watch"] = {"watch", "do"}
_HINT = "a node is a text, a list, or one of fallback, repeat, retry and watch"


def read_tree(
    data: object,
    document: Document,
    skills: Mapping[str, Skill],
    sets: Mapping[str, Collection[str]],
    vocabulary: Vocabulary,
) -> Tree:
    """Reads the tree under the key `tree`.

    Raises:
        MissionError: with the place of the first node that cannot be used.
    """
    return _WrittenTreeReader(document, skills, sets, vocabulary).node(data, ("tree",))


@dataclass(frozen=True, slots=True)
class _WrittenTreeReader:
    document: Document
    skills: Mapping[str, Skill]
    sets: Mapping[str, Collection[str]]
    vocabulary: Vocabulary

    def node(self, data: object, keys: tuple[str | int, ...]) -> Tree:
        if isinstance(data, str):
            return self._text(data, keys)
        if isinstance(data, list) and data:
            return Steps(tuple(self.node(d, (*keys, i)) for i, d in enumerate(data)))
        if isinstance(data, dict):
            return self._table(data, keys)
        raise self._error("not a node of a tree", keys)

    def _table(self, data: Mapping[str, object], keys: tuple[str | int, ...]) -> Tree:
        kind = next((kind for kind in FORMS if kind in data), None)
        if kind is None:
            raise self._error(f"unknown node {next(iter(data), '')}", keys)
        for key in data:
            if key not in FORMS[kind]:
                raise self._error(f"{kind} has no key {key}", (*keys, key))
        if kind == "fallback":
            return Fallback(self._steps(data, kind, keys).nodes)
        if kind == "watch":
            facts = data[kind]
            if not isinstance(facts, str):
                raise self._error("watch needs facts", (*keys, kind))
            return Watch(self._check(facts, (*keys, kind)), self._steps(data, "do", keys))
        steps = self._steps(data, kind, keys)
        times = data.get("times")
        if kind == "repeat" and "times" not in data:
            return Repeat(steps, None)
        if not isinstance(times, int) or isinstance(times, bool) or times < 1:
            raise self._error(f"{kind} needs times: a whole number, 1 or more", (*keys, "times"))
        return Repeat(steps, times) if kind == "repeat" else Retry(steps, times)

    def _steps(self, data: Mapping[str, object], key: str, keys: tuple[str | int, ...]) -> Steps:
        node = self.node(data.get(key), (*keys, key))
        return node if isinstance(node, Steps) else Steps((node,))

    def _text(self, text: str, keys: tuple[str | int, ...]) -> Tree:
        if text.count("(") > text.count(")"):
            hint = 'inside [ ] put quotes around an action with a comma: "move(A, B)"'
            raise MissionError(f"{text} is half an action", self.document.where(*keys), hint)
        name = text.partition("(")[0].strip()
        return self._act(text, keys) if name in self.skills else self._check(text, keys)

    def _check(self, text: str, keys: tuple[str | int, ...]) -> Check:
        with self.document.locating(*keys):
            literals = parse_literals(text)
            self.vocabulary.check(text)
        facts = {True: set[Fact](), False: set[Fact]()}
        for literal in literals:
            facts[literal.is_positive].add(literal.atom.instantiate({}))
        return Check(text, frozenset(facts[True]), frozenset(facts[False]))

    def _act(self, text: str, keys: tuple[str | int, ...]) -> Act:
        atom = Atom.parse(text.replace(" ", "").replace(",", ", "))
        skill = self.skills[atom.predicate]
        wanted = ", ".join(parameter for parameter, _ in skill.parameters)
        if not skill.is_planned:
            raise self._error(f"{atom.predicate} only refines other skills", keys)
        if len(atom.arguments) != len(skill.parameters):
            raise self._error(f"{text} has not the arguments of {atom.predicate}({wanted})", keys)
        for argument, (parameter, name) in zip(atom.arguments, skill.parameters, strict=True):
            is_departure = argument == HERE and any(isinstance(s, Fly) for s in skill.execute)
            if argument not in self.sets[name] and not is_departure:
                members = ", ".join(self.sets[name])
                hint = f"{parameter} is one of {members}. {did_you_mean(argument, self.sets[name])}"
                where = self.document.where(*keys)
                raise MissionError(f"{argument} is not in {name}", where, hint.rstrip())
        return Act(str(atom))

    def _error(self, what: str, keys: tuple[str | int, ...]) -> MissionError:
        return MissionError(what, self.document.where(*keys), _HINT)
