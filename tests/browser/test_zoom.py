"""The map of the page, larger and smaller: what is under the pointer stays there, and all else."""

from __future__ import annotations

from typing import Any

import pytest
from browsing import Open, Watched

pytestmark = pytest.mark.sockets

UNDER = """([x, y]) => {
  const point = new DOMPoint(x, y).matrixTransform(overlay.getScreenCTM().inverse());
  return [point.x, point.y];
}"""
CORNERS = """() => {
  const { left, top, right, bottom } = document.getElementById('raster').getBoundingClientRect();
  return [left, top, right, bottom];
}"""
BOXES = """() => [...document.querySelectorAll('section, .legend li, #hall, #time')].map(
  (each) => Object.values(each.getBoundingClientRect().toJSON()))"""
WIDTH_M = "overlay.viewBox.baseVal.width"
TIME_S = "Number(document.getElementById('time').value)"
ABOUT_A_PIXEL_M = 0.05
SLOW_MS = 1000
"""Chromium takes a tap that follows a stroke more quickly than a person's for a part of it."""


class Map:
    """The map on a page."""

    def __init__(self, watched: Watched) -> None:
        watched.until("document.querySelectorAll('.mark').length === 2")
        watched.page.keyboard.press(" ")
        self.page, self.until = watched.page, watched.until
        self.comes_true = watched.comes_true
        self.whole_m = self.width_m

    @property
    def width_m(self) -> float:
        """What is seen of it."""
        view = self.page.locator("#overlay").get_attribute("viewBox")
        assert view
        return float(view.split()[2])

    @property
    def times(self) -> float:
        """How many times as large as the whole map."""
        return self.whole_m / self.width_m

    def at(self, x: float, y: float) -> list[float]:
        """A point of the window, by shares of the map's box."""
        box = self.page.locator("#hall").bounding_box()
        assert box
        return [box["x"] + x * box["width"], box["y"] + y * box["height"]]

    def under(self, point: list[float]) -> Any:
        """The metres that are drawn at a point of the window."""
        return pytest.approx(self.page.evaluate(UNDER, point), abs=ABOUT_A_PIXEL_M)

    def is_one_picture(self) -> bool:
        """Whether the distance field lies where the drawing says that the map is."""
        left, top, right, bottom = self.page.evaluate(CORNERS)
        box = [self.page.evaluate(UNDER, point) for point in ([left, top], [right, bottom])]
        return bool(box == [pytest.approx(corner, abs=ABOUT_A_PIXEL_M) for corner in self.corners])

    @property
    def corners(self) -> list[list[float]]:
        """Of the whole map, metres; to be asked while it is whole."""
        if not hasattr(self, "_corners"):
            assert self.times == 1.0
            self._corners = [self.page.evaluate(UNDER, self.at(*each)) for each in ((0, 0), (1, 1))]
        return self._corners

    def boxes(self) -> Any:
        """Where everything is on the page."""
        return self.page.evaluate(BOXES)


@pytest.fixture(params=[360, 900, 1440])
def seen(request: pytest.FixtureRequest, recorded: str, open_page: Open) -> Map:
    seen = Map(open_page(recorded, width=request.param, height=740))
    assert seen.corners
    return seen


def test_what_is_under_the_pointer_stays_there(seen: Map) -> None:
    boxes, point = seen.boxes(), seen.at(0.3, 0.6)
    here = seen.page.evaluate(UNDER, point)
    seen.page.mouse.move(*point)
    for times in (1, 2, 3):
        before = seen.times
        before_m = seen.width_m
        seen.page.mouse.wheel(0, -200)
        seen.until(f"{WIDTH_M} < {0.99 * before_m}")
        assert seen.times > 1.3 * before, times
        assert seen.under(point) == here
        assert seen.is_one_picture()
    seen.page.mouse.down()
    seen.page.mouse.move(*seen.at(0.5, 0.5), steps=4)
    seen.page.mouse.up()
    assert seen.under(seen.at(0.5, 0.5)) == here
    assert seen.is_one_picture()
    assert seen.boxes() == boxes, "the page around it is as it was"
    seen.page.locator("#whole").click()
    assert seen.times == 1.0 and seen.is_one_picture()
    assert not seen.page.locator("#whole").is_visible()
    seen.page.mouse.dblclick(*point)
    assert seen.times == pytest.approx(2.0)
    assert seen.under(point) == here


