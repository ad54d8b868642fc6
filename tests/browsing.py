"""A page that is watched: what it says, and all that goes wrong on it."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

LOOK_AGAIN_S = 0.05
LIMIT_S = 300.0  # wall time that nothing on a page needs


@dataclass
class Watched:
    """A page and what has gone wrong on it so far."""

    page: Page
    origin: str
    faults: list[str] = field(default_factory=list)

    def look(self) -> None:
        """Keeps faults: of scripts, and requests that leave the page's own origin."""
        self.page.on("console", lambda message: self.faults.append(f"said {message.text}"))
        self.page.on("pageerror", lambda error: self.faults.append(f"threw {error}"))
        self.page.on("request", lambda request: self._allow(request.url))
        self.page.goto(self.origin)

    def _allow(self, url: str) -> None:
        if not url.startswith(f"{self.origin}/"):
            self.faults.append(f"asked for {url}")

    def texts(self, selector: str) -> list[str]:
        """What all elements of a kind say; found and read at once, for the page goes on."""
        say = """selector => [...document.querySelectorAll(selector)].map(
            each => (each.innerText ?? each.textContent).trim())"""
        return [str(text) for text in self.page.evaluate(say, selector)]

    def until(self, condition: str) -> None:
        """Waits until an expression of the page's own language holds.

        Playwright's own way to wait is code in the page, which its security policy refuses.
        """
        assert self.comes_true(lambda: self.page.evaluate(condition)), f"{condition}\n{self.faults}"

    def shows(self, selector: str, *texts: str) -> bool:
        """Waits until all elements of a kind say this, in order."""
        return self.comes_true(lambda: self.texts(selector) == [*texts])

    def comes_true(self, is_so: Callable[[], object], limit_s: float = LIMIT_S) -> bool:
        """Looks again and again, while the page goes on, until something is so."""
        end_s = time.monotonic() + limit_s
        while not is_so():
            if time.monotonic() > end_s:
                return False
            self.page.wait_for_timeout(1000 * LOOK_AGAIN_S)
        return True

    def violations(self, *rules: str) -> list[str]:
        """What axe-core finds that keeps people from using the page; by all rules, or by some."""
        options = {"runOnly": list(rules)} if rules else None
        found = Axe().run(self.page, options=options).response["violations"]
        return [f"{each['id']}: {[node['html'] for node in each['nodes']]}" for each in found]

    def has_no_horizontal_scroll(self) -> bool:
        """Whether the page is as wide as its window."""
        widths = "[document.documentElement.scrollWidth, document.documentElement.clientWidth]"
        scroll, client = self.page.evaluate(widths)
        return bool(scroll == client)


Open = Callable[..., Watched]
"""Opens an address in a window of some width."""


@contextmanager
def replayed(run: Path) -> Iterator[str]:
    """The address of a replay of a run."""
    command = [sys.executable, "-m", "companion", "replay", str(run), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = re.search(r"http://\S+", process.stdout.readline())
        assert address
        yield address[0]
        process.kill()
