"""Debian's Chromium, driven by Playwright."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import LIMIT_S, Open, Watched, replayed
from playwright.sync_api import Browser, ViewportSize, sync_playwright
from two_docks import between_docks, two_docks

from companion import load_mission, simulate

NIGHT_WATCH = Path(__file__).parents[2] / "missions" / "night_watch.yaml"
TASK = {"patrol": "patrolling(A, B)", "look": "G (smoke -> F at(Home))"}
CHROMIUM = shutil.which("chromium")


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:  # a contributor may do without; CI installs it, so there it is a fault
        give_up = pytest.fail if os.environ.get("CI") else pytest.skip
        give_up("needs a browser: apt install chromium")
    with sync_playwright() as playwright:
        # Without its sandbox, which root cannot have: it opens no page but ours.
        yield playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox"], timeout=1000 * LIMIT_S
        )


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Open]:
    pages = []

    def open_(
        origin: str, width: int = 1440, height: int = 900, has_touch: bool = False
    ) -> Watched:
        window: ViewportSize = {"width": width, "height": height}
        watched = Watched(browser.new_page(viewport=window, has_touch=has_touch), origin)
        watched.page.set_default_timeout(1000 * LIMIT_S)
        pages.append(watched)
        watched.look()
        return watched

    yield open_
    for watched in pages:
        watched.page.close()
        assert watched.faults == []


@pytest.fixture(scope="module")
def recorded(surveillance_run: Path) -> Iterator[str]:
    """The address of a replay; one for all tests, as a page changes nothing of it."""
    with replayed(surveillance_run) as address:
        yield address


@pytest.fixture
def watch_recorded(tmp_path: Path) -> Iterator[str]:
    """The address of a replay of a flight that drops a line of its task, and takes it up again."""
    simulate(load_mission(NIGHT_WATCH), folder=tmp_path / "run", limit_s=68)
    with replayed(tmp_path / "run") as address:
        yield address


@pytest.fixture(scope="session")
def charging_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a flight that charges, and then has to plan anew; to be read only."""
    folder = tmp_path_factory.mktemp("charging") / "run"
    mission = load_mission(two_docks(events={"smoke": {"when": "EVENT[smoke] > 0"}}, task=TASK))
    scenario = between_docks({"at_s": 40, "report": {"smoke": 1}}, charge=0.242)
    simulate(mission, scenario, folder=folder, limit_s=70)
    return folder
