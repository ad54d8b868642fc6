"""Automata: room for their labels, and those with many states, of which a part can be looked at."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import Open, Watched, replayed
from label_room import touched_labels
from playwright.sync_api import Browser

pytestmark = pytest.mark.sockets

PATTERNS = Path(__file__).parents[2] / "docs" / "patterns"

PATROL = "G F at(A) & G F at(B) & G F at(C) & G F at(r1) | G F targetFound"
STATES = 9
ROWS = """[...document.querySelectorAll('.drawing:not(.zoomable)')].map(box => {
  const drawing = box.querySelector('svg'), { width } = drawing.getBoundingClientRect();
  return [width / drawing.viewBox.baseVal.width, box.scrollWidth - box.clientWidth];
})"""  # the scale of each row, and how much of it is out of sight
SMALL = {
    "chain": "F(at(A) & F(at(B) & F(at(C) & F at(r1))))",
    "detours": "G (at(A) -> X (!at(A) U at(B))) & G (at(B) -> X (!at(B) U at(C)))",
    "later": "G (targetFound -> X X at(A)) & F at(B)",
    "wide": "G ((at(r1) | at(r2) | at(r3)) -> X X at(A)) & G (targetFound & at(A) -> X X at(B))",
}


@pytest.fixture(scope="module")
def address(surveillance_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Of a replay of a flight that is read with a task of many states."""
    run = shutil.copytree(surveillance_run, tmp_path_factory.mktemp("automata") / "run")
    path = run / "events.jsonl"
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    next(line for line in lines if line["kind"] == "plan")["task"] = {"patrol": PATROL} | SMALL
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
    assert replay.page.locator(".large .arrow:not(.entry)").count() == 33
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


def test_no_label_touches_an_edge_a_state_or_another_label(address: str, open_page: Open) -> None:
    replay = open_page(address)
    replay.until(f"document.querySelectorAll('.automaton').length > {len(SMALL)}")
    replay.page.keyboard.press(" ")
    assert touched_labels(replay.page, ".automaton") == []


def test_nor_does_one_in_the_pictures_of_the_patterns(browser: Browser) -> None:
    pictures = [path for path in PATTERNS.glob("*.svg") if not path.stem.endswith("_flight")]
    assert len(pictures) == 22
    with browser.new_page() as page:
        page.set_content("".join(path.read_text(encoding="utf-8") for path in pictures))
        assert touched_labels(page, "svg") == []
        crossed = """<svg><path d="M0 20H90"/><text x="10" y="24">p &amp; q</text></svg>"""
        page.set_content(crossed)
        assert touched_labels(page, "svg") == ["p & q"], "it is seen"


def test_on_a_narrow_page_a_row_is_scaled_to_its_box_and_a_wide_one_scrolls(
    address: str, open_page: Open
) -> None:
    replay = open_page(address, width=360)
    replay.until(f"document.querySelectorAll('.automaton').length > {len(SMALL)}")
    replay.page.keyboard.press(" ")
    rows = replay.page.evaluate(ROWS)
    shown = [(scale, "scrolls" if beyond > 1 else "fits") for scale, beyond in rows]
    assert len(rows) > len(SMALL)
    assert all(how == "fits" or scale == pytest.approx(0.75, abs=1e-3) for scale, how in shown), (
        shown
    )
    assert any(scale < 1 and how == "fits" for scale, how in shown), shown
    assert any(how == "scrolls" for _, how in shown), shown
    assert replay.has_no_horizontal_scroll()
    widest = replay.page.locator(".drawing").nth(max(range(len(rows)), key=lambda n: rows[n][1]))
    widest.focus()
    assert replay.violations() == []


class LargeAutomaton:
    """The large automaton of a page, of which a part can be looked at."""

    def __init__(self, replay: Watched) -> None:
        replay.until("document.querySelectorAll('.zoomable').length === 1")
        replay.page.keyboard.press(" ")
        self.box = replay.page.locator(".zoomable")
        self.keys = replay.page.keyboard
        self.box.scroll_into_view_if_needed()

    @property
    def view(self) -> list[float]:
        """Left, top, width and height of what is seen."""
        text = self.box.locator("svg").get_attribute("viewBox")
        assert text
        return [float(number) for number in text.split()]


@pytest.mark.parametrize("width", [360, 1440])
def test_a_part_of_a_large_one_is_looked_at_with_keys(
    address: str, open_page: Open, width: int
) -> None:
    replay = open_page(address, width=width)
    drawing = LargeAutomaton(replay)
    whole, time = drawing.view, replay.page.locator("#time").input_value()
    box = drawing.box.bounding_box()
    drawing.box.focus()
    drawing.keys.press("+")
    drawing.keys.press("+")
    near = drawing.view
    assert near[2] == pytest.approx(whole[2] / 2.25, rel=1e-3)
    drawing.keys.press("ArrowRight")
    assert drawing.view[0] > near[0] and drawing.view[1:] == near[1:]
    replay.page.wait_for_timeout(200)
    assert replay.page.locator("#time").input_value() == time, "the arrows were not the time's"
    for n in range(STATES):
        drawing.box.locator(".state").nth(n).focus()
        left, top, wide, high = drawing.view
        x, y = replay.page.evaluate(
            """n => { const { e, f } = document.querySelectorAll('.zoomable .state')[n]
              .transform.baseVal[0].matrix; return [e, f]; }""",
            n,
        )
        assert left < x < left + wide and top < y < top + high, "it comes into sight"
    assert drawing.box.bounding_box() == box and replay.has_no_horizontal_scroll()
    assert replay.violations() == []
    drawing.box.locator("button").click()
    assert drawing.view == whole
    assert not drawing.box.locator("button").is_visible()


def test_a_part_of_a_large_one_is_looked_at_with_the_pointer(address: str, open_page: Open) -> None:
    drawing = LargeAutomaton(replay := open_page(address))
    whole = drawing.view
    box = drawing.box.bounding_box()
    assert box
    at = box["x"] + 0.3 * box["width"], box["y"] + 0.6 * box["height"]
    replay.page.mouse.dblclick(*at)
    near = drawing.view
    assert near == pytest.approx(
        [0.15 * whole[2], 0.3 * whole[3], whole[2] / 2, whole[3] / 2], abs=1
    )
    replay.page.mouse.move(*at)
    replay.page.mouse.down()
    replay.page.mouse.move(at[0] - 20, at[1] - 30, steps=4)
    replay.page.mouse.up()
    assert drawing.view[0] > near[0] and drawing.view[1] > near[1]
    replay.page.mouse.wheel(0, -200)
    assert replay.comes_true(lambda: drawing.view[2] < 0.8 * near[2])
