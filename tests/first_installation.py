"""Child processes that find what `scripts/fly` installs, and nothing that only the tests need."""

from __future__ import annotations

import subprocess
import textwrap
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
PROJECT = "mav-companion"
HIDING = """
    from importlib.machinery import PathFinder

    hidden, found = {names!r}, PathFinder.find_spec

    def find_spec(name, path=None, target=None):
        return None if name.partition(".")[0] in hidden else found(name, path, target)

    PathFinder.find_spec = staticmethod(find_spec)
"""
"""A module that Python runs at its start if it is called sitecustomize."""


def shown_extras() -> frozenset[str]:
    """The extras that scripts/fly installs."""
    script = f"source '{ROOT}/scripts/_venv.sh' && echo \"$shown\""
    said = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True).stdout
    return frozenset(said.strip().split(","))


def distributions(extras: Iterable[str]) -> frozenset[str]:
    """What pip installs for the project with some extras, by its metadata alone."""
    found: set[str] = set()
    asked = [(PROJECT, frozenset(extras))]
    done: set[tuple[str, frozenset[str]]] = set()
    while asked:
        done.add(next_one := asked.pop())
        name, wanted = next_one
        try:
            lines = requires(name) or []
        except PackageNotFoundError:  # for another platform
            continue
        found.add(name)
        for requirement in map(Requirement, lines):
            marker = requirement.marker
            if marker is None or any(marker.evaluate({"extra": e}) for e in ("", *wanted)):
                needed = (canonicalize_name(requirement.name), frozenset(requirement.extras))
                asked += [] if needed in done else [needed]
    return frozenset(found)


@cache
def owners_of_modules() -> Mapping[str, list[str]]:
    """What brings each module that is installed here; this takes a second."""
    return packages_distributions()


def hidden_modules(extras: Iterable[str]) -> frozenset[str]:
    """Modules that are installed here for the tests, and are not with these extras alone."""
    missing = distributions(["test"]) - distributions(extras)
    return frozenset(
        module
        for module, owners in owners_of_modules().items()
        if missing.issuperset(map(canonicalize_name, owners))
    )


def environment(
    folder: Path, extras: Iterable[str] | None = None, more: str = ""
) -> dict[str, str]:
    """Variables with which a Python finds the extras alone, of scripts/fly if none are named.

    Args:
        folder: for the module that hides all else.
        extras: what is found.
        more: what Python executes at its start besides.
    """
    folder.mkdir(exist_ok=True)
    names = sorted(hidden_modules(shown_extras() if extras is None else extras))
    text = textwrap.dedent(HIDING).format(names=set(names)) + more
    (folder / "sitecustomize.py").write_text(text, encoding="utf-8")
    return {"PYTHONPATH": str(folder)}
