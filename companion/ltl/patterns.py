"""The robotic mission patterns: the usual tasks of a robot in temporal logic.

A pattern is written like a proposition with arguments, e.g. `patrolling(A, B, C)`. It stands for
the formula of its scheme, which is text: `parser.py` reads the expansion in place of the call, so
no other module knows of patterns. A place `A` stands for the proposition at(A); a condition is a
proposition such as `targetFound` or `at(A)`; a count is a number from 1 to 9.

A visit is a position at which at(A) holds: staying at A for two positions counts as two visits,
and breaks the patterns in which visits take turns (ordered, strict, fair).

Source: Menghi, Tsigkanos, Pelliccione, Ghezzi, Berger, Specification Patterns for Robotic
Missions, IEEE Transactions on Software Engineering, 2021; https://roboticpatterns.com.

>>> pattern = PATTERNS["patrolling"]
>>> pattern.signature
'patrolling(place, place, ...)'
>>> pattern.expansion(["A", "B"])
'(G F at(A)) & (G F at(B))'
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

AT = "at"
"""The predicate of propositions about places."""


class ParameterKind(Enum):
    """The kinds of arguments that patterns have; the value is the word used in signatures."""

    PLACE = "place"
    CONDITION = "condition"
    COUNT = "count"


_WANTED = {
    ParameterKind.PLACE: (r"[A-Za-z_]\w*", "the name of a place"),
    ParameterKind.CONDITION: (
        r"(?!(true|false|[XFGURW])$)[A-Za-z_]\w*(\(.*\))?",
        "a proposition such as targetFound or at(A)",
    ),
    ParameterKind.COUNT: (r"[1-9]", "a number from 1 to 9"),
}
"""For each kind, the form of suitable arguments, and how messages describe them."""


@dataclass(frozen=True, slots=True)
class Pattern:
    """A name for a formula scheme.

    Attributes:
        conjuncts: turns the propositions and counts of the arguments, as text, into the formulas
            that all have to hold.
        is_open: whether more arguments of the last one's kind may follow.
    """

    name: str
    parameters: tuple[ParameterKind, ...]
    conjuncts: Callable[..., list[str]]
    is_open: bool = False

    @property
    def signature(self) -> str:
        """How the pattern is written, with the kinds of its arguments."""
        listed = [parameter.value for parameter in self.parameters] + ["..."] * self.is_open
        return f"{self.name}({', '.join(listed)})"

    def misfit(self, arguments: Sequence[str]) -> tuple[int | None, str] | None:
        """The index of an argument that does not suit, and what is wrong with it; None if all suit.

        The index is None if there are too few or too many.
        """
        least = len(self.parameters)
        if len(arguments) < least or (len(arguments) > least and not self.is_open):
            count = "1 argument" if len(arguments) == 1 else f"{len(arguments)} arguments"
            return None, f"{self.name} cannot have {count}"
        for index, argument in enumerate(arguments):
            form, description = _WANTED[self._parameter(index)]
            head, bracket, _ = argument.partition("(")
            if not re.fullmatch(form, argument) or (bracket and head in PATTERNS):
                return index, f"{argument} is not {description}"
        return None

    def _parameter(self, index: int) -> ParameterKind:
        return self.parameters[min(index, len(self.parameters) - 1)]

    def proposition(self, index: int, argument: str) -> str | None:
        """The proposition that an argument stands for; None for a count."""
        match self._parameter(index):
            case ParameterKind.PLACE:
                return f"{AT}({argument})"
            case ParameterKind.CONDITION:
                return argument
            case ParameterKind.COUNT:
                return None

    def expansion(self, arguments: Sequence[str]) -> str:
        """The text of the formula that the pattern stands for; the arguments must be suitable."""
        meant = (self.proposition(i, argument) or argument for i, argument in enumerate(arguments))
        return " & ".join(f"({conjunct})" for conjunct in self.conjuncts(*meant))


def _visit(*places: str) -> list[str]:
    return [f"F {a}" for a in places]


def _sequenced_visit(*places: str) -> list[str]:
    *earlier, last = places
    text = f"F {last}"
    for a in reversed(earlier):
        text = f"F({a} & {text})"
    return [text]


def _in_order(*places: str) -> list[str]:
    """The first visit of each place comes before that of the next one."""
    return [f"!{b} U {a}" for a, b in pairwise(places)]


def _ordered_visit(*places: str) -> list[str]:
    return _sequenced_visit(*places) + _in_order(*places)


def _strict_ordered_visit(*places: str) -> list[str]:
    once = [f"!{a} U ({a} & X(!{a} U {b}))" for a, b in pairwise(places)]
    return _ordered_visit(*places) + once


def _taking_turns(*places: str) -> list[str]:
    """No place is visited again before the next place in the cycle."""
    return [f"G({a} -> X(!{a} W {b}))" for a, b in _circle(places)]


def _circle(places: Sequence[str]) -> list[tuple[str, str]]:
    return list(pairwise([*places, places[0]]))


def _fair_visit(*places: str) -> list[str]:
    return _visit(*places) + _taking_turns(*places)


def _patrolling(*places: str) -> list[str]:
    return [f"G F {a}" for a in places]


def _sequenced_patrolling(*places: str) -> list[str]:
    return [f"G {text}" for text in _sequenced_visit(*places)]


def _ordered_patrolling(*places: str) -> list[str]:
    not_again = [f"G({b} -> X(!{b} U {a}))" for a, b in _circle(places)]
    return _sequenced_patrolling(*places) + _in_order(*places) + not_again


def _strict_ordered_patrolling(*places: str) -> list[str]:
    once = [f"G({a} -> X(!{a} U {b}))" for a, b in pairwise(places)]
    return _ordered_patrolling(*places) + once


def _fair_patrolling(*places: str) -> list[str]:
    return _patrolling(*places) + _taking_turns(*places)


def _global_avoidance(*places: str) -> list[str]:
    return [f"G !{a}" for a in places]


def _at_least(a: str, count: int) -> str:
    text = f"F {a}"
    for _ in range(count - 1):
        text = f"F({a} & X {text})"
    return text


def _exactly(a: str, count: int) -> str:
    text = f"!{a} U ({a} & X G !{a})"
    for _ in range(count - 1):
        text = f"!{a} U ({a} & X({text}))"
    return text


_PLACE, _CONDITION, _COUNT = ParameterKind
_PLACES = (_PLACE, _PLACE)
_REACTION = (_CONDITION, _CONDITION)

PATTERNS = {
    pattern.name: pattern
    for pattern in (
        Pattern("visit", _PLACES, _visit, is_open=True),
        Pattern("sequenced_visit", _PLACES, _sequenced_visit, is_open=True),
        Pattern("ordered_visit", _PLACES, _ordered_visit, is_open=True),
        Pattern("strict_ordered_visit", _PLACES, _strict_ordered_visit, is_open=True),
        Pattern("fair_visit", _PLACES, _fair_visit, is_open=True),
        Pattern("patrolling", _PLACES, _patrolling, is_open=True),
        Pattern("sequenced_patrolling", _PLACES, _sequenced_patrolling, is_open=True),
        Pattern("ordered_patrolling", _PLACES, _ordered_patrolling, is_open=True),
        Pattern("strict_ordered_patrolling", _PLACES, _strict_ordered_patrolling, is_open=True),
        Pattern("fair_patrolling", _PLACES, _fair_patrolling, is_open=True),
        Pattern("past_avoidance", (_PLACE, _CONDITION), lambda a, p: [f"!{a} U {p}"]),
        Pattern("global_avoidance", (_PLACE,), _global_avoidance, is_open=True),
        Pattern("future_avoidance", (_CONDITION, _PLACE), lambda c, a: [f"G({c} -> G !{a})"]),
        Pattern(
            "upper_restricted_avoidance",
            (_PLACE, _COUNT),
            lambda a, n: [f"!{_at_least(a, int(n) + 1)}"],
        ),
        Pattern(
            "lower_restricted_avoidance", (_PLACE, _COUNT), lambda a, n: [_at_least(a, int(n))]
        ),
        Pattern("exact_restricted_avoidance", (_PLACE, _COUNT), lambda a, n: [_exactly(a, int(n))]),
        Pattern("instantaneous_reaction", _REACTION, lambda p, q: [f"G({p} -> {q})"]),
        Pattern("delayed_reaction", _REACTION, lambda p, q: [f"G({p} -> F {q})"]),
        Pattern("prompt_reaction", _REACTION, lambda p, q: [f"G({p} -> X {q})"]),
        Pattern("bound_reaction", _REACTION, lambda p, q: [f"G({p} <-> {q})"]),
        Pattern("bound_delay", _REACTION, lambda p, q: [f"G({p} <-> X {q})"]),
        Pattern("wait", (_PLACE, _CONDITION), lambda a, p: [f"{a} U {p}"]),
    )
}
"""All patterns, by the name that formulas use."""
