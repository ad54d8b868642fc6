"""docs/tutorial.md and docs/how-to.md, followed to the letter in an empty home: it is as they show.

A block of YAML goes into the file that the text before it names last: as the whole file if it is
not there yet or the block begins with `version`, else in place of the same keys, or at the end. The
commands of console blocks are run one after another, and print the lines that are shown, in that
order; `...` stands for lines that are left out. Times of a flight may differ by a second.
"""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sysconfig
import urllib.request
from pathlib import Path

import pytest
from first_installation import environment
from pictures import UNDRAWN

DOCS = Path(__file__).parents[1] / "docs"
SCRIPTS = sysconfig.get_path("scripts")
BLOCK = re.compile(r"^```(yaml|console)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SECTION = re.compile(r"^(\w+):.*?(?=^\w+:|\Z)", re.MULTILINE | re.DOTALL)
SERVER = "companion replay "


class Reader:
    """Somebody who does what the page says, in a home of their own."""

    def __init__(self, home: Path) -> None:
        hiding = environment(home / "hiding", more=UNDRAWN)
        self._environment = hiding | {"HOME": str(home), "PATH": f"{SCRIPTS}:{os.defpath}"}
        self._folder = home
        self._status = 0

    def writes(self, file: str, text: str) -> None:
        """Puts a block into a file."""
        path = self._folder / file
        if text.startswith("version:") or not path.exists():
            path.write_text(text, encoding="utf-8")
            return
        content = path.read_text(encoding="utf-8")
        for section in SECTION.finditer(text):
            old = re.compile(rf"^{section[1]}:.*?(?=^\w+:|\Z)", re.MULTILINE | re.DOTALL)
            content = old.sub("", content) + section[0]
        path.write_text(content, encoding="utf-8")

    def types(self, command: str, is_asked_for: bool) -> str:
        """What a command prints; it may fail only where the next one asks for its exit code."""
        if command == "echo $?":
            return f"{self._status}\n"
        if command.startswith("cd "):
            self._folder /= shlex.split(command)[1]
            return ""
        process = subprocess.Popen(
            ["bash", "-c", f"exec {command}" if command.startswith(SERVER) else command],
            cwd=self._folder,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        assert process.stdout is not None
        if command.startswith(SERVER):
            address = re.search(r"http://\S+", process.stdout.readline())
            assert address
            with urllib.request.urlopen(address[0], timeout=600):  # it is served
                process.send_signal(signal.SIGINT)
        printed, _ = process.communicate(timeout=600)
        self._status = process.returncode
        assert is_asked_for or not self._status, printed
        return printed


def shown(block: str) -> list[tuple[str, list[str]]]:
    """The commands of a console block, with the lines that are shown after each."""
    found: list[tuple[str, list[str]]] = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append((line[2:], []))
        else:
            found[-1][1].append(line)
    return found


TIME = r"\d\d:\d\d\.\d"
NEAR_S = 1.0


def has(printed: str, lines: list[str]) -> bool:
    """Whether lines were printed; all others may be left out where `...` stands."""
    parts = [r"(?:.*\n)*?" if line == "..." else f"{re.escape(line)} *\n" for line in lines]
    pattern = re.sub(r"\d\d:\d\d\\\.\d", lambda time: f"({TIME})", "".join(parts))
    found = re.fullmatch(pattern, printed)
    told = re.findall(TIME, "\n".join(lines))
    return found is not None and all(
        abs(seconds(a) - seconds(b)) <= NEAR_S for a, b in zip(told, found.groups(), strict=True)
    )


def seconds(time: str) -> float:
    """A time of a flight."""
    minutes, rest = time.split(":")
    return 60 * int(minutes) + float(rest)


def test_lines_may_be_left_out_where_it_says_so() -> None:
    assert has("a\nb\nc\n", ["a", "...", "c"]) and has("a\nb\n", ["...", "b", "..."])
    assert has(" 00:59.9  at A\n", [" 01:00.4  at A"])
    assert not has(" 00:58.9  at A\n", [" 01:00.4  at A"])
    assert not has("a\nb\nc\n", ["a", "c"]) and not has("a\nb\n", ["b"])


@pytest.mark.slow
@pytest.mark.sockets  # as others that fly; one opens a port, for a page
@pytest.mark.parametrize("page", ["tutorial.md", "how-to.md"])
def test_a_page_can_be_followed(page: str, tmp_path: Path) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")
    reader = Reader(tmp_path)
    for block in BLOCK.finditer(text):
        if block[1] == "yaml":
            reader.writes(re.findall(r"`([\w.-]+\.yaml)`", text[: block.start()])[-1], block[2])
            continue
        commands = shown(block[2])
        following = [command for command, _ in commands[1:]] + [""]
        for (command, lines), then in zip(commands, following, strict=True):
            printed = reader.types(command, is_asked_for=then == "echo $?")
            assert has(printed, lines), f"$ {command}\n{printed}"
