"""Lines with a priority in flight: dropped where no plan keeps them, and taken up again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pytest
from rig import Rig
from synthetic import command, event, facts_of, mission, reading, skill

from companion.acting.executive_states import Executing, TaskStatus
from companion.acting.replanning.idle_replans import MAX_IDLE_REPLANS
from companion.acting.replanning.optional_lines import LED_NOWHERE
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import (
    LineDropped,
    LineTakenUp,
    NoPlanFound,
    PlanAwaited,
    PlanMade,
    PlanReplaced,
)
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.flight_events.word import ConjunctViolated
from companion.ltl.formula import Formula
from companion.ltl.semantics import holds
from companion.mission.events import Event
from companion.mission.facts import Fact
from companion.mission.model import Mission
from companion.mission.otherwise import Otherwise
from companion.mission.steps import Command
from companion.outcomes import Failed
from companion.planning.engine_port import EngineJob
from companion.planning.lasso import Lasso, Letter, Problem
from companion.planning.optional_lines import NO_PLAN
from companion.planning.planner import Planner
from companion.planning.solver import Solver
from companion.slices import SLICE_US, spent
from companion.tick import TICK_S

RAIN = event("rain")
PATROL = {"near": "G F at(A) & G F at(H)", "dry": "G (rain -> X !at(B))", "far": "G F at(B)"}
LOOK = skill("look", Command(25, 31010, "MAV_CMD_USER_1", ()), "", "at(H)", (), "seen")
LOOKING = {
    "near": "G F at(A) & G F at(H)",
    "look": "F seen",
    "far": "G F at(B)",
    "dry": "G (rain -> F at(A))",
}


def asked(
    task: Mapping[str, str] = PATROL, far: int = 1, events: tuple[Event, ...] = (RAIN,), **more: int
) -> Mission:
    """A patrol; its far site is left out while it rains."""
    return mission(task, events=events, priorities={"far": far, **more})


def fly(rig: Rig, seconds: float) -> None:
    for _ in range(round(seconds / TICK_S)):
        rig.tick()


def places(rig: Rig) -> list[str]:
    return [event.place for event in rig.of(PlaceReached)]


def test_what_cannot_be_kept_at_the_start_is_told_with_the_first_plan() -> None:
    rig = Rig(asked({**PATROL, "never": "G !at(B)"})).begin()
    assert rig.one(LineDropped) == LineDropped("far", NO_PLAN)
    plan = rig.one(PlanMade)
    assert (plan.priorities, plan.dropped) == ({"far": 1}, ("far",))
    rig.run_until(PlaceReached, times=5)
    assert set(places(rig)) == {"A", "H"} and not rig.of(PlanReplaced)


def test_a_line_is_dropped_and_taken_up_again() -> None:
    rig = Rig(asked()).begin()
    rig.run_until(PlaceReached, place="B")
    rig.tick(reading("rain"))
    rig.run_until(PlaceReached, times=6)
    assert "B" not in places(rig)[2:]
    assert rig.one(LineDropped).line == "far"
    assert rig.one(PlanReplaced).dropped == ("far",)
    rig.tick(reading("rain", 0.0))
    rig.run_until(LineTakenUp)
    assert rig.one(LineTakenUp) == LineTakenUp("far", anew=False)
    again = rig.of(PlanReplaced)[-1]
    assert (again.reason, again.dropped) == ("far has a plan again", ())
    rig.run_until(PlaceReached, place="B", times=2)
    assert not rig.of(PlanAwaited) and not rig.of(ConjunctViolated)


def test_a_line_is_taken_up_between_two_skills() -> None:
    """Nothing is interrupted for it."""
    rig = Rig(asked()).begin()
    rig.tick(reading("rain"))
    rig.run_until(PlaceReached, times=3)
    fly(rig, 1.0)
    rig.tick(reading("rain", 0.0))
    replans = rig.executive.reports.replans
    reached = len(places(rig))
    rig.run_until(PlaceReached, times=reached + 1)
    assert rig.executive.reports.replans == replans
    rig.run_until(LineTakenUp)
    assert len(places(rig)) == reached + 1


def test_it_is_asked_once_a_completed_skill(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig(asked()).begin()
    tried = []
    line_to_take_up = Solver.line_to_take_up

    def spied(solver: Solver, problem: Problem, dropped: frozenset[str]) -> str | None:
        tried.append(rig.task.word.positions)
        return line_to_take_up(solver, problem, dropped)

    monkeypatch.setattr(Solver, "line_to_take_up", spied)
    rig.tick(reading("rain"))
    first = len(places(rig))
    rig.run_until(PlaceReached, times=first + 6)
    assert len(tried) == len(set(tried)) <= 6
    assert len(rig.of(PlanReplaced)) == 1


def test_events_that_change_meanwhile_do_not_hold_the_vehicle_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The question whether a line can be kept takes a second; an event changes in each tick."""
    line_to_take_up = Solver.line_to_take_up

    def slow(solver: Solver, problem: Problem, dropped: frozenset[str]) -> str | None:
        for _ in range(20):
            spent(SLICE_US)
        return line_to_take_up(solver, problem, dropped)

    monkeypatch.setattr(Solver, "line_to_take_up", slow)
    rig = Rig(asked(events=(RAIN, event("noise")))).begin()
    rig.tick(reading("rain"))
    for i in range(600):
        rig.tick(reading("noise", float(i % 2)))
    assert len(places(rig)) >= 4


