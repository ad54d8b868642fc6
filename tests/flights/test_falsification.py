"""A failure is found, made simple, and repeated by its file alone: from the command to the line."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from commands import Companion
from ruamel.yaml import YAML
from varied import MISSION

pytestmark = pytest.mark.long

SCENARIO = f"""
version: 1
map: {MISSION.parent / "maps/hall.yaml"}
battery: {{charge: 0.9}}
happens:
  - {{at_s: 2, operator: MAV_CMD_NAV_RETURN_TO_LAUNCH}}
  - {{at_s: 1, gps: {{noise_m: 0.2}}}}
vary:
  wind.east_mps: [-2, 2]
  battery.charge: [0.02, 1]
  happens.1.gps.noise_m: [0, 0.3]
"""


def test_a_battery_that_is_empty_is_found_and_told(companion: Companion, tmp_path: Path) -> None:
    scenario, out = tmp_path / "varied.sim.yaml", tmp_path / "out"
    scenario.write_text(SCENARIO)
    searched = (MISSION, "--scenario", scenario, "--budget", 16, "--limit-s", 60, "--out", out)
    ended = companion("falsify", *searched)
    assert ended.code == 6
    assert "in a fresh process: the same" in ended.out and "NOT repeated" not in ended.out
    file = next((out / "failures").iterdir())
    case = YAML(typ="safe").load(file.read_text())
    assert "vary" not in case and "wind" not in case and case["battery"]["charge"] < 0.9
    line = next(line for line in ended.out.splitlines() if line.startswith("repeat "))
    program, *arguments = shlex.split(line.removeprefix("repeat "))
    assert program == "companion"
    assert companion(*arguments).code != 0
    again = companion("falsify", *searched)
    assert again.code == 6 and again.out == ended.out
