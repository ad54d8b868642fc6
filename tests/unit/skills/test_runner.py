"""Functions in processes of their own: what becomes of each way to end, hang, print and be left."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from offered import installed_in, offer

from companion.outcomes import Failed
from companion.skills import Place, Vehicle, Waypoint, process, runner
from companion.skills.authoring import FunctionKind
from companion.skills.calls import (
    Answer,
    Call,
    CallRequest,
    CommandAsked,
    Function,
    Progressed,
    Returned,
    Value,
    answer_of,
)
from companion.skills.lines import Malformed
from companion.skills.runner import FunctionRunner

pytestmark = pytest.mark.slow
PATIENCE_S = 120.0
CODE = """
import ctypes, os, signal, subprocess, sys, threading, time
from companion.skills import Cancelled, Failed, Waypoint, place_test, skill, suggester

@skill
def act(run, what, *more, **named):
    return globals()["_" + what](run, *more, **named)

def _nothing(run): pass
def _false(run): return False
def _failed(run, text): raise Failed(text)
def _wordless(run): raise Failed
def _raises(run): raise ValueError("first line\\nlast line")
def _exits(run): sys.exit(3)
def _dies(run):
    print("before the end")
    sys.stdout.flush()
    os._exit(3)
def _crashes(run): ctypes.string_at(0)
def _killed(run): os.kill(os.getpid(), signal.SIGKILL)
def _hangs(run): ctypes.PyDLL(None).sleep(1000)  # and no other thread runs
def _eats(run): return bytearray(3 << 30)
def _prints(run):
    print("x" * 300_000)
    print("the end")
def _sleeps(run, seconds): run.sleep(seconds)
def _reports(run):
    run.progress(0.25, "a\\nb")
    run.progress(share=7)
    run.progress(text="\\ud800 half a pair")
def _floods(run):
    while True: run.progress(0.5)
def _commands(run, component):
    run.command(component, "MAV_CMD_DO_GRIPPER", 1, 0)
    run.progress(1.0, "gripped")
def _overflows(run): run.command(25, "MAV_CMD_DO_GRIPPER", 1e39)
def _sees(run):
    place, vehicle = run.places["A"], run.vehicle
    assert (place.north_m, place.lat_deg, vehicle.up_m) == (6.0, 47.0, 2.0)
    open("here.txt", "w").write("written where it runs")
    assert sys.stdin.read() == ""
def _lists(run):
    links = {fd: os.readlink(f"/proc/self/fd/{fd}") for fd in os.listdir("/proc/self/fd")
             if os.path.exists(f"/proc/self/fd/{fd}")}
    print(sorted(links.values()), os.nice(0), os.getpgrp() == os.getpid())
def _cleans(run):
    try:
        while True:
            run.progress(0.1)
            time.sleep(0.01)
    except Cancelled:
        open("cleaned.txt", "w").close()
        raise
def _stays(run, marks):
    signal.signal(signal.SIGTERM, lambda *_: open(marks, "a").write("told\\n"))
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"])
    open(marks, "a").write(f"{child.pid}\\n")
    while True: time.sleep(0.05)

@suggester
def near(run, place, away_m: float = 1.0):
    yield Waypoint(place.east_m + away_m, place.north_m)
    yield place.east_m, place.north_m + away_m, 3.5

@suggester
def odd(run, place): return ["north"]

@place_test
def east(run, place, waypoint): return waypoint.east_m > place.east_m

