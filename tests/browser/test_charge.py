"""The charge over time on the page: measured, planned, required, charges and replans."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import Open, Watched, replayed

pytestmark = pytest.mark.sockets

STRIP = "#charge-strip"
KINDS = ("measured", "planned", "required", "reserve", "charging", "replan", "now")
LENGTHS = """[...document.querySelectorAll('#charge-strip polyline.planned:not(.ahead)')].map(
    line => line.points.numberOfItems)"""


@pytest.fixture(scope="module")
def charging(charging_run: Path) -> Iterator[str]:
    """The address of a replay of a flight that charges."""
    with replayed(charging_run) as address:
        yield address


def at_the_end(replay: Watched) -> None:
    """The whole flight is read, and the page stands at its end."""
    replay.until("document.querySelector('#lines')?.innerText.includes('70 s flown, landed')")
    replay.page.keyboard.press(" ")
    replay.page.keyboard.press("End")
    replay.until("document.querySelector('#badge').textContent === 'ended'")


def count(replay: Watched, kind: str) -> int:
    return replay.page.locator(f"{STRIP} .{kind}").count()


@pytest.mark.parametrize("width", [360, 1440])
def test_all_of_it_is_there_and_fits(width: int, charging: str, open_page: Open) -> None:
    replay = open_page(charging, width=width, height=740)
    at_the_end(replay)
    assert all(count(replay, kind) for kind in KINDS), [count(replay, kind) for kind in KINDS]
    assert not count(replay, "ahead"), "nothing is planned any more"
    assert replay.page.locator(f"{STRIP} .number").all_text_contents() == ["1"]
    legend = replay.texts("#charge .legend li")
    assert legend == ["measured", "planned at least", "required", "reserve", "charging", "replan"]
    assert replay.has_no_horizontal_scroll()
    box = replay.page.locator(STRIP).bounding_box()
    assert box and box["x"] >= 0 and box["x"] + box["width"] <= width
    for text in replay.page.locator(f"{STRIP} text").all():
        inner = text.bounding_box()
        assert inner and box["x"] <= inner["x"] and inner["x"] + inner["width"] <= width
    assert replay.page.locator("#hall").bounding_box()["height"] > 100  # type: ignore[index]


def test_a_full_battery_can_be_read(charging: str, open_page: Open) -> None:
    replay = open_page(charging)
    at_the_end(replay)
    left_px = replay.page.evaluate("""() => {
        const text = document.querySelector('#charge-strip .percent');
        text.textContent = '100 %';
        return text.getBBox().x;
    }""")
    assert left_px >= 0


def test_it_is_what_was_known_at_that_time(charging: str, open_page: Open) -> None:
    """Back before the first charge there is a plan ahead, and no charge yet."""
    replay = open_page(charging)
    at_the_end(replay)
    charges = count(replay, "charging")
    replay.page.locator("#lines button", has_text="at E").first.click()
    replay.until("document.querySelectorAll('#charge-strip .planned.ahead').length === 1")
    assert count(replay, "charging") == 0 and count(replay, "replan") == 0
    assert replay.page.evaluate(LENGTHS) == [2], "Home and E"
    said = replay.page.locator("#charge-said").inner_text()
    assert "after recharge(E) at least" in said and "% required at the last position" in said
    replay.page.keyboard.press("End")
    replay.until(f"document.querySelectorAll('#charge-strip .charging').length === {charges}")


def test_keys_and_the_pointer_lead_through_it(charging: str, open_page: Open) -> None:
    replay = open_page(charging)
    at_the_end(replay)
    box = replay.page.locator(STRIP).bounding_box()
    assert box
    replay.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + 60)
    share = "(({ value, max }) => value / max)(document.querySelector('#time'))"
    replay.until(f"Math.abs({share} - 0.5) < 0.05")
    summary = replay.page.locator("#charge summary")
    summary.focus()
    replay.page.keyboard.press("Enter")
    replay.until("!document.querySelector('#charge details').open")
    assert summary.is_visible() and not replay.page.locator(STRIP).is_visible()
    replay.page.wait_for_timeout(300)
    assert not replay.page.evaluate("document.querySelector('#charge details').open"), "it stays so"
    replay.page.keyboard.press("Enter")
    replay.until("document.querySelector('#charge details').open")
    where = replay.page.locator(f"{STRIP} .now").get_attribute("x1")
    replay.page.keyboard.press("ArrowRight")
    assert replay.comes_true(
        lambda: replay.page.locator(f"{STRIP} .now").get_attribute("x1") != where
    )


def test_dark_lines_are_not_those_of_the_light_page(charging: str, open_page: Open) -> None:
    replay = open_page(charging)
    at_the_end(replay)
    stroke = f"getComputedStyle(document.querySelector('{STRIP} .measured')).stroke"
    light = replay.page.evaluate(stroke)
    replay.page.emulate_media(color_scheme="dark")
    assert replay.comes_true(lambda: replay.page.evaluate(stroke) != light)


def test_without_a_battery_in_the_mission_its_curve_is_enough(
    recorded: str, open_page: Open
) -> None:
    replay = open_page(recorded)
    replay.until("document.querySelectorAll('.mark').length === 2")
    assert not replay.page.locator("#charge").is_visible()
    assert "battery" in " ".join(replay.texts("#curves figcaption"))
