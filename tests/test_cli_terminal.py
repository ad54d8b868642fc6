"""Nothing that happens to a terminal reaches the flight."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import IO

import pytest
from commands import UNDRAWN

from companion.cli.terminal import LINES_KEPT, Terminal, undisturbed
from companion.flight_events.event import FlightEvent
from companion.flight_events.hosting import TerminalHungUp
from companion.flight_events.reading import read_line
from companion.flight_events.sortie import TaskSatisfied

HOP = Path(__file__).parent / "data" / "hop.yaml"


# -- lines -----------------------------------------------------------------------------------------


class Pipe:
    """A pipe that is standard output once a test has begun."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.reader, writer = os.pipe()
        self.stream: IO[str] = os.fdopen(writer, "w")
        self._monkeypatch = monkeypatch

    def terminal(self) -> Terminal:
        self._monkeypatch.setattr("sys.stdout", self.stream)
        return Terminal()

    def read(self) -> str:
        os.set_blocking(self.reader, False)
        text = b""
        with suppress(BlockingIOError):
            while part := os.read(self.reader, 1 << 16):
                text += part
        return text.decode()


@pytest.fixture
def pipe(monkeypatch: pytest.MonkeyPatch) -> Iterator[Pipe]:
    made = Pipe(monkeypatch)
    yield made
    with suppress(OSError):
        os.close(made.reader)
    with suppress(OSError):
        made.stream.close()


def test_lines_are_there_at_once(pipe: Pipe) -> None:
    terminal = pipe.terminal()
    terminal.say("one")
    assert pipe.read() == "one\n"


def test_a_reader_who_does_not_read_holds_up_the_lines_alone(pipe: Pipe) -> None:
    terminal = pipe.terminal()
    lines = [f"{number:04d} " + "x" * 200 for number in range(600)]  # twice what a pipe holds
    for line in lines:
        terminal.say(line)
    seen = pipe.read()
    terminal.say("last")
    seen += pipe.read()
    terminal.close()
    assert (seen + pipe.read()).splitlines() == [*lines, "last"]


@pytest.mark.slow
def test_lines_for_nobody_are_dropped_in_the_end(pipe: Pipe) -> None:
    terminal = pipe.terminal()
    for number in range(5 * LINES_KEPT):
        terminal.say(f"{number} " + "x" * 200)
    terminal.close()
    assert pipe.read().startswith("0 ")


def test_a_closed_pipe_is_given_up(pipe: Pipe) -> None:
    os.close(pipe.reader)
    terminal = pipe.terminal()
    for _ in range(3):
        terminal.say("nobody reads this")
    terminal.close()
    pipe.stream.write("nor this")
    pipe.stream.flush()


def test_a_stream_without_a_file_is_written(capsys: pytest.CaptureFixture[str]) -> None:
    with closing(Terminal()) as terminal:
        terminal.say("news")
        terminal.say("a mistake", is_error=True)
    assert capsys.readouterr() == ("news\n", "a mistake\n")


@pytest.mark.parametrize("name", ["SIGTSTP", "SIGTTOU", "SIGTTIN"])
def test_a_flight_cannot_be_suspended(name: str) -> None:
    before = signal.getsignal(getattr(signal, name))
    with undisturbed(lambda: None):
        os.kill(os.getpid(), getattr(signal, name))  # it would stop this process
    assert signal.getsignal(getattr(signal, name)) is before


# -- flights ---------------------------------------------------------------------------------------


def fly(folder: Path, stdout: int | IO[str]) -> subprocess.Popen[str]:
    """A flight in lockstep whose output goes somewhere."""
    command = [*UNDRAWN, "sim", HOP, "--speed", "max"]
    return subprocess.Popen(
        [*map(str, command), "--log-dir", str(folder)],
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
    )


def recorded(folder: Path) -> list[FlightEvent]:
    """The events that the only run's folder has."""
    (run,) = folder.iterdir()
    lines = (run / "events.jsonl").read_text(encoding="utf-8").splitlines()
    return [read_line(line).event for line in lines]


def assert_it_flew(flight: subprocess.Popen[str], folder: Path) -> None:
    _, errors = flight.communicate()
    assert (flight.returncode, errors) == (0, "")
    assert recorded(folder)[-1] == TaskSatisfied()


@pytest.mark.long
@pytest.mark.flight
def test_a_flight_outlives_who_reads_its_output(tmp_path: Path) -> None:
    """As in `companion sim ... | head -1`."""
    flight = fly(tmp_path, subprocess.PIPE)
    assert flight.stdout is not None
    flight.stdout.readline()
    flight.stdout.close()
    flight.stdout = None
    assert_it_flew(flight, tmp_path)


@pytest.mark.long
@pytest.mark.flight
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
def test_a_full_disk_under_its_output_stops_no_flight(tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        assert_it_flew(fly(tmp_path, full), tmp_path)


@pytest.mark.flight
def test_a_flight_goes_on_when_the_terminal_hangs_up(tmp_path: Path) -> None:
    flight = fly(tmp_path, subprocess.PIPE)
    assert flight.stdout is not None
    while "at A" not in flight.stdout.readline():
        pass
    flight.send_signal(signal.SIGHUP)
    assert_it_flew(flight, tmp_path)
    assert TerminalHungUp() in recorded(tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
def test_other_commands_say_that_their_output_cannot_be_written() -> None:
    command = [sys.executable, "-m", "companion", "ltl", "F p"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "cannot write the output: No space left on device\n"
