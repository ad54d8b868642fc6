"""What `companion plan` and `companion check` tell of a battery, and refuse with one."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from commands import Companion

MISSION = """\
version: 1
name: two_sites
limits: {speed_mps: 5, up_m: [1, 15], fence: [[-20, -20], [120, -20], [120, 120], [-20, 120]]}
battery: {reserve: 20, capacity_wh: 20}
places:
  Home: {east_m: 0, north_m: 0, up_m: 6}
  A: {east_m: 100, north_m: 0, up_m: 6}
  B: {east_m: 100, north_m: 100, up_m: 6}
  Dock: {east_m: 50, north_m: 50, up_m: 4}
sets:
  Place: [Home, A, B, Dock]
  Pad: [Dock]
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    effect: at(to) & !at(from)
    execute: fly(to)
  recharge:
    parameters: {pad: Pad}
    precondition: at(pad)
    effect: at(pad)
    charge_rate: [[0, 1], [80, 1], [100, 0.1]]
    execute: [land(), charge(auto), take_off()]
initially: [at(Home)]
task: {patrol: "patrolling(A, B)"}
"""


def written(folder: Path, text: str = MISSION) -> Path:
    path = folder / "two_sites.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_plan_says_what_it_takes_and_how_far_it_charges(
    companion: Companion, tmp_path: Path
) -> None:
    lines = companion("plan", written(tmp_path)).out.splitlines()
    flight = next(line for line in lines if "move(" in line)
    assert flight.endswith(" Wh")
    charge = next(line for line in lines if "recharge(Dock)" in line)
    assert "charges to " in charge
    (energy,) = [line for line in lines if line.startswith("energy ")]
    assert energy.endswith("on the ground at Dock; the reserve is 20.0 %")


def test_json_has_the_energy_of_each_step(companion: Companion, tmp_path: Path) -> None:
    answer = json.loads(companion("plan", written(tmp_path), "--json").out)
    steps = [*answer["prefix"], *answer["loop"]]
    (charge,) = [step for step in steps if step["skill"] == "recharge"]
    assert charge["takes_wh"] is None
    assert charge["required_percent"] == 23  # the reserve, and to land from 4 m
    assert charge["required_percent"] < charge["charge_to_percent"] < 50
    flights = [step for step in steps if step["skill"] == "move"]
    assert all(step["takes_wh"] > 0 and step["charge_to_percent"] is None for step in flights)
    lap_wh = sum(step["takes_wh"] or 0 for step in answer["loop"])
    assert lap_wh < answer["energy"]["lap_wh"] < lap_wh + 2  # it lands and takes off, too
    assert 20 <= answer["energy"]["least_percent"] < 21
    assert answer["energy"]["least_at"] == "on the ground at Dock"


def test_a_plan_that_rests_says_what_is_left_on_the_ground(
    companion: Companion, tmp_path: Path
) -> None:
    text = MISSION.replace('"patrolling(A, B)"', '"F at(A) & F G at(Home)"')
    answer = json.loads(companion("plan", written(tmp_path, text), "--json").out)
    assert [step["takes_wh"] for step in answer["loop"]] == [None]
    assert answer["energy"]["lap_wh"] == 0
    assert answer["energy"]["least_at"] == "on the ground at Home"
    assert 50 < answer["energy"]["least_percent"] < 90


def test_a_mission_without_a_battery_is_told_as_ever(companion: Companion, tmp_path: Path) -> None:
    text = MISSION.replace("battery: {reserve: 20, capacity_wh: 20}\n", "")
    text = text.replace("charge(auto)", "charge(50)")
    text = text.replace("    charge_rate: [[0, 1], [80, 1], [100, 0.1]]\n", "")
    path = written(tmp_path, text)
    assert "energy" not in companion("plan", path).out
    answer = json.loads(companion("plan", path, "--json").out)
    assert "energy" not in answer
    assert set(answer["loop"][0]) == {"action", "skill", "arguments", "cost_s"}
    assert json.loads(companion("check", path, "--json").out)["energy"] is None


def test_a_check_says_how_far_the_plan_charges(companion: Companion, tmp_path: Path) -> None:
    path = written(tmp_path)
    (line,) = [
        line for line in companion("check", path).out.splitlines() if line.startswith("energy ")
    ]
    told = json.loads(companion("check", path, "--json").out)["energy"]
    assert line == f"energy     {told}"
    assert told.startswith("a lap takes ")
    assert "; recharge(Dock) to " in told


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (["--objective", "sum"], "the objective sum is not for missions with a battery"),
        (["--objective", "bottleneck"], "leave the objective out"),
        (["--engine", "fast-downward"], "the engine fast-downward knows of no energy"),
        (["--pddl", "pddl"], "PDDL is written without energy"),
    ],
)
def test_what_knows_of_no_energy_is_refused(
    companion: Companion, tmp_path: Path, options: list[str], what: str
) -> None:
    ended = companion("plan", written(tmp_path), *options)
    assert ended.code == 2
    assert what in ended.err


def test_a_flight_with_an_engine_is_refused_before_it_begins(
    companion: Companion, tmp_path: Path
) -> None:
    options = ["--speed", "max", "--engine", "fast-downward"]
    ended = companion("sim", written(tmp_path), *options)
    assert ended.code == 2
    assert "the engine fast-downward knows of no energy" in ended.err
    assert "arming" not in ended.out


def test_a_tree_by_hand_is_refused_with_a_battery(companion: Companion, tmp_path: Path) -> None:
    path = written(tmp_path, MISSION + 'tree: ["move(Home, A)"]\n')
    ended = companion("check", path)
    assert ended.code == 2
    assert "two_sites.yaml:4:1: a tree by hand keeps no reserve of the battery" in ended.err


def test_a_charge_that_is_too_little_for_anything_is_told(
    companion: Companion, tmp_path: Path
) -> None:
    """No line of the task is the reason: not even rest has a plan."""
    path = written(tmp_path, MISSION.replace("capacity_wh: 20", "capacity_wh: 0.5"))
    ended = companion("plan", path)
    assert ended.code == 3
    assert "no plan: nothing that begins here ends safely, the reserve left" in ended.err
