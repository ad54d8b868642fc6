"""Automata with many states on the page: all edges, labels in words, what was just taken."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import Open, replayed

pytestmark = pytest.mark.sockets

PATROL = "G F at(A) & G F at(B) & G F at(C) & G F at(r1) | F targetFound"
STATES = 8


@pytest.fixture
def address(surveillance_run: Path, tmp_path: Path) -> Iterator[str]:
    """Of a replay of a flight that is read with a task of many states."""
    run = shutil.copytree(surveillance_run, tmp_path / "run")
    path = run / "events.jsonl"
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    next(line for line in lines if line["kind"] == "plan")["task"] = {"patrol": PATROL}
    path.write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
    with replayed(run) as origin:
        yield origin


def test_many_states_stand_on_a_circle_with_their_edges(address: str, open_page: Open) -> None:
    replay = open_page(address)
    replay.until("document.querySelector('#lines')?.innerText.includes('satisfied, landed')")
    replay.page.locator("#play", has_text="Pause").click()
    replay.page.locator("#lines button", has_text="at A").first.click()
    replay.page.keyboard.press("ArrowRight")
    states = replay.page.locator(".large .state")
    assert states.count() == STATES
    assert replay.page.locator(".large .arrow:not(.entry)").count() == 30
    replay.until("document.querySelectorAll('.edges .taken').length > 0")
    assert "A (taken)" in " ".join(replay.texts(".edges .taken"))
    assert replay.violations() == []
    for n in range(STATES):
        states.nth(n).focus()
        told = replay.texts(".edges li:not(.taken)")
        assert told and all(text.startswith(f"{n} → ") for text in told), told
    replay.page.emulate_media(color_scheme="dark")
    replay.page.wait_for_timeout(300)  # colours change slowly
    assert replay.violations("color-contrast") == []
