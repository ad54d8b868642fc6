"""The world of the surveillance mission, read once."""

from __future__ import annotations

from pathlib import Path

import pytest
from lockstep import World

from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="session")
def hall() -> World:
    return read_scenario(MISSIONS / "surveillance.sim.yaml")
