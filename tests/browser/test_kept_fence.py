"""A fence of somebody else that the autopilot keeps, on the page's map."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import Open, replayed

from companion.flight_events.event import Stamped
from companion.flight_events.fence import FenceKept
from companion.flight_events.writing import line_of

pytestmark = pytest.mark.sockets

KEPT = Stamped(
    2.0,
    FenceKept(
        "7 points, 2 areas",
        within=(((-1.0, -1.0), (-1.0, 30.0), (20.0, 30.0), (20.0, -1.0)),),
        keep_out=(((8.0, 8.0), (8.0, 10.0), (10.0, 10.0)),),
    ),
)


@pytest.fixture
def kept(surveillance_run: Path, tmp_path: Path) -> Iterator[str]:
    """The address of a replay of a flight that keeps to such a fence."""
    run = shutil.copytree(surveillance_run, tmp_path / "run")
    events = (run / "events.jsonl").read_text(encoding="utf-8").splitlines()
    at = next(i for i, line in enumerate(events) if json.loads(line)["t_s"] > KEPT.time_s)
    lines = [*events[:at], json.dumps(line_of(KEPT)), *events[at:]]
    (run / "events.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    with replayed(run) as address:
        yield address


def test_it_is_drawn_from_when_it_is_known(kept: str, open_page: Open) -> None:
    page = open_page(kept)
    page.until("document.querySelectorAll('.mark').length === 2")
    page.page.keyboard.press("End")
    page.until("document.querySelectorAll('.kept polygon').length === 2")
    zone = page.page.locator(".kept .keep_out").get_attribute("points")
    assert zone == "8,-8 10,-8 10,-10", "east, and north upwards"
    assert page.page.locator("#kept").is_visible()
    page.page.keyboard.press("Home")
    page.until("document.querySelectorAll('.kept polygon').length === 0")
    assert not page.page.locator("#kept").is_visible()
