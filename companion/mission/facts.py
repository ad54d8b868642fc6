"""Facts and atoms: statements about a mission's world, without and with variables.

An atom is a predicate over parameters and constants, as skills contain it: `at(to)`. A fact is an
atom without variables: `at(A)`. The formula language knows neither: its propositions are texts. A
fact *is* the text of its proposition, so automata can read sets of facts directly. It also has a
predicate and arguments, so no text needs to be parsed once the mission and its formulas have been
read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

AT = "at"
"""The predicate that says where the vehicle is."""
HERE = "here"
"""The pseudo-place between places, where the vehicle is after an interrupted flight."""
ANYWHERE = "*"
"""In trees written by hand: wherever the vehicle happens to be, a place or `here`."""

_facts: dict[str, Fact] = {}
_by_parts: dict[tuple[str, tuple[str, ...]], Fact] = {}


class Fact(str):
    """A proposition about the world: a predicate and its arguments.

    Facts are interned: equal predicates and arguments give the same object. As a str, a fact is its
    spelling in the formula language.

    >>> Fact("trans_ok", ("A", "B"))
    'trans_ok(A, B)'
    >>> Fact.parse("at(A)") is Fact("at", ("A",)), Fact.parse("at(A)").arguments
    (True, ('A',))
    """

    __slots__ = ("arguments", "predicate")

    predicate: str
    arguments: tuple[str, ...]

    def __new__(cls, predicate: str, arguments: tuple[str, ...] = ()) -> Fact:
        """The fact with this predicate and these arguments, the same object each time."""
        fact = _by_parts.get((predicate, arguments))
        if fact is not None:
            return fact
        spelling = spelled(predicate, arguments)
        fact = _facts.get(spelling)
        if fact is None:
            fact = super().__new__(cls, spelling)
            object.__setattr__(fact, "predicate", predicate)
            object.__setattr__(fact, "arguments", arguments)
            _facts[spelling] = fact
        _by_parts[predicate, arguments] = fact
        return fact

    @classmethod
    def parse(cls, proposition: str) -> Fact:
        """The fact that a proposition in canonical spelling stands for."""
        return _facts.get(proposition) or cls(*_parts(proposition))

    def __setattr__(self, name: str, value: object) -> None:
        """Refuses any change, because others hold the same object."""
        raise AttributeError(f"{name} of a fact cannot be set")

    def __reduce__(self) -> tuple[type[Fact], tuple[str, tuple[str, ...]]]:
        return Fact, (self.predicate, self.arguments)


@dataclass(frozen=True, slots=True)
class Atom:
    """A predicate over skill parameters or constants, e.g. trans_ok(from, to)."""

    predicate: str
    arguments: tuple[str, ...] = ()

    @classmethod
    def parse(cls, proposition: str) -> Atom:
        """The atom that a proposition in canonical spelling stands for.

        >>> Atom.parse("trans_ok(from, to)")
        Atom(predicate='trans_ok', arguments=('from', 'to'))
        """
        return cls(*_parts(proposition))

    def instantiate(self, binding: Mapping[str, str]) -> Fact:
        """The fact under a binding; names without a binding stay as they are.

        >>> Atom("at", ("from",)).instantiate({"from": "A"})
        'at(A)'
        """
        return Fact(self.predicate, tuple([binding.get(a, a) for a in self.arguments]))

    def __str__(self) -> str:
        return spelled(self.predicate, self.arguments)


def at(place: str) -> Fact:
    """The fact that the vehicle is at a place."""
    return Fact(AT, (place,))


def spelled(name: str, arguments: tuple[str, ...]) -> str:
    """A name with its arguments, as formulas, plans and events spell facts and actions.

    >>> spelled("move", ("A", "B")), spelled("land", ())
    ('move(A, B)', 'land')
    """
    return f"{name}({', '.join(arguments)})" if arguments else name


def _parts(proposition: str) -> tuple[str, tuple[str, ...]]:
    predicate, _, arguments = proposition.removesuffix(")").partition("(")
    return predicate, tuple(arguments.split(", ")) if arguments else ()