def test_it_is_never_smaller_than_whole_nor_moved_out_of_sight(seen: Map) -> None:
    seen.page.mouse.move(*seen.at(0.5, 0.5))
    seen.page.mouse.wheel(0, 5000)
    seen.page.wait_for_timeout(100)
    assert seen.times == 1.0
    seen.page.evaluate("scrollTo(0, 0)")
    seen.page.locator("#hall").focus()
    for _ in range(20):
        seen.page.keyboard.press("+")
    assert seen.times == pytest.approx(16.0)
    for key in ("ArrowLeft", "ArrowUp"):
        for _ in range(90):
            seen.page.keyboard.press(key)
    assert seen.page.evaluate(UNDER, seen.at(0, 0)) == pytest.approx(seen.corners[0], abs=0.05)
    assert seen.is_one_picture()


def test_keys_are_the_map_s_while_it_has_the_focus(recorded: str, open_page: Open) -> None:
    seen = Map(open_page(recorded))
    keys, pace = seen.page.keyboard, seen.page.locator("#pace")
    keys.press("+")
    assert (seen.times, pace.input_value()) == (1.0, "2"), "the speed's, elsewhere"
    keys.press("Home")
    keys.press("Shift+ArrowRight")
    seen.until(f"Math.abs({TIME_S} - 10) < 0.2")
    seen.page.locator("#hall").focus()
    for key in ("+", "+", "-"):
        keys.press(key)
    assert seen.times == pytest.approx(1.5)
    assert pace.input_value() == "2"
    time, left_m = seen.page.locator("#time"), seen.page.evaluate(UNDER, seen.at(0, 0))[0]
    before = time.input_value()
    keys.press("ArrowRight")
    assert seen.comes_true(lambda: seen.page.evaluate(UNDER, seen.at(0, 0))[0] > left_m + 1.0)
    seen.page.wait_for_timeout(200)
    assert time.input_value() == before
    keys.press("0")
    assert seen.times == 1.0
    keys.press("ArrowRight")  # there is nothing to move
    seen.until(f"Math.abs({TIME_S} - {before} - 1) < 0.06")


def test_two_fingers_zoom_and_one_moves(recorded: str, open_page: Open) -> None:
    """On a phone; while the map is whole, one finger scrolls the page."""
    watched = open_page(recorded, width=360, height=740, has_touch=True)
    seen = Map(watched)
    devtools = seen.page.context.new_cdp_session(seen.page)

    def tap_whole() -> None:
        whole = seen.page.locator("#whole")
        for _ in range(20):
            seen.page.wait_for_timeout(SLOW_MS)
            whole.tap()
            if watched.comes_true(lambda: not whole.is_visible(), limit_s=2.0):
                break
        assert seen.times == 1.0

    def tap_twice() -> None:
        """Until it was quick enough for one gesture, which it is not always on a busy machine."""
        for _ in range(20):
            for _ in range(2):
                seen.page.touchscreen.tap(*centre)
            if watched.comes_true(lambda: seen.times > 1.0, limit_s=2.0):
                return
        raise AssertionError("taps are not taken for a double click")

    def touch(kind: str, *points: list[float]) -> None:
        fingers = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
        devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})

    boxes, centre = seen.boxes(), seen.at(0.5, 0.5)
    here = seen.page.evaluate(UNDER, centre)
    touch("touchStart", seen.at(0.4, 0.5), seen.at(0.6, 0.5))
    for spread in (0.2, 0.3, 0.4):
        touch("touchMove", seen.at(0.5 - spread, 0.5), seen.at(0.5 + spread, 0.5))
    touch("touchEnd")
    watched.until(f"{WIDTH_M} < {seen.whole_m / 3.9}")
    assert seen.times == pytest.approx(4.0, rel=0.01)
    assert seen.under(centre) == here
    touch("touchStart", centre)
    for x in (0.45, 0.35, 0.3):
        touch("touchMove", seen.at(x, 0.7))
    touch("touchEnd")
    assert seen.comes_true(lambda: seen.under(seen.at(0.3, 0.7)) == here)
    assert seen.boxes() == boxes and watched.has_no_horizontal_scroll()
    tap_whole()
    tap_twice()
    assert seen.times == pytest.approx(2.0)
    tap_whole()
    top = seen.page.evaluate("scrollY")
    touch("touchStart", centre)
    for y in (0.3, 0.0, -0.5):
        touch("touchMove", seen.at(0.5, y))
    touch("touchEnd")
    watched.until(f"scrollY > {top}")
    assert seen.times == 1.0
