"""Finds installed functions by their entry points, and loads them, only in a process of its own.

Loading runs code of the package that offers the function. Searching reads the metadata of all that
is installed, which takes up to a second.
"""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from companion.skills.authoring import MARK, FunctionKind
from companion.skills.calls import Function

_DECORATORS = {
    FunctionKind.SKILL: "@skill",
    FunctionKind.SUGGESTER: "@suggester",
    FunctionKind.PLACE_TEST: "@place_test",
}


class Unusable(Exception):
    """The function cannot be called; the text says why."""


def entries() -> list[tuple[Function, EntryPoint]]:
    """All installed functions."""
    found = entry_points()
    return [
        (Function(kind, e.name), e) for kind in FunctionKind for e in found.select(group=kind.value)
    ]


def source_of(entry: EntryPoint) -> str:
    """The package that offers the function, and its version."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist is not None else entry.module


def loaded(function: Function) -> Callable[..., Any]:
    """The function itself.

    Raises:
        Unusable: no package or several packages offer it, it cannot be imported, or it is no
            function.
    """
    named = [entry for each, entry in entries() if each == function]
    if len(named) != 1:
        raise Unusable("it is not installed" if not named else "two packages claim its name")
    return load(function, named[0])


def load(function: Function, entry: EntryPoint) -> Callable[..., Any]:
    """The function of an entry point.

    Raises:
        Unusable: it cannot be imported, or is not a function.
    """
    try:
        found = entry.load()
    except BaseException as error:  # whatever foreign code raises, even SystemExit
        traceback.print_exc()
        raise Unusable(f"{entry.value} cannot be imported: {in_words(error)}") from error
    if not callable(found):
        raise Unusable(f"{entry.value} is not a function")
    if getattr(found, MARK, None) != function.kind.value:
        raise Unusable(f"{entry.value} is not marked with {_DECORATORS[function.kind]}")
    is_generator = (
        inspect.isgeneratorfunction(found) and function.kind is not FunctionKind.SUGGESTER
    )
    if inspect.iscoroutinefunction(found) or inspect.isasyncgenfunction(found) or is_generator:
        raise Unusable(f"{entry.value} has to be a plain function, without async or yield")
    return found  # type: ignore[no-any-return]


def in_words(error: BaseException) -> str:
    """An exception in one line: its type, and the last line of its text."""
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[-1].strip()}" if lines else type(error).__name__
