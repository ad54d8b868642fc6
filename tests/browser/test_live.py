"""The monitor page of a running flight, in a browser: what it shows is what happens."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from browsing import Open, Watched
from pictures import programs_do_not_draw
from ports import free_instance, own_ports

pytestmark = pytest.mark.sockets

SURVEILLANCE = Path(__file__).parents[2] / "missions" / "surveillance.yaml"
SPEED = 1
TRAIL = "document.querySelector('.trail polyline').getAttribute('points')"
CONJUNCTS = "[...document.querySelectorAll('.conjunct')]"
LINES = "[...document.querySelectorAll('#lines li span')].map(line => line.textContent)"


@pytest.fixture
def flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The address of a flight's page."""
    programs_do_not_draw(tmp_path, monkeypatch)
    arguments = [
        *("sim", SURVEILLANCE, "--speed", SPEED, *own_ports(free_instance())),
        *("--log-dir", tmp_path, "--monitor", "127.0.0.1:0"),
    ]
    with subprocess.Popen(
        [sys.executable, "-m", "companion", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        assert process.stdout is not None
        printed = ""
        while not (address := re.search(r"^monitor +(http://\S+)$", printed, re.MULTILINE)):
            printed += process.stdout.readline() or pytest.fail(printed)
        yield address[1]
        process.kill()
        print(process.stdout.read())  # shown if the test fails


def has_figure(page: Watched, figure: str) -> bool:
    return re.search(figure, " ".join(page.texts("#vehicle div"))) is not None


def test_a_mission_from_the_first_plan_to_the_landing(flight: str, open_page: Open) -> None:
    desk, tablet, phone = (open_page(flight, width=width) for width in (1440, 768, 360))
    desk.until(f"{LINES}.includes('at A')")
    assert desk.shows("#badge", "live")
    assert desk.shows("#name", "surveillance")
    places = {"Home", "A", "B", "C", "r1", "r2", "r3"}
    assert desk.comes_true(lambda: set(desk.texts(".names text")) == places)
    assert desk.shows("#plan .prefix .step", "move(Home, A)")
    assert desk.shows("#plan .loop .step", "move(A, B)", "move(B, C)", "move(C, A)")
    desk.until("document.querySelector('.step[aria-current]')?.textContent.includes('move(A, B)')")
    running = "#tree .leaf[data-status=RUNNING] .label"
    assert desk.shows(running, "move_cmd B")
    assert desk.comes_true(desk.page.locator(running).first.is_visible), "the running path is open"
    desk.until("document.querySelectorAll('.path polyline').length === 4")
    for figure in (r"mode\s+OFFBOARD", r"link\s+good", r"battery\s+\d+ %", r"up\s+(1\.9|2\.\d) m"):
        assert desk.comes_true(partial(has_figure, desk, figure))
    assert desk.comes_true(lambda: "C or targetFound still due" in " ".join(desk.texts("#due li")))
    assert desk.violations() == []
    flown = desk.page.evaluate(TRAIL)
    desk.until(f"{TRAIL}.length > {len(flown)} + 100")
    assert desk.page.evaluate(TRAIL)[: len(flown) // 2] == flown[: len(flown) // 2]
    desk.until("document.querySelectorAll('.setpoint:not([hidden])').length === 1")

    assert desk.shows(".withdrawn")
    desk.until("document.querySelectorAll('.mark').length === 2")
    desk.until("document.querySelector('.withdrawn')")
    assert desk.shows(".withdrawn", "canUpload(r1)")
    assert desk.shows(".holds", "targetFound")
    assert desk.shows("#plan .prefix .step", "move(r1, r2)", "upload(r2)", "move(r2, Home)")
    assert desk.shows("#plan .loop .step", "wait")
    assert desk.shows("#plan-title", "Plan 3, after replan 2")
    assert desk.shows(".reason", "upload(r1) failed: denied")

    desk.page.locator(".mark").first.click()
    desk.until("document.querySelector('#badge').textContent === 'looking back'")
    desk.until("!document.querySelector('.withdrawn')")
    assert desk.comes_true(
        lambda: "replan 1: target found" in " ".join(desk.texts("#lines [data-present]")[:1])
    )
    desk.page.locator("#live").click()

    desk.until("document.querySelector('#badge').textContent === 'ended'")
    assert desk.shows("#phase", "task satisfied, landed")
    for page in (desk, tablet, phone):
        page.until(f"{LINES}.includes('task satisfied, landed')")
        assert page.has_no_horizontal_scroll()
        page.until("document.querySelectorAll('.conjunct').length === 5")
        page.until(
            f"{CONJUNCTS}.every(each => each.querySelector('[data-here] .ring'))"
        )  # accepting
        assert page.violations() == []
        page.page.emulate_media(color_scheme="dark")
        page.page.wait_for_timeout(300)  # colours change slowly
        assert page.violations("color-contrast") == []
        page.faults[:] = [f for f in page.faults if "ERR_" not in f]  # the server has gone
