"""Asks a child process which functions are installed; loads none in this process.

A door: it starts a process and waits for it. This is done once, before anything flies: when a
mission that calls a function is read, or when a companion begins to host sorties.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Any

from companion.python_child import python_module
from companion.skills.authoring import FunctionKind
from companion.skills.calls import Function
from companion.skills.catalogue import Catalogue, Installed, from_json

PROGRAM = "companion.skills.description"
LOADED_S = 60.0
"""Real time for loading all that is asked for."""

InstalledReader = Callable[[Iterable[Function]], Catalogue]
"""Returns what is installed; the named functions are loaded for their parameters."""


def read_installed(wanted: Iterable[Function]) -> Catalogue:
    """What is installed now, with the parameters of the wanted functions."""
    left = set(wanted)
    catalogue: dict[Function, Sequence[Installed]] = {}
    while True:
        lines = _answers(left)
        found = from_json([line for line in lines if "loading" not in line])
        for function, offers in found.items():
            known = [each for each in offers if each.parameters is not None or each.failure]
            before = catalogue.get(function, [])
            if known or not before:
                catalogue[function] = known or offers
            if known:
                left.discard(function)
        loading = lines[-1].get("loading") if lines else None
        if loading is None:
            return catalogue
        ended = Function(FunctionKind(loading[0]), str(loading[1]))
        failure = "its import has ended the process, or takes too long"
        catalogue[ended] = [
            Installed(each.function, each.source, failure=failure) for each in catalogue[ended]
        ]
        left.discard(ended)


def read_all() -> Catalogue:
    """All that is installed, with parameters."""
    return read_installed(read_installed(()))


def _answers(wanted: Iterable[Function]) -> list[dict[str, Any]]:
    order = json.dumps([[each.kind.value, each.name] for each in wanted]).encode() + b"\n"
    child = subprocess.Popen(
        python_module(PROGRAM),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        printed, _ = child.communicate(order, LOADED_S)
    except subprocess.TimeoutExpired:
        child.kill()
        printed, _ = child.communicate()
    lines = []
    for line in printed.splitlines():
        with suppress(ValueError):
            lines.append(json.loads(line))
    return lines
