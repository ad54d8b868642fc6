"""Arguments of functions, held against what they may be: what they are instead is told in words.

For the doors that Python programs call; what files say is read by `documents`.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import TypeVar

from companion.errors import CompanionError, RequestError


def check_kind(value: object, kinds: type | tuple[type, ...], expected: str) -> None:
    """Refuses an argument that is of another kind than a function takes.

    >>> check_kind("hall.yaml", int, "a number")
    Traceback (most recent call last):
    companion.errors.CompanionError: expected a number, and this is a str

    Args:
        value: what was given.
        kinds: what it may be.
        expected: that, in words.

    Raises:
        CompanionError: it is none of them.
    """
    if not isinstance(value, kinds):
        raise CompanionError(f"expected {expected}, and this is a {type(value).__name__}")


def check_function(value: object, argument: str) -> None:
    """Refuses an argument that is no function.

    Args:
        value: what was given.
        argument: what it is called.

    Raises:
        CompanionError: it cannot be called.
    """
    if not callable(value):
        kind = type(value).__name__
        raise CompanionError(f"expected a function as {argument}, and this is a {kind}")


def names_of(given: object, kind: str) -> frozenset[str]:
    """The names in an argument, which is not one text by itself.

    >>> sorted(names_of(["b", "a"], "places"))
    ['a', 'b']

    Args:
        given: the argument.
        kind: what is named.

    Raises:
        CompanionError: it is one text, or something in it is none.
    """
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise CompanionError(f"expected names of {kind}, and this is a {type(given).__name__}")
    names = list(given)
    for name in names:
        check_kind(name, str, f"names of {kind}")
    return frozenset(names)


def check_wait(timeout_s: object) -> None:
    """Refuses an argument timeout_s that is no number of seconds to wait, 0 or more.

    Raises:
        CompanionError: it is none.
    """
    check_kind(timeout_s, (int, float), "a timeout_s in seconds")
    if isinstance(timeout_s, int | float) and not timeout_s >= 0:
        raise CompanionError(f"a timeout_s of {timeout_s:g} s is none to wait; 0 or more")


def path_of(given: object, expected: str) -> Path:
    r"""The path that an argument is, or that is written in it.

    >>> path_of("a\0b", "the path of a folder")
    Traceback (most recent call last):
    companion.errors.CompanionError: expected the path of a folder, and no file is called 'a\x00b'

    Args:
        given: the argument.
        expected: what it may be, in words.

    Raises:
        CompanionError: it is no path, or one that no system takes.
    """
    if not isinstance(given, str | Path):
        raise CompanionError(f"expected {expected}, and this is a {type(given).__name__}")
    try:
        is_possible = b"\0" not in os.fsencode(given)
    except UnicodeEncodeError:
        is_possible = False
    if not is_possible:
        raise CompanionError(f"expected {expected}, and no file is called {str(given)!r}")
    return Path(given)


E = TypeVar("E", bound=StrEnum)


def named(kind: type[E], name: str, argument: str) -> E:
    """The value of a name, in an argument that may be one of a few.

    >>> named(StrEnum("Meal", ["LUNCH", "DINNER"]), "lunch", "meal").name
    'LUNCH'

    Args:
        kind: the values.
        name: of one of them.
        argument: what it is called.

    Raises:
        RequestError: there is none of that name.
    """
    if name not in [each.value for each in kind]:
        raise RequestError(f"no {argument} {name!r}; there are {', '.join(kind)}")
    return kind(name)
