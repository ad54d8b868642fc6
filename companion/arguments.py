"""Checks arguments of functions, and says in words what is wrong with them.

For the functions that Python programs call; `documents` reads files.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import TypeVar

from companion.errors import CompanionError, RequestError


def check_kind(value: object, kinds: type | tuple[type, ...], expected: str) -> None:
    """Refuses an argument of a wrong type.

    >>> check_kind("hall.yaml", int, "a number")
    Traceback (most recent call last):
    companion.errors.CompanionError: expected a number, and this is of type str

    Args:
        value: the argument.
        kinds: the allowed types.
        expected: the allowed types, in words.

    Raises:
        CompanionError: it has none of these types.
    """
    if not isinstance(value, kinds):
        raise CompanionError(f"expected {expected}, and this is of type {type(value).__name__}")


def check_function(value: object, argument: str) -> None:
    """Refuses an argument that is not a function.

    Args:
        value: what was given.
        argument: its name.

    Raises:
        CompanionError: it is not callable.
    """
    if not callable(value):
        kind = type(value).__name__
        raise CompanionError(f"expected a function as {argument}, and this is of type {kind}")


def names_of(given: object, kind: str) -> frozenset[str]:
    """The names in an argument, which must not be a single string.

    >>> sorted(names_of(["b", "a"], "places"))
    ['a', 'b']

    Args:
        given: the argument.
        kind: what the names stand for.

    Raises:
        CompanionError: it is a single string, or contains something else than strings.
    """
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise CompanionError(
            f"expected names of {kind}, and this is of type {type(given).__name__}"
        )
    names = list(given)
    for name in names:
        check_kind(name, str, f"names of {kind}")
    return frozenset(names)


def check_wait(timeout_s: object) -> None:
    """Refuses a `timeout_s` that is not a number of seconds, 0 or more.

    Raises:
        CompanionError: it is no such number.
    """
    check_kind(timeout_s, (int, float), "a timeout_s in seconds")
    if isinstance(timeout_s, int | float) and not timeout_s >= 0:
        raise CompanionError(
            f"a timeout_s of {timeout_s:g} s is not a time to wait; give 0 or more"
        )


def path_of(given: object, expected: str) -> Path:
    r"""The path in an argument, which may be a string.

    >>> path_of("a\0b", "the path of a folder")
    Traceback (most recent call last):
    companion.errors.CompanionError: expected the path of a folder, and no file is called 'a\x00b'

    Args:
        given: the argument.
        expected: what it must be, in words.

    Raises:
        CompanionError: it is no path, or one that no system accepts.
    """
    if not isinstance(given, str | Path):
        raise CompanionError(f"expected {expected}, and this is of type {type(given).__name__}")
    try:
        is_possible = b"\0" not in os.fsencode(given)
    except UnicodeEncodeError:
        is_possible = False
    if not is_possible:
        raise CompanionError(f"expected {expected}, and no file is called {str(given)!r}")
    return Path(given)


E = TypeVar("E", bound=StrEnum)


def named(kind: type[E], name: str, argument: str) -> E:
    """The value with a name, for an argument that must be one of a few names.

    >>> named(StrEnum("Meal", ["LUNCH", "DINNER"]), "lunch", "meal").name
    'LUNCH'

    Args:
        kind: the values.
        name: the name of one value.
        argument: its name.

    Raises:
        RequestError: no value has this name.
    """
    if name not in [each.value for each in kind]:
        raise RequestError(f"no {argument} {name!r}; there are {', '.join(kind)}")
    return kind(name)