@place_test
def vague(run, place, waypoint): return None
"""
A = Place("A", 0.0, 6.0, 2.0, 47.0, 8.0, 500.0)
ABOUT: dict[str, Any] = {"places": (A,), "vehicle": Vehicle(0.0, 0.0, 2.0, 90.0, False)}
ACT = Function(FunctionKind.SKILL, "act")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    others = {FunctionKind.SUGGESTER: "near odd", FunctionKind.PLACE_TEST: "east vague"}
    offer(folder, "offered_here", CODE, "act", others)
    offer(folder, "broken", "import no_such_module", "broken")
    offer(folder, "unmarked", "def unmarked(run): pass", "unmarked")
    return folder


@pytest.fixture
def functions(
    site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[FunctionRunner]:
    installed_in(site, monkeypatch)
    made = FunctionRunner(tmp_path, is_lockstep=True)  # it waits, so no time of ours counts
    yield made
    made.close()


def said(functions: FunctionRunner, *arguments: Value, now_s: float = 0.0) -> list[Answer]:
    """All that a call says up to its end."""
    ticket = functions.begin(CallRequest(Call(ACT, arguments), **ABOUT))
    answers = list(functions.take(ticket, now_s))
    while not answers or not isinstance(answers[-1], Returned | Failed):
        answers += functions.take(ticket, now_s)
    return answers


def until(holds: object, what: str) -> None:
    assert callable(holds)
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end_s, what
        time.sleep(0.02)


@pytest.mark.parametrize(
    ("what", "end"),
    [
        (("nothing",), Returned()),
        (("sees",), Returned()),
        (("false",), Failed("it returned False; a skill that has failed raises Failed(text)")),
        (("failed", "2.6 kg\n of 2"), Failed("2.6 kg of 2")),
        pytest.param(("wordless",), Failed("Failed, without a word"), marks=pytest.mark.long),
        (("raises",), Failed("ValueError: last line")),
        pytest.param(("exits",), Failed("SystemExit: 3"), marks=pytest.mark.long),
        (("dies",), Failed("its process ended with exit code 3")),
        pytest.param(
            ("crashes",), Failed("its process was ended by SIGSEGV"), marks=pytest.mark.long
        ),
        (
            ("killed",),
            Failed("its process was ended by SIGKILL, perhaps for want of memory"),
        ),
        (("no_such", 1), Failed("KeyError: '_no_such'")),
        (
            ("overflows",),
            Failed("ValueError: 1e+39 is not a number of single precision, as commands have"),
        ),
    ],
)
def test_each_end_of_a_call_has_its_words(
    functions: FunctionRunner, what: tuple[str, ...], end: Answer
) -> None:
    assert said(functions, *what) == [end]


def test_memory_is_bounded(functions: FunctionRunner) -> None:
    (end,) = said(functions, "eats")
    assert end == Failed("MemoryError: it may use 2048 MiB")


def test_a_process_that_hangs_is_given_up(
    functions: FunctionRunner, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runner, "SILENT_IN_LOCKSTEP_S", 2.0)
    assert said(functions, "hangs") == [Failed("its process hangs: not heard for 2 s")]


def test_what_is_said_on_the_way_is_one_line_each_and_can_be_encoded(
    functions: FunctionRunner,
) -> None:
    assert said(functions, "reports") == [
        Progressed(0.25, "a b"),
        Progressed(1.0, ""),
        Progressed(None, "? half a pair"),
        Returned(),
    ]


def test_a_flood_is_taken_in_parts(functions: FunctionRunner) -> None:
    ticket = functions.begin(CallRequest(Call(ACT, ("floods",)), **ABOUT))
    assert len(functions.take(ticket, 0.0)) in (runner.MESSAGES - 1, runner.MESSAGES)
    assert functions.take(ticket, 0.0) == [Progressed(0.5, "")] * runner.MESSAGES
    functions.cancel(ticket)


def test_a_sleep_is_of_the_flights_clock(functions: FunctionRunner) -> None:
    ticket = functions.begin(CallRequest(Call(ACT, ("sleeps", 3600)), **ABOUT))
    assert functions.take(ticket, 100.0) == []
    assert functions.take(ticket, 3699.9) == []
    assert functions.take(ticket, 3700.0) == [Returned()]


@pytest.mark.parametrize(
    ("failure", "end"), [(None, Progressed(1.0, "gripped")), ("denied", Failed("denied"))]
)
def test_a_command_waits_for_its_reply(
    functions: FunctionRunner, failure: str | None, end: Answer
) -> None:
    ticket = functions.begin(CallRequest(Call(ACT, ("commands", "gripper")), **ABOUT))
    assert functions.take(ticket, 0.0) == [
        CommandAsked("gripper", "MAV_CMD_DO_GRIPPER", (1.0, 0.0))
    ]
    assert functions.take(ticket, 1.0) == []
    functions.reply(ticket, failure)
    assert functions.take(ticket, 2.0)[0] == end


def test_suggesters_and_tests_answer_about_a_place(functions: FunctionRunner) -> None:
    asked = (Waypoint(1.0, 6.0, 2.0), Waypoint(-1.0, 6.0, 2.0))

    def answer(kind: FunctionKind, name: str, *arguments: Value) -> Answer:
        call = Call(Function(kind, name), arguments)
        ticket = functions.begin(CallRequest(call, **ABOUT, place="A", waypoints=asked))
        (end,) = functions.take(ticket, 0.0)
        return end

    proposed = (Waypoint(2.0, 6.0), Waypoint(0.0, 8.0, 3.5))
    assert answer(FunctionKind.SUGGESTER, "near", 2) == Returned(waypoints=proposed)
    assert "write Waypoint(east_m, north_m)" in str(answer(FunctionKind.SUGGESTER, "odd"))
    assert answer(FunctionKind.PLACE_TEST, "east") == Returned(verdicts=(True, False))
    assert "neither True nor False" in str(answer(FunctionKind.PLACE_TEST, "vague"))


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("broken", "broken:broken cannot be imported: ModuleNotFoundError"),
        ("unmarked", "unmarked:unmarked is not marked with @skill"),
        ("missing", "it is not installed"),
    ],
)
def test_what_cannot_be_loaded_says_why_before_the_flight_and_at_a_call(
    functions: FunctionRunner, name: str, says: str
) -> None:
    function = Function(FunctionKind.SKILL, name)
    functions.prepare([function])
    awaited = functions.awaited()
    assert isinstance(awaited, Failed) and says in awaited.reason
    ticket = functions.begin(CallRequest(Call(function)))
    (end,) = functions.take(ticket, 0.0)
    assert isinstance(end, Failed) and says in end.reason


def test_what_is_printed_and_written_stays_in_the_folder_of_the_call(
    functions: FunctionRunner, tmp_path: Path
) -> None:
    said(functions, "dies")
    said(functions, "sees")
    said(functions, "raises")
    said(functions, "prints")
    said(functions, "nothing")
    functions.close()
    kept = {path.parent.name: path.read_text() for path in tmp_path.glob("skills/*/output.txt")}
    assert kept["1-act"] == "before the end\n"
    assert (tmp_path / "skills/2-act/here.txt").exists()
    assert "ValueError: first line" in kept["3-act"]
    assert len(kept["4-act"]) == process.OUTPUT_BYTES + len(process.LEFT_OUT)
    assert not (tmp_path / "skills/5-act").exists()


def test_a_disk_that_takes_no_folder_ends_no_call(
    functions: FunctionRunner, tmp_path: Path
) -> None:
    (tmp_path / "full").touch()
    functions.folder = tmp_path / "full"
    assert said(functions, "nothing") == [Returned()]


def test_a_process_has_nothing_of_the_companion(functions: FunctionRunner, tmp_path: Path) -> None:
    with open(os.devnull) as unrelated:
        os.set_inheritable(unrelated.fileno(), True)
        said(functions, "lists")
    functions.close()
    printed = (tmp_path / "skills/1-act/output.txt").read_text()
    assert printed.count("pipe:") == 4  # orders, answers, and output twice
    assert "socket:" not in printed
    assert printed.split()[-2:] == [str(min(19, os.nice(0) + 10)), "True"]


def test_a_call_that_is_left_may_clean_up(functions: FunctionRunner, tmp_path: Path) -> None:
    ticket = functions.begin(CallRequest(Call(ACT, ("cleans",)), **ABOUT))
    functions.take(ticket, 0.0)
    functions.cancel(ticket)
    functions.cancel(ticket)
    functions.close()
    assert (tmp_path / "skills/1-act/cleaned.txt").exists()


def is_gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def test_one_that_does_not_listen_is_told_by_sigterm_then_killed_with_what_it_has_started(
    functions: FunctionRunner, tmp_path: Path
) -> None:
    marks = tmp_path / "marks"
    ticket = functions.begin(CallRequest(Call(ACT, ("stays", str(marks))), **ABOUT))
    until(lambda: marks.exists() and marks.read_text().strip(), "it does not begin")
    pid = int(marks.read_text().split()[0])
    functions.cancel(ticket)
    functions.close()
    assert marks.read_text().split()[1:] == ["told"]
    assert is_gone(pid)


def test_all_end_with_a_companion_that_is_killed(site: Path, tmp_path: Path) -> None:
    marks = tmp_path / "marks"
    program = (
        "import sys, time\n"
        "from companion.skills.runner import *\n"
        "from companion.skills.calls import *\n"
        "from companion.skills.authoring import FunctionKind\n"
        "runner = FunctionRunner()\n"
        "function = Function(FunctionKind.SKILL, 'act')\n"
        "runner.begin(CallRequest(Call(function, ('stays', sys.argv[1]))))\n"
        "print(*[p._child.pid for p in (*runner._spares.values(), runner._calls[1].process)])\n"
        "sys.stdout.flush()\n"
        "time.sleep(1000)\n"
    )
    environment = os.environ | {"PYTHONPATH": str(site)}
    companion = subprocess.Popen(
        [sys.executable, "-c", program, str(marks)], stdout=subprocess.PIPE, env=environment
    )
    assert companion.stdout is not None
    pids = [int(word) for word in companion.stdout.readline().split()]
    until(lambda: marks.exists() and marks.read_text().strip(), "it does not begin")
    os.kill(companion.pid, signal.SIGKILL)
    companion.wait()
    companion.stdout.close()
    for pid in pids:
        until(lambda pid=pid: is_gone(pid), "it outlives the companion")
    os.kill(int(marks.read_text().split()[0]), signal.SIGKILL)  # see docs/skills.md


def test_in_real_time_nothing_waits(
    site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed_in(site, monkeypatch)
    functions = FunctionRunner(tmp_path)
    functions.prepare([ACT])
    assert functions.awaited() == ("act",)
    until(lambda: functions.awaited() == (), "it is not loaded")
    ticket = functions.begin(CallRequest(Call(ACT, ("nothing",)), **ABOUT))
    answers: list[Answer] = []

    def has_answered() -> bool:
        answers.extend(functions.take(ticket, 0.0))
        return bool(answers)

    until(has_answered, "it does not end")
    assert answers == [Returned()]
    functions.prepare([])
    functions.end_calls()
    functions.close()


@pytest.mark.parametrize("parameters", [[1e39], [float("-inf")], [0.0] * 8])
def test_a_process_that_asks_for_what_no_command_carries_is_not_believed(
    parameters: list[float],
) -> None:
    """Whatever its process writes, also past `run.command`."""
    asked = {"is": "command", "component": 25, "command": "MAV_CMD_DO_GRIPPER"}
    with pytest.raises(Malformed):
        answer_of({**asked, "parameters": parameters})
