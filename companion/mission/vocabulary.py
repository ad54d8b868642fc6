"""Knows which facts exist in a mission, and finds the most similar one to a fact that does not.

A fact exists if it is an event, if some skill names its predicate with arguments from the same
sets, or if a PDDL domain declares it. `at(p)` exists for every place. Facts are not enumerated:
each predicate stores the sets of its arguments, so many places cost nothing here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from companion.documents import did_you_mean, most_similar
from companion.errors import FormulaError
from companion.ltl.parser import occurrences
from companion.ltl.patterns import PATTERNS
from companion.mission.facts import AT, Atom, spelled

Domain = tuple[str, ...]
"""The places or objects that an argument of a predicate may be."""

_SHOWN = 20  # names listed in a message
_BY_ITSELF = {
    **dict.fromkeys(
        ("land", "landed", "rtl", "return_home", "returned"),
        "The vehicle lands where the task is done: write F G at(PLACE).",
    ),
    **dict.fromkeys(
        ("takeoff", "take_off", "arm", "armed", "airborne"),
        "The vehicle takes off before the first skill, by itself.",
    ),
}
"""Commands of other programs -> what the companion does by itself instead."""


class Vocabulary:
    """The facts of a mission.

    Args:
        places: names of all places.
        events: names of all events.
        objects: names of things that are not places.
        declared: predicates in addition to those that skills name, with what each argument may be.
        skills: what each skill makes true, as it is written; only for advice.
        things_are_known: whether all places and objects are known.
        is_open: whether other facts may exist, because some of their sources could not be read.
        told: facts that have already been reported as unknown.
    """

    def __init__(
        self,
        places: Iterable[str],
        events: Iterable[str],
        objects: Iterable[str] = (),
        declared: Mapping[str, tuple[Domain, ...]] | None = None,
        skills: Mapping[str, str | None] | None = None,
        things_are_known: bool = True,
        is_open: bool = False,
        told: Iterable[str] = (),
    ) -> None:
        self._skills = skills or {}
        self._things_are_known = things_are_known
        self._is_open = is_open or not things_are_known
        self._told: set[object] = set(told)
        self._places = tuple(places)
        self._objects = tuple(objects)
        self._uses: dict[str, list[tuple[Domain, ...]]] = {AT: [(self._places,)]}
        self._uses |= {event: [()] for event in events}
        for name, domains in (declared or {}).items():
            self._uses.setdefault(name, [domains])

    def leave_open(self) -> None:
        """From now on, facts may exist that are not known here."""
        self._is_open = True

    def learn(self, text: str, domains: Mapping[str, Domain]) -> None:
        """Adds the facts in a skill's text, which may have new predicates.

        Args:
            text: literals or one fact.
            domains: the skill's parameters, and their possible values.

        Raises:
            FormulaError: an argument is not a parameter, place or object; a known predicate has
                another number of arguments; or the argument of `at` is not a place.
        """
        for fact, offset, length in occurrences(text):
            atom = Atom.parse(fact)
            for argument in atom.arguments:
                known = [*domains, *self._places, *self._objects]
                if (argument, *domains) in self._told or not self._things_are_known:
                    continue
                if argument not in known:
                    self._told.add((argument, *domains))
                    kinds = "parameters, places and objects"
                    if not self._objects:
                        kinds = "parameters and places"
                    what = f"{argument} in {fact} is neither a parameter nor a place"
                    hint = f"{kinds} are {_listing(known)}. {did_you_mean(argument, known)}"
                    raise FormulaError(what, text, offset, length, hint.rstrip())
            if atom.predicate in self._uses:
                self._check_arity(atom, text, offset, length)
            use = tuple(domains.get(argument, (argument,)) for argument in atom.arguments)
            strange = [m for domain in use for m in domain if m not in self._places]
            if atom.predicate == AT and strange and self._things_are_known:
                hint = f"the vehicle can be at {_listing(self._places)}"
                what = f"{fact} speaks of {strange[0]}, which is not a place"
                raise FormulaError(what, text, offset, length, hint)
            self._uses.setdefault(atom.predicate, []).append(use)

    def check(self, text: str) -> None:
        """Checks every fact of a formula. A fact that was reported once counts as known afterwards.

        Raises:
            FormulaError: at the first fact that does not exist.
        """
        unknown = []
        for fact, *place in occurrences(text):
            if fact not in self._told and (mistake := self._mistake(fact, text, *place)):
                unknown.append(mistake)
                self._told.add(fact)
        if unknown:
            raise unknown[0].beside(unknown[1:])

    def _mistake(self, fact: str, text: str, offset: int, length: int) -> FormulaError | None:
        """Why a fact does not exist; None if it does or may exist."""
        atom = Atom.parse(fact)
        if atom.predicate not in self._uses:
            if self._is_open:
                return None
            names = [self._example(name) for name in self._uses]
            hint = f"facts are {_listing(names)}. {self._similar(atom)}".rstrip()
            return FormulaError(f"unknown fact {fact}", text, offset, length, hint)
        try:
            self._check_arity(atom, text, offset, length)
        except FormulaError as error:
            return error
        if self._is_open and not (atom.predicate == AT and self._things_are_known):
            return None
        uses = self._uses[atom.predicate]
        if any(all(a in d for a, d in zip(atom.arguments, use, strict=True)) for use in uses):
            return None
        hint = f"{self._domain_listing(atom)}. {self._similar(atom)}".rstrip()
        return FormulaError(f"unknown fact {fact}", text, offset, length, hint)

    def _check_arity(self, atom: Atom, text: str, offset: int, length: int) -> None:
        arity = self._arity(atom.predicate)
        if len(atom.arguments) != arity:
            count = {0: "no arguments", 1: "1 argument"}.get(arity, f"{arity} arguments")
            hint = f"write {self._example(atom.predicate)}"
            if atom.predicate == AT and atom.arguments:
                hint = f"write {' | '.join(spelled(AT, (each,)) for each in atom.arguments)}"
                hint += ", or &, with F before each of them"
            raise FormulaError(f"{atom.predicate} has {count}", text, offset, length, hint)

    def _example(self, name: str) -> str:
        return spelled(name, tuple(domain[0] for domain in self._uses[name][0]))

    def _similar(self, atom: Atom) -> str:
        """Returns the most similar fact or pattern, with one argument or the name replaced."""
        if atom.predicate in self._places and not atom.arguments:
            return f"Did you mean {spelled(AT, (atom.predicate,))}?"
        if atom.predicate not in self._uses:
            if atom.predicate in self._skills:
                effect = self._skills[atom.predicate]
                made = f", as its effect is: {effect}" if effect else ""
                return f"{atom.predicate} is a skill: write what it makes true{made}."
            if advice := _BY_ITSELF.get(atom.predicate.lower()):
                return advice
            known = [name for name in self._uses if self._arity(name) == len(atom.arguments)]
            name = most_similar(atom.predicate, [*known, *(PATTERNS if atom.arguments else ())])
            return f"Did you mean {spelled(name, atom.arguments)}?" if name else ""
        facts = [
            spelled(atom.predicate, (*atom.arguments[:i], place, *atom.arguments[i + 1 :]))
            for use in self._uses.get(atom.predicate, [])[:1]
            for i, domain in enumerate(use)
            for place in domain
            if atom.arguments[i] not in domain
        ]
        return did_you_mean(str(atom), facts)

    def _arity(self, name: str) -> int:
        return len(self._uses[name][0])

    def _domain_listing(self, atom: Atom) -> str:
        things = (*self._places, *self._objects)
        if any(argument not in things for argument in atom.arguments):
            listing = f"places are {_listing(self._places)}"
            return listing + (f"; objects are {_listing(self._objects)}" if self._objects else "")
        allowed = (
            dict.fromkeys(p for use in self._uses[atom.predicate] for p in use[i])
            for i in range(len(atom.arguments))
        )
        return "; ".join(
            f"argument {i} of {atom.predicate} is one of {_listing(places)}"
            for i, places in enumerate(allowed, start=1)
        )


def _listing(names: Iterable[str]) -> str:
    listed = list(names)
    return ", ".join(listed[:_SHOWN]) + (", ..." if len(listed) > _SHOWN else "")
