"""Debian's Chromium, driven by Playwright."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator

import pytest
from browsing import Open, Watched
from playwright.sync_api import Browser, sync_playwright

CHROMIUM = shutil.which("chromium")


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        give_up = pytest.fail if os.environ.get("CI") else pytest.skip
        give_up("needs a browser: apt install chromium")
    with sync_playwright() as playwright:
        # Without its sandbox, which root cannot have: it opens no page but ours.
        yield playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Open]:
    pages = []

    def open_(origin: str, width: int = 1440, height: int = 900) -> Watched:
        watched = Watched(browser.new_page(viewport={"width": width, "height": height}), origin)
        pages.append(watched)
        watched.look()
        return watched

    yield open_
    for watched in pages:
        watched.page.close()
        assert watched.faults == []
