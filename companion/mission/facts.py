"""Facts and atoms: what may hold in a mission's world, and the same with variables.

An atom is a predicate over parameters and constants, as skills are written with: `at(to)`. A fact
is an atom without variables: `at(A)`. The formula language knows neither; its propositions are
texts. A fact *is* the proposition of its spelling, so that automata read sets of facts as they
are, and it has its predicate and arguments besides: no text is taken apart after the mission and
its formulas were read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

AT = "at"
"""The predicate of the vehicle's place."""
HERE = "here"
"""The place between places, where an interrupted flight leaves the vehicle."""
ANYWHERE = "*"
"""Where the vehicle happens to be, in trees written by hand: a place, or `here`."""

_facts: dict[str, Fact] = {}
_by_parts: dict[tuple[str, tuple[str, ...]], Fact] = {}


class Fact(str):
    """A proposition about the world: a predicate and its arguments.

    Facts are interned: the same predicate and arguments are the same object. As a str a fact is
    its spelling in the formula language.

    >>> Fact("trans_ok", ("A", "B"))
    'trans_ok(A, B)'
    >>> Fact.parse("at(A)") is Fact("at", ("A",)), Fact.parse("at(A)").arguments
    (True, ('A',))
    """

    __slots__ = ("arguments", "predicate")

    predicate: str
    arguments: tuple[str, ...]

    def __new__(cls, predicate: str, arguments: tuple[str, ...] = ()) -> Fact:
        """The fact with a predicate and arguments, the same one each time."""
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
        """The fact of a proposition in the formula language's canonical spelling."""
        return _facts.get(proposition) or cls(*_parts(proposition))

    def __setattr__(self, name: str, value: object) -> None:
        """Refuses: who holds the same fact would see another one."""
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
        """The atom of a proposition in the formula language's canonical spelling.

        >>> Atom.parse("trans_ok(from, to)")
        Atom(predicate='trans_ok', arguments=('from', 'to'))
        """
        return cls(*_parts(proposition))

    def instantiate(self, binding: Mapping[str, str]) -> Fact:
        """The fact under a binding; names without a binding stand for themselves.

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
