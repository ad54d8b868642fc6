"""Pictures of flights are drawn only where a test looks at one: each takes as long as a flight."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from companion.flights import run_folders
from companion.record import drawing, figure

UNDRAWN = """
import os, sys
from types import ModuleType

if "companion.record.drawing" in sys.orig_argv:  # the child that would draw
    os._exit(0)
sys.modules["companion.record.figure"] = figure = ModuleType("figure")
figure.draw_flight = lambda backdrop, trail, path: None
"""
"""The same for a program: a module that Python runs at its start if it is called sitecustomize."""

_TRUE = {
    (figure, "draw_flight"): figure.draw_flight,
    (run_folders, "draw_in_child"): drawing.draw_in_child,
    (run_folders, "draw_record_in_child"): drawing.draw_record_in_child,
}


def _empty(backdrop: object, trail: object, path: Path) -> None:
    """A file in place of the picture."""
    path.write_bytes(b"")


@contextmanager
def not_drawn() -> Iterator[None]:
    """In place of each picture of a run is an empty file."""
    with pytest.MonkeyPatch.context() as patched:
        for module, name in _TRUE:
            patched.setattr(module, name, _empty)
        yield


def programs_do_not_draw(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The programs that a test starts do not draw their runs.

    Args:
        folder: for the module that sees to it.
    """
    (folder / "sitecustomize.py").write_text(UNDRAWN, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)


@contextmanager
def truly_drawn() -> Iterator[None]:
    """Pictures are drawn meanwhile."""
    with pytest.MonkeyPatch.context() as patched:
        for (module, name), draw in _TRUE.items():
            patched.setattr(module, name, draw)
        yield
