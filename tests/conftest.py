"""The paper's mission for all tests; its routes are found once. No property is timed.

Properties draw the same examples in each run, so that what fails is what was changed; with
EXPLORE=1 they draw new ones, and more.

Tests that fly in the simulator are marked `flight`, and properties `slow`: `scripts/test --fast`
leaves both out.
"""

from __future__ import annotations

import gc
import os
import re
import sys
from collections.abc import Generator, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from commands import Companion, Ended
from drawn import EXPLORES, number
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers
from pictures import not_drawn, truly_drawn
from remembered_searches import searches_remembered

from companion import app, driving
from companion.cli import main
from companion.flights.simulated_world import lockstep, world_of
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.motion.layered_routes import LayeredRoutes
from companion.planning.flight_times import route_map
from companion.record.run_folder import RunFolder
from companion.run_sources.only_run import OnlyRun

# What is drawn would depend on which modules a process has loaded: their constants are mixed in.
providers.is_local_module_file = lambda path: False

settings.register_profile(
    "untimed",
    deadline=None,  # machines are noisy
    derandomize=not EXPLORES,
    max_examples=number(100),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("untimed")

os.environ.setdefault("MAVLINK20", "1")  # pymavlink's connections start in version 1 otherwise

TESTS = Path(__file__).parent
MISSIONS = TESTS.parent / "missions"
API = TESTS.parent / "companion" / "api"
FLIGHTS = (
    TESTS / "flights",
    TESTS / "faults",
    TESTS / "browser",
    API / "auditing.py",
    API / "simulating.py",
)
"""Where all tests fly; those of a module are its doctests."""
FLOWN = frozenset({"section_v_run", "surveillance_run"})
"""Fixtures that fly."""
SIMULATOR = frozenset(
    {
        "companion.api.simulating",
        "companion.flights.simulated_world",
        "sitl.flight.physics",
        "sitl.harness",
        "sitl.simulation",
        "wire",
    }
)
"""Modules with the whole vehicle; a test module that imports from one of them flies it."""


@pytest.hookimpl(tryfirst=True)  # before they are selected
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks what `scripts/test --fast` leaves out, wherever that can be seen."""
    for item in items:
        if flies(item):
            item.add_marker(pytest.mark.flight)
        elif item.path.is_relative_to(TESTS / "properties"):
            item.add_marker(pytest.mark.slow)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """Adds to the failure of a fault campaign the command that repeats it."""
    report = (yield).get_result()
    if report.failed and item.get_closest_marker("faults"):
        report.sections.append(("to repeat it", f"scripts/test -m faults '{item.nodeid}'"))


def flies(item: pytest.Item) -> bool:
    """Whether a test flies in the simulator: by its place, its fixtures, its imports."""
    imported = vars(getattr(item, "module", None) or object).values()
    return (
        any(item.path.is_relative_to(folder) for folder in FLIGHTS)
        or not FLOWN.isdisjoint(getattr(item, "fixturenames", ()))
        or any(getattr(value, "__module__", None) in SIMULATOR for value in imported)
    )


@pytest.fixture(scope="session", autouse=True)
def tests_are_set_aside() -> Generator[None, None, None]:
    """All that was collected is searched for garbage once, and not before each flight again.

    That takes longer than most flights, the longer the more tests have been run. So a flight does
    not end it either; that it collects, and sets aside what is there by then, is shown with the
    true `gc` (tests/unit/test_driving.py).
    """
    gc.collect()
    gc.freeze()
    with pytest.MonkeyPatch.context() as patched:
        nothing = dict.fromkeys(("collect", "freeze", "unfreeze"), lambda: None)
        patched.setattr(driving, "gc", SimpleNamespace(**nothing))
        yield


@pytest.fixture(scope="session", autouse=True)
def runs_are_not_drawn() -> Iterator[None]:
    with not_drawn():
        yield


@pytest.fixture(scope="session", autouse=True)
def maps_are_searched_once() -> Iterator[None]:
    with searches_remembered():
        yield


@pytest.fixture
def drawn() -> Iterator[None]:
    """Runs are drawn, for a test of their pictures."""
    with truly_drawn():
        yield


@pytest.fixture(scope="session")
def surveillance() -> Mission:
    return load_mission(MISSIONS / "surveillance.yaml")


@pytest.fixture(scope="session")
def section_v() -> Mission:
    """The paper's mission, with the task as it is printed."""
    return load_mission(MISSIONS / "paper_section_v.yaml")


@pytest.fixture(scope="session")
def surveillance_routes(surveillance: Mission) -> LayeredRoutes:
    return route_map(surveillance)


@pytest.fixture(scope="session")
def surveillance_run(surveillance: Mission, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of the paper's mission, flown in lockstep; to be read only."""
    return _recorded(surveillance, tmp_path_factory)


@pytest.fixture(scope="session")
def section_v_run(section_v: Mission, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """That of the paper's mission with its task as printed; to be read only."""
    return _recorded(section_v, tmp_path_factory)


def _recorded(mission: Mission, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Flies a mission in its world; the run folder."""
    folder = tmp_path_factory.mktemp("runs") / "run"
    run = RunFolder(folder, mission, 1_700_000_000.0, lambda report: None)
    lockstep(app.Companion(OnlyRun(mission, run)), world_of(mission)).fly()
    run.close()
    return folder


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
