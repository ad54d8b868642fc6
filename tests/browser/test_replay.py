"""A recorded run on the monitor page: the slider, the keys, and what is shown at each time."""

from __future__ import annotations

import pytest
from browsing import Open, Watched

pytestmark = pytest.mark.sockets


def time_of(replay: Watched) -> float:
    """Where the page is, seconds."""
    return float(replay.page.locator("#time").input_value())


def test_the_keyboard_is_enough(recorded: str, open_page: Open) -> None:
    replay = open_page(recorded)
    replay.until("document.querySelectorAll('.mark').length === 2")
    keys = replay.page.keyboard
    assert replay.texts("#play") == ["Pause"], "it plays"
    keys.press(" ")
    replay.until("document.querySelector('#play').textContent === 'Play'")
    keys.press("Home")
    replay.until("document.querySelector('#time').value < 0.1")
    keys.press("Shift+ArrowRight")
    keys.press("ArrowRight")
    keys.press("ArrowLeft")
    replay.until("Math.abs(document.querySelector('#time').value - 10) < 0.2")
    assert replay.texts(".step[aria-current]") == ["move(Home, A)"]
    here = replay.page.locator(".vehicle path").get_attribute("transform")
    for _ in range(4):
        keys.press("+")
    keys.press(" ")
    replay.until("document.querySelector('#time').value > 30")
    keys.press(" ")
    assert replay.page.locator(".vehicle path").get_attribute("transform") != here
    keys.press("End")
    replay.until("document.querySelector('#badge').textContent === 'ended'")
    assert time_of(replay) > 60
    replay.page.locator("#lines button", has_text="at B").focus()
    keys.press("Enter")
    replay.until("document.querySelector('#badge').textContent === 'replay'")
    assert replay.texts(".step[aria-current]") in (["move(A, B)"], ["move(B, C)"])


def test_a_branch_that_somebody_opened_stays_open(recorded: str, open_page: Open) -> None:
    replay = open_page(recorded)
    replay.until("document.querySelectorAll('.mark').length === 2")
    replay.page.keyboard.press(" ")
    replay.page.locator("#lines button", has_text="at A").first.click()
    branch = replay.page.locator("#tree details.action").nth(2)
    replay.until("document.querySelectorAll('#tree details.action').length === 4")
    assert branch.get_attribute("open") is None
    branch.locator("> summary").click()
    replay.page.keyboard.press("ArrowRight")
    replay.page.wait_for_timeout(200)
    assert branch.get_attribute("open") is not None


@pytest.mark.parametrize("width", [360, 900, 1440])
def test_it_fits_the_window_at_any_time(width: int, recorded: str, open_page: Open) -> None:
    replay = open_page(recorded, width=width, height=740)
    replay.until("document.querySelectorAll('.mark').length === 2")
    replay.page.keyboard.press(" ")
    for number in range(2):
        replay.page.locator(".mark").nth(number).click()
        replay.page.wait_for_timeout(100)
        assert replay.has_no_horizontal_scroll()
    for selector in ("#hall", "#time", "#lines", "#tree", "#automata"):
        box = replay.page.locator(selector).bounding_box()
        assert box and box["x"] >= 0 and box["x"] + box["width"] <= width, selector


def test_a_line_that_is_dropped_is_told_as_long_as_it_is(
    watch_recorded: str, open_page: Open
) -> None:
    replay = open_page(watch_recorded)
    replay.until("document.querySelector('#lines')?.innerText.includes('dock taken up again')")
    replay.page.keyboard.press(" ")
    told = "[...document.querySelectorAll('.conjunct[data-dropped] strong')].map(e => e.innerText)"
    replay.page.locator("#lines button", has_text="dock dropped: no plan keeps it").click()
    replay.until(f"{told}.join() === 'dock'")
    assert replay.page.locator("[data-dropped] .left-out").is_visible()
    replay.page.locator("#lines button", has_text="dock taken up again").click()
    replay.until(f"{told}.length === 0")
    assert not replay.page.locator(".conjunct .left-out").first.is_visible()
