"""Altitude, speed, battery and clearance over time: what they show, and their place in time."""

from __future__ import annotations

import pytest
from browsing import Open

pytestmark = pytest.mark.sockets

NOW = "document.querySelector('#curves .now').getAttribute('x1')"
SHARE = "(({ value, max }) => value / max)(document.querySelector('#time'))"
EXTENTS = """[...document.querySelectorAll('#curves .measured')].map(
    path => path.getBBox()).map(({ width, height }) => [width, height])"""


@pytest.mark.parametrize("width", [360, 768])
def test_four_curves_go_with_the_slider(width: int, recorded: str, open_page: Open) -> None:
    replay = open_page(recorded, width=width, height=740)
    replay.until("document.querySelector('#lines')?.innerText.includes('landed')")
    replay.page.keyboard.press(" ")
    replay.page.locator(".mark").nth(1).click()
    replay.until("document.querySelectorAll('#curves .strip:first-of-type .replan').length === 8")
    figures = ("altitude 2.0 m", "speed ", "battery 97 %", "clearance 1.9 m")
    assert replay.comes_true(
        lambda: all(map(str.startswith, replay.texts("#curves figcaption"), figures))
    )
    for across, high in replay.page.evaluate(EXTENTS):
        assert width / 4 < across < width and high > 0.5
    before = replay.page.evaluate(NOW)
    replay.page.keyboard.press("Shift+ArrowLeft")
    assert replay.comes_true(lambda: float(replay.page.evaluate(NOW)) < float(before))
    box = replay.page.locator("#curves .strip").last.bounding_box()
    assert box
    replay.page.locator("#curves .strip").last.click(position={"x": box["width"] / 2, "y": 20})
    replay.until(f"Math.abs({SHARE} - 0.4) < 0.12")
    assert replay.has_no_horizontal_scroll()
