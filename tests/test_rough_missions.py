"""The rough world of every shipped mission is one that can be flown."""

from __future__ import annotations

from pathlib import Path

import pytest
import rough_missions
from ruamel.yaml import YAML

from companion.flights.simulated_world import varied_world_of
from companion.mission.loader import load_mission

SHIPPED = [p for p in sorted(rough_missions.MISSIONS.glob("*.yaml")) if ".sim" not in p.suffixes]


@pytest.mark.parametrize(
    "mission",
    [
        pytest.param(path, marks=[pytest.mark.long] if number % 4 else [])
        for number, path in enumerate(SHIPPED)
    ],
    ids=lambda path: path.stem,
)
def test_it_varies_and_is_read(mission: Path, tmp_path: Path) -> None:
    scenario = tmp_path / "rough.sim.yaml"
    with scenario.open("w", encoding="utf-8") as stream:
        YAML().dump(rough_missions.rough_world(mission), stream)
    world = varied_world_of(load_mission(mission), scenario)
    assert len(world.factors) >= len(rough_missions.ROUGH) + 2


def test_rows_are_shared_out() -> None:
    shares = rough_missions.shares(["surveillance", "corridor", "endless_patrol"], 230)
    assert shares == {"surveillance": 100, "corridor": 100, "endless_patrol": 30}
