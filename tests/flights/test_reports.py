"""Other programs report events: the paper's mission, with a detector beside the companion."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from lockstep import Lockstep
from ports import free_instance, own_ports
from test_sockets import SPEED, START_S, SURVEILLANCE, Run, run

from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.reports import ReportRefused, ReportUnknown, SignalHeard, SignalSilent
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import TaskSatisfied
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from sitl.world.scenario import read_scenario

__all__ = ["run"]

ROOT = Path(__file__).parents[2]
SEEN = "when: NAMED_VALUE_INT[target].value > 0"
ANSWER_S = 300.0
Report = Callable[[float], list[bytes]]
"""What is reported at a time of the flight."""


def with_reports(text: str) -> str:
    """The paper's mission with a detector that is no MAVLink component."""
    assert SEEN in text
    return text.replace(SEEN, 'when: "EVENT[persons] > 0"\n    for_s: 0.5\n    stale_s: 2')


@pytest.fixture(scope="module")
def mission() -> Mission:
    text = with_reports(SURVEILLANCE.read_text(encoding="utf-8"))
    return load_mission(text, SURVEILLANCE.parent)


class ReportedFlight(Lockstep):
    """A flight beside a program that reports."""

    def __init__(self, mission: Mission, report: Report) -> None:
        world, grid = read_scenario(SURVEILLANCE.with_suffix(".sim.yaml"))
        super().__init__(mission, (world, grid))
        self._report = report

    def reported(self, now_s: float) -> list[bytes]:
        return self._report(now_s)


def persons(number: float) -> list[bytes]:
    return [json.dumps({"persons": number}).encode()]


def test_a_report_is_answered_as_a_signal_of_mavlink_is(mission: Mission) -> None:
    flight = ReportedFlight(mission, lambda now_s: persons(2 if now_s > 30.0 else 0))
    flight.until(lambda: flight.companion.has_ended)
    assert flight.ending == TaskSatisfied()
    assert flight.time_of(MissionEventChanged, event="targetFound") == pytest.approx(30.55, abs=0.1)
    assert flight.of(SkillCompleted, action="upload(r2)")
    assert not flight.of(SignalSilent)


@pytest.mark.long
def test_half_a_second_of_persons_that_is_cut_off_is_none(mission: Mission) -> None:
    """The detector dies as it has seen somebody for 0.3 s; what it saw last is not believed."""
    flight = ReportedFlight(mission, lambda now_s: persons(1) if 20.0 < now_s <= 20.3 else [])
    flight.run(22.2)
    assert [event.kind for event in flight.of(SignalSilent)] == ["silent"]
    flight.run(20.0)
    assert len(flight.of(SignalSilent)) == 2
    assert len(flight.of(SignalHeard)) == 1


@pytest.mark.long
def test_garbage_changes_no_action(mission: Mission) -> None:
    silent = ReportedFlight(mission, lambda _: []).until_reported(PlaceReached, place="B")
    garbage = [b"no", b'{"dogs": 3}', b'{"persons": NaN}', bytes(5000)]
    noisy = ReportedFlight(mission, lambda _: garbage).until_reported(PlaceReached, place="B")
    assert noisy.now_s == silent.now_s
    assert len(noisy.of(ReportUnknown)) == 1
    assert 5 < len(noisy.of(ReportRefused)) < 20
    assert not noisy.of(MissionEventChanged)


@pytest.mark.sockets
def test_the_script_of_the_docs_is_a_detector(run: Run, tmp_path: Path) -> None:
    """docs/missions.md, with a module that counts persons: nobody at first, then two."""
    docs = (ROOT / "docs/missions.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"```python\n(import json.*?)```", docs, re.DOTALL)
    assert len(script.strip().splitlines()) <= 8
    address = tmp_path / "events"
    assert "/run/companion/events" in script
    detector = tmp_path / "detector.py"
    detector.write_text(script.replace("/run/companion/events", str(address)), encoding="utf-8")
    counting = "calls = iter(range(10**9))\ndef persons_in_view(): return 2 * (next(calls) > 50)\n"
    (tmp_path / "my_detector.py").write_text(counting, encoding="utf-8")
    text = with_reports(SURVEILLANCE.read_text(encoding="utf-8"))
    mission = tmp_path / "watched.yaml"
    mission.write_text(text.replace("maps/hall", f"{SURVEILLANCE.parent}/maps/hall"))
    flown = run(
        *("companion", "sim", mission, "--scenario", SURVEILLANCE.with_suffix(".sim.yaml")),
        *(*own_ports(free_instance()), "--events", f"unix:{address}", "--monitor", "off"),
        *("--log-dir", tmp_path / "runs", "--speed", SPEED),
    )
    flown.until_printed("waiting    for a vehicle", START_S)
    with subprocess.Popen([sys.executable, detector], cwd=tmp_path) as program:
        flown.until_printed("target found", ANSWER_S)
        program.kill()
    flown.until_printed("targetFound keeps its last value: EVENT[persons] is silent", ANSWER_S)
    assert flown.exit_code(ANSWER_S) == 0, flown.printed
    assert not address.exists()
