"""Pictures of flights are drawn only where a test looks at one: each takes as long as a flight."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from companion.flights import run_folders
from companion.record import drawing, figure

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


@contextmanager
def truly_drawn() -> Iterator[None]:
    """Pictures are drawn meanwhile."""
    with pytest.MonkeyPatch.context() as patched:
        for (module, name), draw in _TRUE.items():
            patched.setattr(module, name, draw)
        yield
