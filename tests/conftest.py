"""The paper's mission for all tests; its routes are found once. No property is timed."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import settings

from companion.app import route_map
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.motion.routes import RouteMap

settings.register_profile("untimed", deadline=None)  # machines are noisy
settings.load_profile("untimed")

MISSIONS = Path(__file__).parents[1] / "missions"


@pytest.fixture(scope="session")
def surveillance() -> Mission:
    return load_mission(MISSIONS / "surveillance.yaml")


@pytest.fixture(scope="session")
def surveillance_routes(surveillance: Mission) -> RouteMap:
    return route_map(surveillance)
