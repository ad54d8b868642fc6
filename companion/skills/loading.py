"""Finds installed functions by their entry points, and loads one: in a process of its own alone.

Loading runs the code of the package that claims the name. A search reads the metadata of all that
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
    """The function cannot be called; its text says why."""


def entries() -> list[tuple[Function, EntryPoint]]:
    """All that is installed."""
    found = entry_points()
    return [
        (Function(kind, e.name), e) for kind in FunctionKind for e in found.select(group=kind.value)
    ]


def source_of(entry: EntryPoint) -> str:
    """The package that claims the name, and its version."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist is not None else entry.module


def loaded(function: Function) -> Callable[..., Any]:
    """The function itself.

    Raises:
        Unusable: nobody or more than one claims its name, it cannot be imported, or it is none.
    """
    named = [entry for each, entry in entries() if each == function]
    if len(named) != 1:
        raise Unusable("it is not installed" if not named else "two packages claim its name")
    return load(function, named[0])


def load(function: Function, entry: EntryPoint) -> Callable[..., Any]:
    """The function of an entry point.

    Raises:
        Unusable: it cannot be imported, or it is none.
    """
    try:
        found = entry.load()
    except BaseException as error:  # whatever foreign code raises, SystemExit among it
        traceback.print_exc()
        raise Unusable(f"{entry.value} cannot be imported: {in_words(error)}") from error
    if not callable(found):
        raise Unusable(f"{entry.value} is no function")
    if getattr(found, MARK, None) != function.kind.value:
        raise Unusable(f"{entry.value} is not marked with {_DECORATORS[function.kind]}")
    is_generator = (
        inspect.isgeneratorfunction(found) and function.kind is not FunctionKind.SUGGESTER
    )
    if inspect.iscoroutinefunction(found) or inspect.isasyncgenfunction(found) or is_generator:
        raise Unusable(f"{entry.value} has to be a plain function, without async or yield")
    return found  # type: ignore[no-any-return]


def in_words(error: BaseException) -> str:
    """An exception in a line: its type, and the last line of what it says."""
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[-1].strip()}" if lines else type(error).__name__
