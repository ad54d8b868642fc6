"""Children that check missions: confined, ready beforehand, replaced, and read with care."""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from companion.cli.check_child import CPU_S, MEMORY_BYTES, BoundedCheck
from companion.ground import checking
from companion.ground.checking import MAX_OUTPUT_BYTES, CheckChild, CheckChildren, CheckResult
from companion.skills.authoring import FunctionKind
from companion.skills.calls import Function
from companion.skills.catalogue import Installed, Parameter

pytestmark = pytest.mark.slow

MISSIONS = Path(__file__).parents[3] / "missions"
LOST_PERSON = MISSIONS / "lost_person.yaml"
WEIGHING = MISSIONS.parent / "docs" / "examples" / "scale_skill" / "weighing.yaml"
RUN, PLACE, WAYPOINT, LIMIT, AWAY = (
    Parameter(name, "POSITIONAL_OR_KEYWORD", default, "")
    for name, default in (
        ("run", None),
        ("place", None),
        ("waypoint", None),
        ("limit_kg", "2.0"),
        ("away_m", "1.0"),
    )
)
INSTALLED = {
    each.function: [each]
    for each in (
        Installed(Function(FunctionKind.SKILL, "weigh"), "a 1", (RUN, PLACE, LIMIT)),
        Installed(Function(FunctionKind.SUGGESTER, "beside"), "a 1", (RUN, PLACE, AWAY)),
        Installed(
            Function(FunctionKind.PLACE_TEST, "out_of_downwash"),
            "a 1",
            (RUN, PLACE, WAYPOINT, AWAY),
        ),
    )
}
LIMIT_S = 300.0  # wall time that no check needs


@pytest.fixture
def children() -> Iterator[CheckChildren]:
    with closing(CheckChildren()) as children:
        yield children


def test_an_uploaded_mission_may_call_what_was_installed_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A check loads no package: it is told what is installed."""
    answer = answer_of_one(CheckChildren(INSTALLED), WEIGHING)
    assert answer.is_good and "weigh(Rack)" in answer.text
    monkeypatch.chdir(WEIGHING.parent)
    without = BoundedCheck(Path(WEIGHING.name)).answer()
    assert not without["ok"] and "is not installed" in without["error"]


@pytest.mark.parametrize("hears_reports", [pytest.param(True, marks=pytest.mark.long), False])
def test_reports_that_nobody_hears_are_noticed(hears_reports: bool) -> None:
    answer = answer_of_one(CheckChildren(hears_reports=hears_reports), LOST_PERSON)
    unheard = "not heard: EVENT[person]; --events says where other programs report"
    assert answer.is_good
    assert answer.notices == (() if hears_reports else (unheard,))


def answer_of_one(children: CheckChildren, mission: Path) -> CheckResult:
    """What the first of them answers; the next one is ended before it has loaded much."""
    check = children.begin(mission.parent, mission.name)
    children.close()
    return answer_of(check)


def answer_of(check: checking.MissionCheck) -> CheckResult:
    end_s = time.monotonic() + LIMIT_S
    while (answer := check.poll()) is None:
        assert time.monotonic() < end_s
        time.sleep(0.02)
    return answer


def a_child(program: str, monkeypatch: pytest.MonkeyPatch) -> CheckChild:
    """A child that runs another program."""
    command = [sys.executable, "-c", program]
    monkeypatch.setattr(checking, "python_module", lambda module: command)
    child = CheckChild()
    child.order(Path("/nowhere"), "a.yaml")
    return child


def test_each_checks_one_mission_and_the_next_is_ready(children: CheckChildren) -> None:
    for name in ("surveillance.yaml", "none.yaml"):
        spare = children._spare
        check = children.begin(MISSIONS, name)
        assert check is spare and children._spare is not spare
        answer = answer_of(check)
        assert answer.is_good is (name != "none.yaml")
        assert ("No such file" in answer.text) is (name == "none.yaml")
        assert not spare.is_running


@pytest.mark.long
def test_a_spare_that_has_died_is_replaced(children: CheckChildren) -> None:
    dead = children._spare
    dead.kill()
    dead._child.wait()
    check = children.begin(MISSIONS, "surveillance.yaml")
    children.close()
    assert check is not dead
    assert answer_of(check).is_good


def test_one_that_dies_with_the_order_is_told(children: CheckChildren) -> None:
    check = CheckChild()
    os.kill(check._child.pid, signal.SIGSTOP)
    check.order(MISSIONS, "surveillance.yaml")
    os.kill(check._child.pid, signal.SIGKILL)
    answer = answer_of(check)
    assert answer == CheckResult(False, "the check was ended: it takes too much time or memory")


def test_nobody_s_child_ends_by_itself() -> None:
    """The flight process was killed: its end of the pipe is closed."""
    child = CheckChild()
    child._orders.close()
    assert child._child.wait(LIMIT_S) == 0
    child.close()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux shows them, in /proc")
def test_it_has_limits_before_it_reads_anything(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")  # reading it waits for ever
    check = CheckChild()
    check.order(tmp_path, "pipe.yaml")
    process, end_s = Path(f"/proc/{check._child.pid}"), time.monotonic() + LIMIT_S
    while not re.search(r"Max cpu time +\d", limits := (process / "limits").read_text()):
        assert time.monotonic() < end_s
        time.sleep(0.02)
    cpu_s = re.search(r"Max cpu time +(\d+) +(\d+)", limits)
    assert cpu_s is not None and int(cpu_s[1]) >= CPU_S and int(cpu_s[2]) == int(cpu_s[1]) + 1
    assert re.search(f"Max data size +{MEMORY_BYTES} +{MEMORY_BYTES}", limits)
    assert re.search(f"Max file size +{MAX_OUTPUT_BYTES}", limits)
    assert re.search("Max core file size +0 +0", limits)
    assert check.poll() is None
    check.kill()
    told = "the check was ended: it takes too much time or memory"
    assert answer_of(check).text in (told, f"{told}, for reading it")


def test_a_child_that_prints_without_end_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    child = a_child("while True: print('x' * 9999)", monkeypatch)
    assert not answer_of(child).is_good
    assert len(child._printed) == MAX_OUTPUT_BYTES


@pytest.mark.parametrize(
    "printed",
    [
        "",
        "[]",
        "7",
        "null",
        '{"ok": true}',
        '{"ok": true, "plan": "a"}\n{}',
        '{"ok": "true", "error": "?"}',
        '{"doing": [1]}',
        "\\xff",
        "[" * 5000,
    ],
)
def test_what_is_no_answer_accepts_nothing(monkeypatch: pytest.MonkeyPatch, printed: str) -> None:
    assert not answer_of(a_child(f"print('''{printed}''')", monkeypatch)).is_good


def test_an_answer_counts_only_with_the_exit_code_0(monkeypatch: pytest.MonkeyPatch) -> None:
    said = json.dumps({"ok": True, "plan": "a", "error": "?"})
    assert answer_of(a_child(f"print('{said}')", monkeypatch)).is_good
    assert not answer_of(a_child(f"print('{said}'); exit(1)", monkeypatch)).is_good


def test_the_work_of_a_check_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Surveillance takes a tenth of a second of it; the count names what it was at."""
    monkeypatch.chdir(MISSIONS)
    assert BoundedCheck(Path("surveillance.yaml"), work_s=0.5).answer()["ok"]
    fewer = BoundedCheck(Path("surveillance.yaml"), work_s=0.001).answer()
    assert fewer["error"].splitlines()[0] == (
        "it takes more than 0.001 s of work to check it; given up at its routes, actions and "
        "automata"
    )
