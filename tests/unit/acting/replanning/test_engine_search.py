"""Planning by an engine from outside: the vehicle holds until it answers, and nothing blocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import pytest
from rig import Rig
from synthetic import event, mission, reading

from companion.acting.executive_states import Searching, TaskStatus
from companion.acting.replanning.assumptions import FLAPPING_S
from companion.acting.replanning.idle_replans import MAX_IDLE_REPLANS
from companion.errors import NoPlanError
from companion.flight_events.plans import EngineFailed, NoPlanFound, PlanReplaced
from companion.mission.model import Mission
from companion.outcomes import Failed
from companion.planning.builtin.search import Search
from companion.planning.lasso import Lasso, Letter, Problem
from companion.tick import TICK_S


@dataclass
class Asked:
    """A job of the engine below."""

    problem: Problem
    answers: list[Lasso | Failed]
    is_abandoned: bool = False

    def answer(self, now_s: float) -> Lasso | Failed | None:
        assert not self.is_abandoned
        return self.answers[0] if self.answers else None

    def abandon(self) -> None:
        self.is_abandoned = True


@dataclass
class SlowEngine:
    """An engine that answers when a test says so; its first plan is that of the built-in search."""

    first_failure: Failed | None = None
    jobs: list[Asked] = field(default_factory=list)

    def plan(self, problem: Problem, histories: Sequence[Sequence[Letter]]) -> Lasso | Failed:
        return self.first_failure or best(problem)

    def begin(self, problem: Problem, histories: Sequence[Sequence[Letter]], now_s: float) -> Asked:
        self.jobs.append(Asked(problem, []))
        return self.jobs[-1]

    def answer(self, answer: Lasso | Failed | None = None) -> None:
        job = self.jobs[-1]
        job.answers.append(answer or best(job.problem))


def best(problem: Problem) -> Lasso:
    *_, solution = Search().solutions(problem)
    return solution.lasso


@pytest.fixture
def engine() -> SlowEngine:
    return SlowEngine()


def asked_for() -> Mission:
    events = [event("found"), event("lost")]
    asked = mission("G (F at(A) | found) & G ((found & !lost) -> F at(B))", events=events)
    return replace(asked, patience_s=0.0)


@pytest.fixture
def rig(engine: SlowEngine) -> Rig:
    """A flight on which an event has made another plan due; the engine works on it."""
    rig = Rig(asked_for(), engine=engine).begin()
    for _ in range(20):
        rig.tick()
    rig.tick(reading("found"))
    assert isinstance(rig.executive.state, Searching)
    return rig


def test_the_vehicle_holds_until_the_engine_has_answered(rig: Rig, engine: SlowEngine) -> None:
    for _ in range(40):
        rig.tick()
    held = rig.vehicle.state
    for _ in range(40):
        assert rig.tick() is TaskStatus.RUNNING
    assert rig.vehicle.state is not None and held is not None
    assert rig.vehicle.state.motion.position == pytest.approx(held.motion.position, abs=0.05)
    assert len(engine.jobs) == 1 and not rig.of(PlanReplaced)
    engine.answer()
    rig.tick()
    assert rig.one(PlanReplaced).reason == "found"
    assert engine.jobs[0].is_abandoned
    assert rig.run_to_the_end() is TaskStatus.SATISFIED


def test_where_the_engine_fails_the_built_in_search_plans_at_once(
    rig: Rig, engine: SlowEngine
) -> None:
    engine.answer(Failed("the engine slow did not answer in 3 s"))
    rig.tick()
    told = rig.one(EngineFailed).text
    assert told == "the engine slow did not answer in 3 s; the built-in search plans instead"
    assert rig.one(PlanReplaced) and rig.run_to_the_end() is TaskStatus.SATISFIED


def test_what_changes_meanwhile_is_asked_anew(rig: Rig, engine: SlowEngine) -> None:
    rig.tick(reading("lost"))
    first, second = engine.jobs
    assert first.is_abandoned and not second.is_abandoned
    assert "lost" in second.problem.facts - first.problem.facts
    engine.answer()
    rig.tick()
    assert rig.one(PlanReplaced).plan is not None


def test_what_flaps_is_not_asked_about_for_ever(rig: Rig, engine: SlowEngine) -> None:
    flapping_s = 2 * MAX_IDLE_REPLANS * FLAPPING_S
    for i in range(round(flapping_s / TICK_S)):
        rig.tick(reading("lost", i % 2 == 0))
    assert len(engine.jobs) <= MAX_IDLE_REPLANS + 1
    assert rig.executive.status is TaskStatus.NO_PLAN
    assert isinstance(rig.executive.failure, NoPlanError)
    assert rig.one(NoPlanFound) and all(job.is_abandoned for job in engine.jobs)


def test_nobody_waits_for_an_answer_after_a_pause_or_a_stop(rig: Rig, engine: SlowEngine) -> None:
    rig.executive.pause()
    assert engine.jobs[0].is_abandoned
    rig.executive.resume()
    assert len(engine.jobs) == 2
    rig.executive.stop()
    assert engine.jobs[1].is_abandoned


def test_a_first_plan_that_the_engine_does_not_make_is_made_and_told() -> None:
    late = Failed("the engine slow did not answer in 3 s")
    rig = Rig(asked_for(), engine=SlowEngine(late)).begin()
    assert rig.one(EngineFailed).reason == late.reason
    assert str(rig.executive.lasso) == "move(H, A), (wait)^w"
