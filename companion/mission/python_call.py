"""Reads the step `python(name, arguments)`, a call of a function of an installed package.

An argument is one of: the name of a parameter of the skill, of a place or of an object; a number;
true or false; a text in quotes. Arguments are given by position or by name, as in Python.
installed_calls.py checks that the function is installed and accepts them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

from lark import Token

from companion.documents import did_you_mean
from companion.errors import FormulaError, KeyPath, Location, MissionError
from companion.mission.calls import WrittenCall, read_call
from companion.skills.authoring import FunctionKind
from companion.skills.calls import Call, Function, Value

PYTHON = "python"
FORM = "python(name, arguments)"
_TRUTHS = {"true": True, "True": True, "false": False, "False": False}
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


def parse_python(text: str, kind: FunctionKind) -> PythonCall:
    """Reads the text of a call, as `python_call` does.

    >>> parse_python("python(weigh, r, limit_kg=2.5)", FunctionKind.SKILL).call.text
    'python(weigh, r, limit_kg=2.5)'

    Raises:
        FormulaError: it is no such call.
    """
    otherwise, forms = "not a call of a function", {PYTHON: FORM}
    call = read_call(text, otherwise, forms)
    if call.name != PYTHON:
        raise FormulaError(otherwise, text, 0, len(text), f"write {FORM}")
    return python_call(call, {}, kind)


def python_call(
    call: WrittenCall, components: Mapping[str, int], kind: FunctionKind = FunctionKind.SKILL
) -> PythonCall:
    """The call of a function; the meaning of its names is checked elsewhere.

    Args:
        call: the step, as it is written.
        components: name -> MAVLink component id.
        kind: the purpose of the function.

    Raises:
        FormulaError: it names no function, or has arguments that Python would not accept.
    """
    if not call.arguments:
        raise call.error(call.name, "nothing is not the name of a function", f"write {FORM}")
    function, *given = call.arguments
    if function.name is not None or function.value.type not in ("NAME", "DOTTED"):
        what = f"{function.value} is not the name of a function"
        raise call.error(function.value, what, f"write {FORM}")
    arguments: list[Argument] = []
    keywords: dict[str, Argument] = {}
    for argument in given:
        value, name = _argument(argument.value, call), argument.name
        if name is None and keywords:
            hint = "arguments by name come last, as in Python"
            raise call.error(argument.value, f"{argument.value} has no name", hint)
        if name is None:
            arguments.append(value)
        elif name in keywords:
            raise call.error(name, f"{name} is given twice", "remove one of them")
        else:
            keywords[str(name)] = value
    return PythonCall(
        Function(kind, str(function.value)),
        tuple(arguments),
        tuple(keywords.items()),
        tuple(components.items()),
    )


def _argument(word: Token, call: WrittenCall) -> Argument:
    match word.type:
        case "TEXT":
            return str(word[1:-1])
        case "NAME":
            return _TRUTHS.get(word, Named(str(word)))
        case "INTEGER":
            return int(word)
        case "DECIMAL" if math.isfinite(float(word)):
            return float(word)
    hint = "write a name, a number such as 1.5, true, false, or a text in quotes"
    raise call.error(word, f"{word} is not an argument", hint)


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
        what = f"{word} is not a parameter of {of_what}, place or object"
        raise MissionError(what, where, hint)
