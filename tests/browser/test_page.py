"""What the page tells, in words and signs, and that everybody can read and use it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Open, Watched, replayed
from meadow import DATA

from companion import load_mission, simulate

pytestmark = pytest.mark.sockets

WIDTHS = (360, 768, 1440)
DUE = "[...document.querySelectorAll('#due li')].map(each => each.innerText).join('; ')"
LISTED = "[...document.querySelectorAll('#lines li:not([hidden])')].map(each => each.dataset.kind)"
CENTRE = """(() => {
  const [hall, { x, y, width, height }] = ['hall', 'overlay'].map(id => document.getElementById(id)
    ).map((each, i) => (i ? each.querySelector('.vehicle path') : each).getBoundingClientRect());
  const middle = [hall.x + hall.width / 2, hall.y + hall.height / 2];
  return Math.hypot(x + width / 2 - middle[0], y + height / 2 - middle[1]);
})()"""


@pytest.fixture(scope="module")
def address(surveillance_run: Path) -> Iterator[str]:
    """Of one replay for all tests."""
    with replayed(surveillance_run) as origin:
        yield origin


def opened(address: str, open_page: Open, width: int = 1440) -> Watched:
    """The page, paused, with all of the flight read."""
    replay = open_page(address, width=width, height=740)
    replay.until("document.querySelector('#lines')?.innerText.includes('satisfied, landed')")
    replay.page.locator("#play", has_text="Pause").click()
    return replay


@pytest.mark.parametrize("width", WIDTHS)
def test_axe_finds_nothing_light_or_dark(width: int, address: str, open_page: Open) -> None:
    replay = opened(address, open_page, width)
    replay.page.locator(".mark").nth(1).click()
    replay.page.locator("#signs button").first.focus()
    assert replay.violations() == []
    replay.page.emulate_media(color_scheme="dark")
    replay.page.wait_for_timeout(300)  # colours change slowly
    assert replay.violations("color-contrast") == []
    assert replay.has_no_horizontal_scroll()
    replay.page.evaluate("document.getElementById('map').style.display = 'none'")
    replay.page.wait_for_timeout(100)  # a map without a width is no fault


LONGEST = {"place": "A" * 40, "line": "T" * 40, "mission": "M" * 40}
"""Each name is of the most letters that it may have."""


@pytest.fixture
def longest_names(tmp_path: Path) -> Iterator[str]:
    """The address of a replay of a mission with such names; it outlasts the pages."""
    far, line, name = LONGEST.values()
    meadow: Any = json.loads(
        json.dumps(DATA).replace('"A"', f'"{far}"').replace("at(A)", f"at({far})")
    )
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [29, -9], [29, 9], [-9, 9]]}
    of_meadow = {"name": name, "limits": limits, "task": {line: f"F at({far}) & F G at(Home)"}}
    simulate(load_mission(meadow | of_meadow), folder=tmp_path / "run")
    with replayed(tmp_path / "run") as address:
        yield address


def test_the_longest_names_fit_a_telephone(longest_names: str, open_page: Open) -> None:
    replay = open_page(longest_names, width=360, height=740)
    replay.until("document.querySelector('#lines')?.innerText.includes('satisfied, landed')")
    replay.page.locator("#plan .step", has_text=LONGEST["place"]).first.wait_for()
    assert replay.page.locator("h1").inner_text() == LONGEST["mission"]
    assert replay.has_no_horizontal_scroll()


def test_what_is_due_and_the_edges_just_taken(address: str, open_page: Open) -> None:
    replay = opened(address, open_page)
    replay.page.locator("#lines button", has_text="at A").first.click()
    replay.page.keyboard.press("ArrowRight")
    words = "search B or targetFound, C or targetFound still due in this lap"
    replay.until(f"{DUE} === '{words}'")
    taken = replay.texts(".arrow[data-taken] > text")
    assert len(taken) == 5 and "targetFound or A" in taken, taken
    replay.page.keyboard.press("End")
    replay.until(f"{DUE} === 'the flight is over'")


def test_events_are_chosen_by_kind_and_by_words(address: str, open_page: Open) -> None:
    replay = opened(address, open_page)
    replay.page.locator("#kinds").select_option("plans")
    assert set(replay.page.evaluate(LISTED)) == {"plan", "replan", "lap"}
    replay.page.locator("#words").press_sequentially("Target found -")
    assert replay.page.evaluate(LISTED) == ["replan"]
    assert replay.texts("#play") == ["Play"], "a space is a space"


def test_signs_say_what_they_mean(address: str, open_page: Open) -> None:
    replay = opened(address, open_page)
    tip = replay.page.locator("#tip")
    assert not tip.is_visible()
    replay.page.locator("#signs button", has_text="MAX_TRY").focus()
    assert "up to n times" in tip.inner_text()
    replay.page.keyboard.press("Escape")
    assert not tip.is_visible()
    for key, words in (("omega", "for ever"), ("triple", "precondition"), ("loop", "the lap")):
        replay.page.locator(f"#signs [data-explain={key}]").hover()
        assert words in tip.inner_text()


def test_the_map_follows_the_vehicle_until_it_is_moved(address: str, open_page: Open) -> None:
    replay = opened(address, open_page)
    replay.page.locator("#lines button", has_text="at r1").click()
    follow = replay.page.locator("#follow")
    follow.click()
    replay.until(f"{CENTRE} < 4")
    replay.page.keyboard.press("Shift+ArrowLeft")
    replay.until(f"document.querySelector('#clock').innerText.startsWith('00:39') && {CENTRE} < 4")
    replay.page.locator("#hall").focus()
    replay.page.keyboard.press("ArrowLeft")
    assert follow.get_attribute("aria-pressed") == "false"
    assert replay.comes_true(lambda: replay.page.evaluate(CENTRE) > 40)