@pytest.mark.parametrize("far", [{}, {"far": 1}])
def test_an_event_that_changes_before_each_plan_is_made_ends_the_search(
    far: dict[str, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A plan takes 2.5 s, and it rains every other 1.5 s; whether a line may be dropped or not."""
    replan = Solver.replan

    def slow(
        solver: Solver, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> Lasso | None:
        for _ in range(50):
            spent(SLICE_US)
        return replan(solver, problem, histories)

    monkeypatch.setattr(Solver, "replan", slow)
    patrol = mission(PATROL, events=[RAIN], priorities=far)
    rig = Rig(replace(patrol, patience_s=0.0)).begin()
    for i in range(400):
        rig.tick(reading("rain", float(i // 30 % 2 == 0)))
    assert "plans in a row led nowhere" in rig.one(NoPlanFound).explanation


def test_a_line_that_was_dropped_knows_what_it_has_read() -> None:
    """B was visited before the rain, so that `F at(B)` has nothing left to ask for."""
    once = {"near": "G F at(A) & G F at(H)", "dry": "G (rain -> X !at(B))", "far": "F at(B)"}
    rig = Rig(asked(once)).begin()
    rig.run_until(PlaceReached, place="B")
    fly(rig, 1.0)
    rig.tick(reading("rain"))
    rig.run_until(PlaceReached, times=6)
    assert not rig.of(LineDropped)


def test_a_line_that_is_violated_begins_anew_and_the_mission_goes_on() -> None:
    lines = {"near": "G F at(A) & G F at(H)", "far": "G !rain"}
    rig = Rig(asked(lines)).begin()
    rig.run_until(PlaceReached, times=2)
    fly(rig, 1.0)
    rig.tick(reading("rain"))
    rig.run_until(ConjunctViolated)
    assert rig.one(ConjunctViolated).optional and rig.task.violated == ()
    fly(rig, 10.0)
    assert rig.one(LineDropped).line == "far"
    rig.tick(reading("rain", 0.0))
    rig.run_until(LineTakenUp)
    assert rig.one(LineTakenUp) == LineTakenUp("far", anew=True)
    rig.run_until(PlaceReached, times=8)
    assert rig.executive.status is TaskStatus.RUNNING and not rig.of(NoPlanFound)
    begun = [p.number for p in rig.positions if "far" in p.restarted]
    dropped = [p.number for p in rig.positions if "far" in p.dropped]
    assert len(begun) == 1 and dropped == list(range(dropped[0], begun[0]))


def test_a_moment_violates_a_line_that_begins_anew_after_the_next_skill() -> None:
    """The rain is over when its position is read."""
    lines = {"near": "G F at(A) & G F at(H)", "far": "G !rain"}
    rig = Rig(asked(lines)).begin()
    rig.run_until(PlaceReached)
    fly(rig, 1.0)
    rig.tick(reading("rain"))
    rig.tick(reading("rain", 0.0))
    rig.run_until(LineTakenUp)
    assert rig.one(LineDropped).line == rig.one(ConjunctViolated).conjunct == "far"
    assert rig.one(LineTakenUp) == LineTakenUp("far", anew=True)
    rig.run_until(PlaceReached, times=8)
    assert len(rig.of(PlanReplaced)) <= 2


def test_a_line_that_must_hold_is_the_reason_for_no_plan() -> None:
    rig = Rig(asked({"calm": "G !rain", "far": "G F at(B)"})).begin()
    rig.run_until(PlaceReached)
    rig.tick(reading("rain"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN)
    assert rig.one(NoPlanFound).explanation.startswith("no plan: calm cannot hold from here.")
    assert not rig.of(LineDropped)


def test_patience_is_for_lines_that_must_hold() -> None:
    """Without a plan for the optional line alone nobody waits; what is waited for is the rest."""
    lines = {"near": "G F at(A) & G F at(H)", "look": "F seen", "far": "G F at(B)"}
    look = command("look", "at(A) & !rain", "seen")
    rig = Rig(
        replace(mission(lines, skills=[look], events=[RAIN], priorities={"far": 1}), patience_s=9.0)
    ).begin()
    fly(rig, 1.0)
    rig.tick(reading("rain"))
    rig.run_until(PlanAwaited)
    assert rig.one(PlanAwaited).hopes == ("rain",)
    rig.tick(reading("rain", 0.0))
    rig.run_until(PlaceReached, place="B")
    assert not rig.of(LineDropped)


def test_there_is_no_hope_in_what_helps_an_optional_line_alone() -> None:
    lines = {"look": "F seen", "far": "G (rain -> F at(B))"}
    look = command("look", "at(A) & !at(B)", "seen")
    rig = Rig(mission(lines, skills=[look], events=[RAIN], priorities={"far": 1})).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))]
    rig.tick(reading("rain"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN)
    assert not rig.of(PlanAwaited)


def test_what_is_tried_in_vain_for_an_optional_line_does_not_end_the_mission() -> None:
    """A skill that assumes nothing may fail again and again."""
    lines = {"near": "F at(A) & F at(H)", "look": "F seen"}
    rig = Rig(mission(lines, skills=[LOOK], priorities={"look": 1})).begin()
    rig.vehicle.payloads.answers = [(0.1, Failed("denied"))] * 50
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of(LineDropped) == [LineDropped("look", LED_NOWHERE)]
    assert places(rig) == ["A"]


def failing(**priorities: int) -> Rig:
    """A patrol with a skill that assumes nothing and always fails."""
    events = [event("rain"), event("noise")]
    rig = Rig(mission(LOOKING, skills=[LOOK], events=events, priorities=priorities)).begin()
    rig.vehicle.payloads.answers = [(0.1, Failed("denied"))] * 99
    return rig


def test_what_led_nowhere_is_not_tried_again_at_each_place() -> None:
    """Only the line that needs the skill is dropped."""
    rig = failing(look=1, far=1)
    rig.run_until(PlaceReached, times=12)
    assert rig.of(LineDropped) == [LineDropped("look", LED_NOWHERE)]
    assert not rig.of(LineTakenUp)
    assert len(rig.of(SkillFailed)) == MAX_IDLE_REPLANS
    assert {"A", "H", "B"} == {*places(rig)[4:]}


def test_what_led_nowhere_is_tried_again_after_an_event_that_plans_depend_on() -> None:
    rig = failing(look=1)
    rig.run_until(PlaceReached, times=3)
    before = len(rig.of(SkillFailed))
    rig.tick(reading("noise"))
    rig.run_until(PlaceReached, times=6)
    assert len(rig.of(SkillFailed)) == before
    rig.vehicle.payloads.answers.clear()
    rig.tick(reading("rain"))
    rig.run_until(LineTakenUp)
    rig.run_until(SkillCompleted)


def test_a_line_that_must_hold_tries_again_what_led_nowhere() -> None:
    """It may have failed only because of the lines that may be dropped."""
    lines = {"look": "F seen", "far": "F at(A)"}
    rig = Rig(mission(lines, skills=[LOOK], priorities={"far": 1})).begin()
    rig.vehicle.payloads.answers = [(0.1, Failed("denied"))] * MAX_IDLE_REPLANS
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of(LineDropped) == [LineDropped("far", LED_NOWHERE)]


def test_laps_are_those_of_the_lines_that_are_kept() -> None:
    rig = Rig(asked()).begin()
    rig.tick(reading("rain"))
    rig.run_until(PlaceReached, times=8)
    assert rig.task.word.laps >= 3


def test_a_plan_that_rests_without_a_line_satisfies_the_task() -> None:
    rig = Rig(asked({"go": "F at(A)", "dry": "G !at(B)", "far": "F at(B)"})).begin()
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.executive.failure is None and places(rig) == ["A"]


def test_on_the_way_home_nothing_is_taken_up() -> None:
    lines = {"calm": "G !rain", "far": "G F at(B)", "never": "G !at(B)"}
    made = mission(
        lines,
        events=[RAIN],
        priorities={"far": 1},
        otherwise=Otherwise.RETURN_HOME,
        initially=["at(H)"],
    )
    rig = Rig(replace(made, task={**made.task, **mission("G F at(A) & G F at(H)").task})).begin()
    rig.run_until(PlaceReached, place="A")
    rig.tick(reading("rain"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN)
    assert rig.leave_for("H")
    rig.run(lambda: rig.executive.status is TaskStatus.SATISFIED)
    assert rig.executive.failure is not None


def test_an_operator_may_pause_and_go_on() -> None:
    rig = Rig(asked()).begin()
    rig.tick(reading("rain"))
    rig.run_until(PlaceReached, times=3)
    rig.executive.pause()
    rig.tick(reading("rain", 0.0))
    rig.executive.resume()
    rig.run_until(LineTakenUp)
    rig.run_until(PlaceReached, place="B", times=1)
    assert len(rig.of(LineDropped)) == 1


def test_an_event_may_let_a_violated_line_begin_anew() -> None:
    again = event("again", restarts=["far"])
    lines = {"near": "G F at(A) & G F at(H)", "far": "G !rain"}
    rig = Rig(asked(lines, events=(RAIN, again))).begin()
    rig.tick(reading("rain"))
    rig.run_until(LineDropped)
    rig.run_until(ConjunctViolated)
    rig.tick(reading("rain", 0.0), reading("again"))
    rig.run_until(LineTakenUp)
    assert rig.one(LineTakenUp) == LineTakenUp("far", anew=False)


def test_of_two_lines_in_conflict_the_more_important_one_is_kept() -> None:
    lines = {**PATROL, "wet": "G (rain -> F at(B))"}
    rig = Rig(mission(lines, events=[RAIN], priorities={"dry": 1, "far": 3, "wet": 2})).begin()
    rig.run_until(PlaceReached, place="A")
    rig.tick(reading("rain"))
    fly(rig, 1.0)
    assert [dropped.line for dropped in rig.of(LineDropped)] == ["dry"]


class _Engine:
    """An engine that plans by the built-in search, and keeps what it was asked."""

    def __init__(self, planner: Planner) -> None:
        self.planner = planner
        self.asked: list[set[str]] = []

    def plan(self, problem: Problem, histories: object) -> Lasso | Failed:
        self.asked.append({conjunct.name for conjunct in problem.conjuncts})
        found = self.planner.solver.replan(problem, histories)  # type: ignore[arg-type]
        return found or Failed("finds no plan")

    def begin(self, problem: Problem, histories: object, now_s: float) -> EngineJob:
        engine = self

        class Job:
            def answer(self, now_s: float) -> Lasso | Failed | None:
                return engine.plan(problem, histories)

            def abandon(self) -> None:
                pass

        return Job()


def test_an_engine_plans_for_the_lines_that_are_kept() -> None:
    made = asked()
    engine = _Engine(Planner(made))
    rig = Rig(made, engine=engine).begin()
    rig.run_until(PlaceReached)
    rig.tick(reading("rain"))
    rig.run_until(LineDropped)
    rig.run_until(PlaceReached, times=4)
    assert engine.asked == [{"near", "dry", "far"}, {"near", "dry"}]


@pytest.mark.parametrize("far", [1, pytest.param(2, marks=pytest.mark.long)])
def test_the_word_satisfies_what_was_kept(far: int) -> None:
    """By the semantics of LTL, of what was recorded: with its positions in which it was kept."""
    rig = Rig(asked(far=far)).begin()
    for at_s in (5.0, 40.0, 60.0, 90.0):
        rig.run(lambda until=at_s: rig.flight.now_s >= until)  # type: ignore[misc]
        rig.tick(reading("rain", float(at_s in (5.0, 60.0))))
    word: list[Letter] = [frozenset(map(Fact.parse, p.facts)) for p in rig.positions]
    dry = rig.mission.task["dry"]
    assert isinstance(dry, Formula)
    assert holds(dry, word[:-1], [frozenset(facts_of("at(H)"))])
    visits = [p.number for p in rig.positions if "at(B)" in p.facts]
    kept = [p.number for p in rig.positions if "far" not in p.dropped]
    assert visits and set(visits) <= set(kept)
    assert rig.of(MissionEventChanged) and isinstance(rig.executive.state, Executing)
