"""Log lines: shown by `--verbose` alone, and never in the way of a command or of a flight."""

from __future__ import annotations

import fcntl
import logging
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.cli.log_lines import UnblockingHandler, show_log_lines
from companion.mavlink.commands import SILENCE_S, CommandSender
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.vehicle.endpoints import parse_url
from companion.vehicle.link import Link
from companion.vehicle.transport import Udp

pytestmark = pytest.mark.slow

SURVEILLANCE = Path(__file__).parents[1] / "missions" / "surveillance.yaml"
PLAN = (sys.executable, "-m", "companion", "plan", str(SURVEILLANCE))
SHOWN = "companion.cli.log_lines import show_log_lines; show_log_lines(True)"
LOGGING = f"import logging; from {SHOWN}; logging.getLogger('companion').debug('a'); print('b')"
LOGS = (sys.executable, "-c", LOGGING)
"""Shows a log line and prints b, in a moment."""
FULL = Path("/dev/full")
LOG = logging.getLogger("companion.of.a.test")


@pytest.fixture(scope="module")
def quiet() -> subprocess.CompletedProcess[bytes]:
    """What `companion plan` prints."""
    return subprocess.run(PLAN, capture_output=True, timeout=60, check=False)


@pytest.fixture
def verbose() -> Iterator[None]:
    """Log lines are shown meanwhile."""
    show_log_lines(True)
    yield
    show_log_lines(False)


def test_without_the_option_there_are_none(quiet: subprocess.CompletedProcess[bytes]) -> None:
    assert (quiet.returncode, quiet.stderr) == (0, b"")


def test_with_the_option_they_are_on_standard_error(
    quiet: subprocess.CompletedProcess[bytes],
) -> None:
    done = subprocess.run([*PLAN, "--verbose"], capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (0, quiet.stdout)
    lines = done.stderr.decode()
    assert "companion.planning.task_automata  automaton of upload: " in lines
    assert "companion.planning.builtin.search  product of " in lines
    assert " ms" in lines


def test_a_log_line_is_shown_in_a_moment() -> None:
    done = subprocess.run(LOGS, capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (0, b"b\n")
    assert done.stderr.endswith(b"companion  a\n")


@pytest.mark.long
def test_a_closed_standard_error_takes_none() -> None:
    done = subprocess.run(
        ["sh", "-c", 'exec "$@" 2>&-', "sh", *LOGS],
        stdout=subprocess.PIPE,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, b"b\n")


@pytest.mark.skipif(not FULL.exists(), reason="no /dev/full here")
def test_a_full_disk_takes_none() -> None:
    with FULL.open("wb") as full:
        done = subprocess.run(LOGS, stdout=subprocess.PIPE, stderr=full, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (0, b"b\n")


@pytest.mark.long
def test_a_pipe_that_nobody_reads_takes_none(quiet: subprocess.CompletedProcess[bytes]) -> None:
    """A write to it would wait for ever."""
    reader, writer = os.pipe()
    try:
        fill(writer)
        done = subprocess.run(
            [*PLAN, "-v"], stdout=subprocess.PIPE, stderr=writer, timeout=60, check=False
        )
    finally:
        os.close(reader)
        os.close(writer)
    assert (done.returncode, done.stdout) == (0, quiet.stdout)


def fill(pipe: int) -> None:
    """Writes until nothing more fits."""
    flags = fcntl.fcntl(pipe, fcntl.F_GETFL)
    fcntl.fcntl(pipe, fcntl.F_SETFL, flags | os.O_NONBLOCK)
    try:
        while True:
            os.write(pipe, bytes(4096))
    except BlockingIOError:
        fcntl.fcntl(pipe, fcntl.F_SETFL, flags)


def test_a_wrong_log_line_raises_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    """Asked of the handler itself; pytest's own one raises."""
    handler = UnblockingHandler()
    handler.handle(logging.LogRecord("a.test", logging.DEBUG, "", 1, "%d", ("many",), None))
    assert capfd.readouterr().err == ""


@pytest.mark.usefixtures("verbose")
def test_what_is_no_unicode_is_shown_as_a_number(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logging.getLogger("companion"), "propagate", False)  # not into the report
    LOG.debug("said \ud800")
    assert capfd.readouterr().err.endswith("companion.of.a.test  said \\ud800\n")


@pytest.mark.usefixtures("verbose")
def test_shown_twice_they_come_once(capfd: pytest.CaptureFixture[str]) -> None:
    show_log_lines(True)
    LOG.debug("one")
    assert capfd.readouterr().err.count("one") == 1
    show_log_lines(False)
    LOG.debug("two")
    assert capfd.readouterr().err == ""


def test_a_link_logs_whom_it_hears_first_and_whom_it_answers(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.DEBUG, "companion")
    link = Link(parse_url("udpin://127.0.0.1:0"))
    assert isinstance(link.transport, Udp)
    heartbeat = MavlinkCodec(7, 1).pack(dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(("127.0.0.1", 0))
        port = vehicle.getsockname()[1]
        for _ in range(2):
            vehicle.sendto(heartbeat, link.transport.address)
            assert link.wait(10.0)
            assert link.receive()
    link.close()
    assert caplog.messages == [
        f"first datagram from 127.0.0.1:{port}, {len(heartbeat)} bytes",
        f"answers go to 127.0.0.1:{port}, the autopilot of system 7",
    ]


def test_a_command_logs_what_is_sent_and_that_nobody_answers(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.DEBUG, "companion")
    commands = CommandSender()
    commands.start(0.0, (1, 25), 31010, (0.0,) * 7)
    for now_s in (0.0, 0.1, 0.5, SILENCE_S):
        commands.due(now_s)
    sent = [line.partition(", parameters")[0] for line in caplog.messages]
    assert sent == [
        "command 31010 to 1/25: sent, confirmation 0",
        "command 31010 to 1/25: sent, confirmation 1",
        "command 31010 to 1/25: no answer",
    ]
