"""The paper's mission for all tests; its routes are found once. No property is timed."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from commands import Companion, Ended
from hypothesis import settings

from companion.app import Companion as Flier
from companion.cli import main
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.motion.routes import RouteMap
from companion.planning.flight_times import route_map
from companion.record.run_folder import RunFolder
from sitl.harness import fly_in_lockstep
from sitl.link.routing import LinkName
from sitl.simulation import Simulation
from sitl.world.scenario import read_scenario

settings.register_profile("untimed", deadline=None)  # machines are noisy
settings.load_profile("untimed")

MISSIONS = Path(__file__).parents[1] / "missions"


@pytest.fixture(scope="session")
def surveillance() -> Mission:
    return load_mission(MISSIONS / "surveillance.yaml")


@pytest.fixture(scope="session")
def surveillance_routes(surveillance: Mission) -> RouteMap:
    return route_map(surveillance)


@pytest.fixture(scope="session")
def surveillance_run(surveillance: Mission, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of the paper's mission, flown in lockstep; to be read only."""
    scenario, grid = read_scenario(MISSIONS / "surveillance.sim.yaml")
    run = RunFolder(
        tmp_path_factory.mktemp("runs") / "run", surveillance, 1_700_000_000.0, lambda report: None
    )
    simulation = Simulation(scenario, grid, seed=0, links=frozenset({LinkName.OFFBOARD}))
    fly_in_lockstep(Flier(surveillance, run), simulation)
    run.close()
    return run.folder


@pytest.fixture
def companion(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Companion:
    """Runs `companion ARGUMENTS` in this process."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("COMPANION_LOG_DIR", str(tmp_path / "runs"))
    monkeypatch.delenv("COMPANION_CONNECT", raising=False)

    def run(*arguments: object) -> Ended:
        monkeypatch.setattr(sys, "argv", ["companion", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main()
        captured = (re.sub(r"\x1b\[[\d;]*m", "", text) for text in capsys.readouterr())
        return Ended(int(end.value.code or 0), *captured)

    return run
