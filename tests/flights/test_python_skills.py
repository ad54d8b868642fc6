"""Skills in Python: the template package, installed and flown; and what interrupts a call."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from commands import Companion
from lockstep import Lockstep
from offered import TEMPLATE, install_template, installed_in
from ports import free_instance
from ruamel.yaml import YAML
from scripted_functions import ScriptedFunctions

from companion import load_mission, simulate
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import (
    FunctionsAwaited,
    OutcomeUnknown,
    PlaceReached,
    SkillCompleted,
    SkillFailed,
    SkillProgressed,
    SymbolMoved,
)
from companion.flight_events.sortie import ControlYielded, Phase, RunFailed, TaskSatisfied
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.outcomes import Failed
from companion.skills.calls import Answer, Progressed, Returned

WEIGHING = TEMPLATE / "weighing.yaml"
PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
COMPANION = 191
DONE: list[tuple[float, Answer]] = [(1.0, Progressed(0.5, "half")), (2.0, Returned())]
NEVER: list[tuple[float, Answer]] = []
ANSWER_S = 300.0


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("template")
    install_template(folder)
    return folder / "site"


# -- the template ------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_template_flies(site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed_in(site, monkeypatch)
    run = simulate(load_mission(WEIGHING), seed=3, folder=tmp_path)
    told = [stamped.event for stamped in run.events]
    assert run.exit_code == 0
    moved = {event.place: event.source for event in told if isinstance(event, SymbolMoved)}
    assert moved == {"Rack": "beside", "Shelf": "beside"}
    assert SkillFailed("weigh(Rack)", "2.6 kg, and the limit is 2 kg") in told
    assert BeliefWithdrawn("light(Rack)") in told
    assert SkillProgressed("weigh(Shelf)", 10, "1.4 kg") in told
    assert SkillCompleted("weigh(Shelf)") in told
    begun_s, end_s = (
        next(s.time_s for s in run.events if s.event == event)
        for event in (PlaceReached("Shelf", "move(Rack, Shelf)"), SkillCompleted("weigh(Shelf)"))
    )
    assert end_s - begun_s == pytest.approx(2.0, abs=0.11)  # ten sleeps of 0.2 s, and no other time
    (printed,) = ((tmp_path / "skills").glob("*-weigh/output.txt"),)
    assert sorted(path.read_text() for path in printed) == ["Rack: 2.60 kg\n", "Shelf: 1.40 kg\n"]


@pytest.mark.long
def test_equal_seeds_give_equal_events(
    site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed_in(site, monkeypatch)
    mission = load_mission(WEIGHING)
    for name in ("one", "two"):
        simulate(mission, seed=3, folder=tmp_path / name)
    lines = [(tmp_path / name / "events.jsonl").read_bytes() for name in ("one", "two")]
    assert lines[0] == lines[1]


def in_a_process(site: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "companion", *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": str(site)}
    return subprocess.run(
        command, capture_output=True, text=True, env=environment, timeout=ANSWER_S, check=False
    )


@pytest.mark.slow
def test_the_command_line_knows_what_is_installed(
    site: Path, companion: Companion, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = companion("check", WEIGHING)
    assert refused.code == 2
    assert f"{WEIGHING}:42:14: the skill weigh is not installed" in refused.err
    assert companion("skills").out.startswith("no installed package offers any")
    installed_in(site, monkeypatch)
    offers = json.loads(companion("skills", "--json").out)
    assert {each["name"] for each in offers} == {"weigh", "beside", "out_of_downwash"}
    assert companion("check", WEIGHING).code == 0
    assert "weigh(Rack)" in companion("plan", WEIGHING).out
    listed = in_a_process(site, "skills")
    assert "python(weigh, place: str, limit_kg: float = 2.0)    scale-skill 1.0" in listed.stdout


@pytest.mark.sockets
@pytest.mark.long  # test_uploaded_skills.py flies it over sockets, too
def test_the_template_flies_over_sockets(site: Path, tmp_path: Path) -> None:
    options: list[str | Path] = ["--speed", "2", "--log-dir", tmp_path, "--monitor", "off"]
    options += ["--instance", str(free_instance())]
    flown = in_a_process(site, "sim", WEIGHING, *options)
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert "weigh(Shelf) done" in flown.stdout
    assert "weigh(Rack) failed: 2.6 kg, and the limit is 2 kg" in flown.stdout


# -- what interrupts a call --------------------------------------------------------------------


def weighing(**skill: Any) -> Any:
    """The mission without suggesters and tests; its operator may send an event."""
    data: dict[str, Any] = YAML(typ="safe").load(WEIGHING.read_text(encoding="utf-8"))
    for place in data["places"].values():
        place.pop("suggesters", None)
        place.pop("tests", None)
    data["skills"]["weigh"] |= {"timeout_s": 60} | skill
    data["events"] = {"calledOff": {"when": "COMMAND.MAV_CMD_USER_1", "latch": True}}
    data["task"]["choose"] = "F (chosenOne | calledOff)"
    return data


def flight(functions: ScriptedFunctions, data: Any = None, **options: Any) -> Lockstep:
    mission = load_mission(data or weighing(), installed=None)
    return Lockstep(mission, world_of(mission), functions=functions, **options)


def under_way(flown: Lockstep, functions: ScriptedFunctions, calls: int = 1) -> Lockstep:
    return flown.until(lambda: len(functions.requests) == calls).run_for(1.0)


def test_a_call_is_a_skill_like_others() -> None:
    functions = ScriptedFunctions(DONE)
    flown = flight(functions).until_the_end()
    assert flown.ending == TaskSatisfied()
    assert [function.name for function in functions.prepared] == ["weigh"]
    assert [request.call.text for request in functions.requests] == [
        "python(weigh, Rack, limit_kg=2.0)"
    ]
    assert flown.of(SkillProgressed) == [SkillProgressed("weigh(Rack)", 50, "half")]
    assert functions.cancelled == []


def test_an_event_in_the_middle_of_a_call_cancels_it() -> None:
    functions = ScriptedFunctions(NEVER)
    flown = under_way(flight(functions, has_station=True), functions)
    flown.station_commands(dialect.MAV_CMD_USER_1, component=COMPANION)
    flown.until_reported(PlanReplaced)
    assert functions.cancelled == [1]
    assert flown.until_the_end().ending == TaskSatisfied()


def test_a_pause_cancels_it_and_going_on_calls_anew() -> None:
    functions = ScriptedFunctions(NEVER, DONE)
    flown = under_way(flight(functions, has_station=True), functions)
    flown.station_commands(PAUSE, 0.0, component=COMPANION)
    flown.run(2.0)
    assert functions.cancelled == [1]
    flown.station_commands(PAUSE, 1.0, component=COMPANION)
    assert flown.until_the_end().ending == TaskSatisfied()
    assert len(functions.requests) == 2


def test_a_pilot_who_takes_over_cancels_it() -> None:
    functions = ScriptedFunctions(NEVER)
    flown = under_way(flight(functions, has_station=True), functions)
    flown.station_chooses("AUTO.LOITER")
    flown.until_the_end()
    assert isinstance(flown.ending, RunFailed)
    assert flown.of(ControlYielded) == [] and functions.cancelled == [1]


def test_a_stop_cancels_it_and_lands() -> None:
    functions = ScriptedFunctions(NEVER)
    flown = under_way(flight(functions), functions)
    flown.companion.stop()
    flown.run(0.2)
    assert functions.cancelled == [1]
    flown.until_the_end()


def test_its_tries_and_its_time_are_those_of_the_skill() -> None:
    functions = ScriptedFunctions(NEVER, [(0.5, Failed("too dark"))], DONE)
    flown = flight(functions, weighing(tries=3, timeout_s=4)).until_the_end()
    assert flown.ending == TaskSatisfied()
    assert len(functions.requests) == 3 and functions.cancelled == [1]
    assert flown.of(SkillFailed) == []


def test_the_flight_begins_when_the_functions_are_loaded() -> None:
    functions = ScriptedFunctions(DONE)
    functions.loading = ("weigh",)
    flown = flight(functions).run_for(10.0)
    assert flown.of(FunctionsAwaited) == [FunctionsAwaited(("weigh",))]
    assert flown.companion._run is not None and flown.companion._run.sortie.phase is Phase.WAITING
    beats = [s for s in flown.said if s.message.get_type() == "HEARTBEAT"]
    assert len(beats) >= 9
    functions.loading = ()
    assert flown.until_the_end().ending == TaskSatisfied()


def test_a_function_that_cannot_be_loaded_ends_it_on_the_ground() -> None:
    functions = ScriptedFunctions(DONE)
    functions.loading = Failed("weigh: it is not installed")
    flown = flight(functions).until_the_end()
    assert flown.exit_code == 5 and flown.armings == 0
    assert "weigh: it is not installed" in flown.ending.text


@pytest.mark.long
def test_a_tree_by_hand_calls_it_too() -> None:
    data = weighing()
    del data["task"], data["events"]
    data["tree"] = ["move(Home, Shelf)", "weigh(Shelf)", "move(Shelf, Home)"]
    functions = ScriptedFunctions(DONE)
    flown = flight(functions, data).until_the_end()
    assert flown.exit_code == 0
    assert [request.call.arguments for request in functions.requests] == [("Shelf",)]


@pytest.mark.parametrize("repeatable", [False, True])
def test_after_a_restart_a_call_without_an_outcome_is_told_and_not_made_again_unless_it_may_be(
    repeatable: bool,
) -> None:
    functions = ScriptedFunctions(NEVER, DONE)
    data = weighing(repeatable=repeatable)
    flown = under_way(flight(functions, data, has_station=True, resumes=True), functions)
    flown.kill()
    flown.run(3.0)
    flown.restart()
    assert flown.until_the_end().ending == TaskSatisfied()
    (unknown,) = flown.of(OutcomeUnknown)
    assert unknown.action == "weigh(Rack)"
    assert functions.requests[1].call.arguments == (("Rack",) if repeatable else ("Shelf",))
