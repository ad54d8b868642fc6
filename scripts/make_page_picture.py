"""Makes docs/monitor.png: the monitor page of the paper's mission, after its second replan.

It flies the mission in lockstep with seed 0, replays it, and takes a picture with Debian's
chromium.

Usage: python scripts/make_page_picture.py [FILE]
"""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benches import ROOT
from benches.shipped import shipped
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from companion.record.run_folder import RunFolder

MISSION = "surveillance"
SHOWN_S = 54.5
"""Time of the flight that is shown."""
SIZE = {"width": 1440, "height": 900}
MOST_BYTES = 300_000
SEEK = """time => {
  const slider = document.getElementById('time');
  slider.value = time;
  slider.dispatchEvent(new Event('input'));
}"""


def fly(folder: Path) -> None:
    """Writes a run folder of the mission."""
    flight = next(each for each in shipped() if each.name == MISSION)
    mission = flight.load()
    run = RunFolder(folder, mission, 0.0, lambda report: None)
    flight.flight(mission, run).fly()
    run.close()


@contextmanager
def paused_page() -> Iterator[Page]:
    """The page of a flight of the mission, completely loaded and paused."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / MISSION
        fly(folder)
        command = [sys.executable, "-m", "companion", "replay", str(folder), "--port", "0"]
        with (
            subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server,
            sync_playwright() as playwright,
        ):
            assert server.stdout is not None
            browser = playwright.chromium.launch(
                executable_path="/usr/bin/chromium", args=["--no-sandbox"]
            )
            page = browser.new_page(viewport=SIZE)
            page.goto(server.stdout.readline().split()[1])
            page.locator("#play", has_text="Pause").click()
            page.locator("#lines li", has_text="satisfied, landed").wait_for(state="attached")
            yield page
            server.kill()


def picture(page: Page, time_s: float, wait_ms: float) -> bytes:
    """The page at one time of the flight, as a PNG."""
    page.evaluate(SEEK, time_s)
    page.wait_for_timeout(wait_ms)
    return page.screenshot()


def main(path: Path) -> None:
    """Writes the picture."""
    with paused_page() as page:
        png = picture(page, SHOWN_S, wait_ms=500)
    with Image.open(io.BytesIO(png)) as image:
        image.convert("RGB").save(path, optimize=True)
    assert path.stat().st_size <= MOST_BYTES, f"{path} has {path.stat().st_size} bytes"
    print(f"{path}  {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "monitor.png")
