"""The program that lists the installed functions and their parameters.

    python -P -m companion.skills.description

A list of [group, name] on its standard input says which functions to load for their parameters. It
prints a line of JSON for each function at once, and one before it loads a function: so if loading
ends this process, the function's name is known. `installed.py` is the other side.
"""

from __future__ import annotations

import inspect
import json
import os
import sys
from collections.abc import Callable
from typing import Any

from companion.python_child import MIB, confine_memory
from companion.skills.authoring import FunctionKind
from companion.skills.catalogue import GIVEN, Installed, Parameter, as_json
from companion.skills.child import MEMORY_MIB
from companion.skills.loading import Unusable, entries, load, source_of


def parameters_of(kind: FunctionKind, function: Callable[..., Any]) -> tuple[Parameter, ...]:
    """The parameters of a function.

    Raises:
        Unusable: it lacks parameters that the companion fills in.
    """
    try:
        found = inspect.signature(function).parameters.values()
    except (TypeError, ValueError) as error:
        raise Unusable("its parameters are not known") from error
    by_position = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    if sum(each.kind in by_position for each in found) < GIVEN[kind]:
        wanted = ", ".join(("run", "place", "waypoint")[: GIVEN[kind]])
        raise Unusable(f"its first parameters have to be {wanted}")
    return tuple(map(_parameter, found))


def _parameter(found: inspect.Parameter) -> Parameter:
    empty = inspect.Parameter.empty
    annotation = "" if found.annotation is empty else found.annotation
    written = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    default = None if found.default is empty else repr(found.default)[:100]
    return Parameter(found.name, found.kind.name, default, written[:100])


def main() -> None:
    """Entry point; what a function prints while it is loaded is not taken for an answer."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    confine_memory(MEMORY_MIB * MIB)
    wanted = {tuple(each) for each in json.loads(sys.stdin.buffer.readline())}

    def say(value: Any) -> None:
        print(json.dumps(value), file=answers, flush=True)

    found = entries()
    for function, entry in found:
        say(as_json({function: [Installed(function, source_of(entry))]})[0])
    claimed = [function for function, _ in found]
    for function, entry in found:
        key = function.kind.value, function.name
        if key not in wanted or claimed.count(function) != 1:
            continue
        say({"loading": key})
        source = source_of(entry)
        try:
            parameters = parameters_of(function.kind, load(function, entry))
            installed = Installed(function, source, parameters)
        except Unusable as unusable:
            installed = Installed(function, source, failure=str(unusable))
        say(as_json({function: [installed]})[0])
    answers.flush()
    os._exit(0)  # whatever a package has started on import


if __name__ == "__main__":
    main()
