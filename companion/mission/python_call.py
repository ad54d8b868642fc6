"""Reads the step `python(name, arguments)`, a call of a function of an installed package.

An argument is one of: the name of a parameter of the skill, of a place or of an object; a number;
true or false; a text in quotes. Arguments are given by position or by name, as in Python.
installed_calls.py checks that the function is installed and accepts them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

from companion.documents import did_you_mean
from companion.errors import FormulaError, KeyPath, Location, MissionError
from companion.skills.authoring import FunctionKind
from companion.skills.calls import Call, Function, Value

FORM = "python(name, arguments)"
MAX_ARGUMENTS = 50


@dataclass(frozen=True, slots=True)
class Named:
    """An argument that is a parameter of the skill, or the name of a place or an object."""

    word: str


Argument: TypeAlias = "Value | Named"


@dataclass(frozen=True, slots=True)
class PythonCall:
    """Primitive: call a function of an installed package, and wait until it ends.

    Attributes:
        keywords: arguments by name.
        components: the mission's components, whose names the function may use in commands.
    """

    function: Function
    arguments: tuple[Argument, ...] = ()
    keywords: tuple[tuple[str, Argument], ...] = ()
    components: tuple[tuple[str, int], ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """The arguments that are parameters, places or objects."""
        given = (*self.arguments, *(argument for _, argument in self.keywords))
        return frozenset(argument.word for argument in given if isinstance(argument, Named))

    def bound(self, binding: Mapping[str, str]) -> PythonCall:
        """The call with the skill's parameters bound."""

        def of(argument: Argument) -> Argument:
            if not isinstance(argument, Named):
                return argument
            return Named(binding.get(argument.word, argument.word))

        keywords = tuple((name, of(argument)) for name, argument in self.keywords)
        return replace(self, arguments=tuple(map(of, self.arguments)), keywords=keywords)

    @property
    def call(self) -> Call:
        """The call to make, once all parameters are bound."""
        return Call(
            self.function,
            tuple(map(_value, self.arguments)),
            tuple((name, _value(argument)) for name, argument in self.keywords),
        )


def _value(argument: Argument) -> Value:
    return argument.word if isinstance(argument, Named) else argument


_CALL = re.compile(r"\s*python\s*\((?P<arguments>.*)\)\s*", re.ASCII | re.DOTALL)
_ARGUMENT = re.compile(
    r"\s*(?:(?P<name>[A-Za-z_]\w*)\s*=\s*)?"
    r"""(?P<value>"[^"]*"|'[^']*'|[^\s,()"'=]+)\s*(?:,|$)""",
    re.ASCII,
)
_FUNCTION = re.compile(r"[A-Za-z_]\w*(?:[.-]\w+)*", re.ASCII)
_WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_INTEGER = re.compile(r"[-+]?\d{1,15}", re.ASCII)


def parse_python(
    text: str, components: Mapping[str, int] | None = None, kind: FunctionKind = FunctionKind.SKILL
) -> PythonCall:
    """Reads a call; the meaning of its names is checked elsewhere.

    >>> parse_python("python(weigh, r, limit_kg=2.5)").call.text
    'python(weigh, r, limit_kg=2.5)'

    Args:
        text: the step.
        components: name -> MAVLink component id.
        kind: the purpose of the function.

    Raises:
        FormulaError: it is no such call.
    """
    match = _CALL.fullmatch(text)
    if match is None:
        raise FormulaError("not a call of a function", text, 0, len(text), f"write {FORM}")
    (function, name, at), *given = _arguments(match) or [("", None, match.start("arguments"))]
    if name is not None or not _FUNCTION.fullmatch(function):
        what = f"{function or 'nothing'} is not the name of a function"
        raise FormulaError(what, text, at, max(1, len(function)), f"write {FORM}")
    arguments: list[Argument] = []
    keywords: dict[str, Argument] = {}
    for word, name, at in given:
        argument = _argument(word, text, at)
        if name is None and keywords:
            hint = "arguments by name come last, as in Python"
            raise FormulaError(f"{word} has no name", text, at, len(word), hint)
        if name is None:
            arguments.append(argument)
        elif name in keywords:
            raise FormulaError(f"{name} is given twice", text, at, len(word), "remove one of them")
        else:
            keywords[name] = argument
    named = tuple(keywords.items())
    return PythonCall(
        Function(kind, function), tuple(arguments), named, tuple((components or {}).items())
    )


def _arguments(match: re.Match[str]) -> list[tuple[str, str | None, int]]:
    """The arguments as written, each with its name and offset."""
    text, at, end = match.string, match.start("arguments"), match.end("arguments")
    found: list[tuple[str, str | None, int]] = []
    while text[at:end].strip():
        argument = _ARGUMENT.match(text, at, end)
        if argument is None:
            hint = "write names, numbers, true, false, or texts in quotes, with commas between"
            at += len(text[at:end]) - len(text[at:end].lstrip())
            raise FormulaError("not an argument", text, at, 1, hint)
        found.append((argument["value"], argument["name"], argument.start("value")))
        at = argument.end()
    return found


def _argument(word: str, text: str, at: int) -> Argument:
    if word[0] in "\"'":
        return word[1:-1]
    if word in ("true", "false", "True", "False"):
        return word in ("true", "True")
    if _INTEGER.fullmatch(word):
        return int(word)
    if _WORD.fullmatch(word):
        return Named(word)
    try:
        number = float(word)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        hint = "write a name, a number such as 1.5, true, false, or a text in quotes"
        raise FormulaError(f"{word} is not an argument", text, at, len(word), hint)
    return number


def check_names(
    step: PythonCall, of_what: str, known: Collection[str], where: Location | KeyPath
) -> None:
    """Refuses a name that does not exist in the mission.

    Args:
        of_what: what contains the call, e.g. the name of a skill.
        known: parameters, places and objects.
        where: place of the call.

    Raises:
        MissionError: at the first such name.
    """
    for word in sorted(step.names - {*known}):
        hint = f"{did_you_mean(word, sorted(known))} A text stands in quotes.".lstrip()
        what = f"{word} is no parameter of {of_what}, place or object"
        raise MissionError(what, where, hint)
