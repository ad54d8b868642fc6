"""The paper's claim: planners off the shelf, in the loop, from the first plan to the landing."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import bad_engines
import pytest
from happened import Happened
from short_hall import blind, seen_soon

from companion.acting.journal import NoJournal
from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.plans import EngineFailed, PlanReplaced
from companion.flight_events.sortie import TaskSatisfied
from companion.flights.simulated_world import lockstep, world_of
from companion.geometry import Ned
from companion.mission.loader import load_mission
from companion.outcomes import Failed
from companion.planning import engine_process
from companion.planning.engine_jobs import EngineJobs
from companion.planning.engine_port import Engine, EngineJob
from companion.planning.engines import EngineTimeout
from companion.planning.lasso import Lasso, Letter, Problem
from companion.planning.objective import Encoding
from companion.run_sources.only_run import OnlyRun
from companion.vehicle.run_clocks import ClockReading

MISSION = Path(__file__).parents[2] / "missions" / "paper_section_v.yaml"
DURATION_S = 1.5
TIMEOUT_S = 300.0

pytestmark = [
    pytest.mark.flight,
    pytest.mark.skipif(
        find_spec("up_fast_downward") is None, reason="the extra `planners` is not installed"
    ),
]


class Flown(Happened):
    """A flight of the paper's mission, seed 0, with all that happened: the target is found soon."""

    journal = NoJournal()
    name = ""

    def __init__(self, engine: Engine) -> None:
        self.reports: list[Stamped] = []
        mission = load_mission(MISSION)
        companion = Companion(OnlyRun(mission, self, engine=engine))
        world = blind(seen_soon(world_of(mission)))
        lockstep(companion, world, keeps_packets=False).fly()

    def report(self, stamped: Stamped) -> None:
        self.reports.append(stamped)

    def clocks(self, reading: ClockReading) -> None:
        """Not read."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Not needed."""

    def position(self, now_s: float, position: Ned) -> None:
        """Not needed."""


@pytest.mark.parametrize(
    ("engine", "encoding"),
    [
        pytest.param("fast-downward", Encoding.V1, marks=pytest.mark.long),
        ("fast-downward", Encoding.V4),
        pytest.param("pyperplan", Encoding.V5, marks=pytest.mark.long),
    ],
)
def test_the_paper_s_mission_is_flown_by_planners_off_the_shelf(
    engine: str, encoding: Encoding
) -> None:
    """Two replans: the target is found, and r1 refuses the upload; then home."""
    flown = Flown(EngineJobs(engine, encoding, TIMEOUT_S, DURATION_S))
    found, refused = flown.of(PlanReplaced)
    assert found.reason == "target found"
    assert str(found.plan) == "move(here, r1), upload(r1), move(r1, Home), (wait)^w"
    assert str(refused.plan) == "move(r1, r2), upload(r2), move(r2, Home), (wait)^w"
    assert flown.places[-3:] == ["r1", "r2", "Home"]
    assert flown.one(TaskSatisfied) and not flown.of(EngineFailed)


@pytest.mark.long
def test_equal_seeds_have_equal_events() -> None:
    one, other = (Flown(EngineJobs("fast-downward", Encoding.V4, TIMEOUT_S, 0.5)) for _ in "12")
    assert one.reports == other.reports


def test_a_time_limit_that_strikes_in_lockstep_makes_no_flight() -> None:
    with pytest.raises(EngineTimeout, match=r"did not answer in 0\.01 s"):
        Flown(EngineJobs("fast-downward", Encoding.V4, 0.01, DURATION_S))


class _DyingOnce:
    """An engine whose child is killed when it plans in flight for the first time."""

    def __init__(self, patched: pytest.MonkeyPatch) -> None:
        self._jobs = EngineJobs("fast-downward", Encoding.V4, TIMEOUT_S, DURATION_S)
        self._patched, self._is_dead = patched, False

    def plan(self, problem: Problem, histories: Sequence[Sequence[Letter]]) -> Lasso | Failed:
        return self._jobs.plan(problem, histories)

    def begin(
        self, problem: Problem, histories: Sequence[Sequence[Letter]], now_s: float
    ) -> EngineJob:
        self._patched.undo()
        if not self._is_dead:
            self._patched.setattr(engine_process, "run", bad_engines.killed)
            self._is_dead = True
        return self._jobs.begin(problem, histories, now_s)


@pytest.mark.long
def test_an_engine_that_is_killed_in_flight_costs_a_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    """The built-in search plans in its place, and the next plan is the engine's again."""
    flown = Flown(_DyingOnce(monkeypatch))
    assert "INTERNAL_ERROR" in flown.one(EngineFailed).reason
    assert flown.of(PlanReplaced)[0].reason == "target found"
    assert flown.places[-3:] == ["r1", "r2", "Home"]
    assert flown.one(TaskSatisfied)
