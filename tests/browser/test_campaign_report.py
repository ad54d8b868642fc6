"""The report of a campaign, as a browser shows it: alone, narrow, dark, and by keyboard."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from browsing import LIMIT_S
from playwright.sync_api import Browser, Page
from reported import ROWS, source

from companion.campaigns.report import report_html

pytestmark = pytest.mark.sockets

WIDTHS = "[document.documentElement.scrollWidth, document.documentElement.clientWidth]"
COLOURS = "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]"


@pytest.fixture
def report(browser: Browser, tmp_path: Path) -> Iterator[Page]:
    """The page of a file, which asks for nothing else."""
    file = tmp_path / "report.html"
    file.write_text(report_html(source(ROWS)), encoding="utf-8")
    page = browser.new_page(viewport={"width": 360, "height": 740})
    page.set_default_timeout(1000 * LIMIT_S)
    asked: list[str] = []
    faults: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: faults.append(message.text))
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(file.as_uri())
    yield page
    page.close()
    assert (asked, faults) == ([file.as_uri()], [])


def test_nothing_is_wider_than_a_telephone(report: Page) -> None:
    scroll, client = report.evaluate(WIDTHS)
    assert scroll == client == 360
    for details in report.query_selector_all("details"):
        details.evaluate("each => each.open = true")
    assert report.evaluate(WIDTHS) == [360, 360]


def test_the_longest_names_fit_a_telephone(browser: Browser, tmp_path: Path) -> None:
    long = "W" * 40
    given = source([replace(each, conjunct=each.conjunct and long, place=long) for each in ROWS])
    kit = replace(given.kit, mission=replace(given.kit.mission, name=long))
    file = tmp_path / "report.html"
    file.write_text(report_html(replace(given, kit=kit)), encoding="utf-8")
    page = browser.new_page(viewport={"width": 360, "height": 740})
    page.goto(file.as_uri())
    for details in page.query_selector_all("details"):
        details.evaluate("each => each.open = true")
    assert page.evaluate(WIDTHS) == [360, 360]
    page.close()


def test_it_is_dark_for_those_who_like_it_dark(report: Page) -> None:
    light = report.evaluate(COLOURS)
    report.emulate_media(color_scheme="dark")
    dark = report.evaluate(COLOURS)
    assert dark != light
    assert sum(channels(dark[0])) < 150 < 600 < sum(channels(dark[1]))
    assert sum(channels(light[1])) < 150 < 600 < sum(channels(light[0]))


def channels(colour: str) -> list[int]:
    """Red, green and blue of rgb(r, g, b)."""
    return [int(part) for part in colour.removeprefix("rgb(").removesuffix(")").split(",")]


def test_the_worst_flights_are_opened_by_keyboard(report: Page) -> None:
    flights = report.query_selector_all("details:has(svg.flight)")
    assert [bool(each.evaluate("each => each.open")) for each in flights] == [True] + [False] * 9
    second = flights[1].query_selector("summary")
    assert second is not None
    for _ in range(40):
        report.keyboard.press("Tab")
        if second.evaluate("each => each === document.activeElement"):
            break
    report.keyboard.press("Enter")
    assert flights[1].evaluate("each => each.open")


def test_pictures_show_the_track_and_where_it_ended(report: Page) -> None:
    track = report.query_selector("svg.flight polyline.track")
    assert track is not None
    box = track.bounding_box()
    assert box is not None and box["width"] > 5 and box["height"] > 5
    assert len(report.query_selector_all("svg.flight .end-mark")) == 10
    wall = "document.querySelector('symbol .wall').getBBox().width"
    assert report.evaluate(wall) > 10
