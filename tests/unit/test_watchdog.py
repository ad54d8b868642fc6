"""What the service manager hears, on a socket of the test's own."""

from __future__ import annotations

import configparser
import re
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.cli.flying import run
from companion.errors import Aborted, LinkError, MissionError, NoPlanError, SearchLimit
from companion.watchdog import Watchdog

UNIT = Path(__file__).parents[2] / "scripts" / "companion.service"


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.setblocking(False)
        yield listening


def heard(manager: socket.socket) -> list[str]:
    texts = []
    while True:
        try:
            texts.append(manager.recv(100).decode())
        except BlockingIOError:
            return texts


def test_it_beats_four_times_in_the_time_that_it_is_given(manager: socket.socket) -> None:
    watchdog = Watchdog({"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "2000000"})
    for tick in range(41):
        watchdog.beat(100.0 + 0.05 * tick)
    assert heard(manager) == ["READY=1", *["WATCHDOG=1"] * 5]
    watchdog.close()
    assert heard(manager) == ["STOPPING=1"]


def test_without_a_limit_it_only_says_that_it_is_ready(manager: socket.socket) -> None:
    watchdog = Watchdog({"NOTIFY_SOCKET": manager.getsockname()})
    for tick in range(41):
        watchdog.beat(0.05 * tick)
    assert heard(manager) == ["READY=1"]


def test_a_service_manager_that_is_gone_stops_nothing(tmp_path: Path) -> None:
    watchdog = Watchdog({"NOTIFY_SOCKET": str(tmp_path / "nobody"), "WATCHDOG_USEC": "1000000"})
    watchdog.beat(0.0)
    watchdog.close()


def test_the_shipped_unit_says_what_the_command_takes() -> None:
    """A run that ended is not begun again; one that was killed is."""
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read(UNIT)
    service = unit["Service"]
    options = set(re.findall(r"--[a-z-]+", service["ExecStart"]))
    known = {f"--{name.replace('_', '-')}" for name in run.__annotations__}
    assert "--resume" in options and options <= known
    ended = (MissionError, NoPlanError, LinkError, Aborted, SearchLimit)
    kept = {int(code) for code in service["RestartPreventExitStatus"].split()}
    assert kept == {error.exit_code for error in ended}
    assert service["Restart"] == "on-failure" and service["Type"] == "notify"
