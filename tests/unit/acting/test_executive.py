"""When the executive plans again, from where, and when it gives up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pytest
from happened import Replan
from rig import Rig
from synthetic import POSITIONS, command, event, facts_of, mission, move, reading
from two_docks import two_docks

from companion import load_mission, slices
from companion.acting.executive_states import (
    Executing,
    Idle,
    Searching,
    TaskStatus,
    WithoutPlan,
)
from companion.acting.plan_under_way import PlanUnderWay
from companion.acting.replan_triggers import TriggerOrder
from companion.acting.replanning.assumptions import FLAPPING_S
from companion.acting.replanning.idle_replans import MAX_IDLE_REPLANS
from companion.acting.replanning.replanner import ReplanReason
from companion.acting.triggers.after_the_tree import (
    EndSurprised,
    LineViolated,
    TreeFailed,
    WayLost,
)
from companion.acting.triggers.before_the_tree import (
    BoundLate,
    ChargeShort,
    CutOffByMap,
    DroppedLineKept,
    EnergyFigureWrong,
    TaskPossibleAgain,
)
from companion.acting.triggers.trigger import ReplanTrigger
from companion.errors import NoPlanError, SearchLimit
from companion.flight_events.facts import BeliefWithdrawn, MissionEventChanged
from companion.flight_events.plans import (
    LapCompleted,
    NoPlanFound,
    PlanMade,
    PlannedAction,
    PlanReplaced,
)
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.geometry import distance
from companion.mission.events import Event
from companion.mission.model import Mission
from companion.motion.grid import OccupancyGrid
from companion.motion.routes import RouteMap
from companion.outcomes import Failed, Progress
from companion.planning.builtin.search import Search
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT
from companion.planning.explain import Explanation, NoPlan, why_no_plan
from companion.planning.lasso import Letter, Problem
from companion.planning.planner import Planner
from companion.planning.solver import Solver
from companion.tick import TICK_S
from companion.vehicle.ports.setpoints import hold_at

FOUND, LOW = event("found"), event("low")
DO = command("do", "at(H)", "done")
A_OR_B = "(G F found & G F at(A)) | (G F !found & G F at(B))"


def search_and_report(*events: Event) -> Mission:
    """Patrol A and B until the target is found; report it from where one is."""
    return mission(
        {
            "search": "G (F at(A) | found) & G (F at(B) | found)",
            "report": "G (found -> F reported)",
        },
        skills=[command("report", "found", "reported")],
        events=events or [FOUND],
    )


def test_the_first_plan_is_reported_with_its_number() -> None:
    rig = Rig(mission("F at(A)")).begin()
    (made,) = rig.events
    assert isinstance(made, PlanMade)
    assert made.number == 0
    assert [action.action for action in made.plan.prefix] == ["move(H, A)"]
    assert made.plan.loop == (PlannedAction("wait", "wait", (), 0.1),)


def test_without_a_first_plan_the_reason_is_the_answer() -> None:
    rig = Rig(mission("G at(H) & X at(A)"))
    failure = rig.executive.plan()
    assert isinstance(failure, NoPlan)
    assert {conjunct.name for conjunct in failure.explanation.conflict} == {"task"}
    assert rig.executive.lasso is None


def test_a_first_search_that_is_given_up_names_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    tiny = replace(BEFORE_FLIGHT, product_edges=3)
    monkeypatch.setattr("companion.planning.solver.BEFORE_FLIGHT", tiny)
    failure = Rig(search_and_report()).executive.plan()
    assert isinstance(failure, SearchLimit)
    assert failure.limit == "3 edges of the product"


def test_a_plan_that_ends_at_rest_satisfies_the_task_when_the_rest_is_reached() -> None:
    rig = Rig(mission("F at(A)")).begin()
    rig.run_until(PlaceReached, place="A")
    assert rig.executive.status is TaskStatus.RUNNING
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.executive.reports.replans == 0


def test_a_loop_goes_on() -> None:
    rig = Rig(mission("G F at(A) & G F at(B)")).begin()
    rig.run_until(LapCompleted, lap=3)
    assert rig.executive.status is TaskStatus.RUNNING
    assert rig.executive.reports.replans == 0
    assert len(rig.plans) == 1


def test_an_event_that_the_task_mentions_replans_in_the_same_tick() -> None:
    rig = Rig(search_and_report()).begin()
    rig.run_until(PlaceReached, place="A")
    for _ in range(20):
        rig.tick()
    rig.tick(reading("found"))
    changed, replaced = rig.events[-2:]
    assert changed == MissionEventChanged("found", holds=True)
    assert isinstance(replaced, PlanReplaced)
    assert (replaced.number, replaced.reason) == (1, "found")


def test_an_interrupted_flight_goes_on_from_where_the_vehicle_is() -> None:
    rig = Rig(mission("F at(A) | F found", events=[FOUND, LOW])).begin()
    for _ in range(30):
        rig.tick()
    rig.tick(reading("found"))
    assert rig.task.facts == {"at(here)", "found"}
    assert rig.vehicle.state is not None
    here = rig.vehicle.state.motion.position
    assert POSITIONS["H"] != here != POSITIONS["A"]
    for _ in range(40):
        rig.tick()
    assert rig.vehicle.setpoint is not None
    assert rig.vehicle.setpoint == hold_at(rig.vehicle.setpoint.position, 0.0)
    assert distance(rig.vehicle.setpoint.position, here) < 2.0  # it takes that to stop


def test_an_event_that_only_a_precondition_mentions_replans() -> None:
    careful = command("report", "!low", "reported")
    asked = mission("F reported", skills=[careful], events=[LOW])
    rig = Rig(replace(asked, patience_s=0.0)).begin()
    rig.vehicle.payloads.answers = [(5.0, Progress.DONE)]
    rig.tick()
    rig.tick(reading("low"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN, limit_s=0.5)
    told = rig.one(NoPlanFound)
    assert (told.number, told.reason) == (1, "low")
    assert told.explanation.startswith("no plan: task cannot hold")


def test_an_event_that_nothing_mentions_is_reported_and_does_not_replan() -> None:
    rig = Rig(search_and_report(FOUND, LOW)).begin()
    for _ in range(10):
        rig.tick()
    for value in (1.0, 0.0, 1.0):
        rig.tick(reading("low", value))
    changes = [(change.event, change.holds) for change in rig.of(MissionEventChanged)]
    assert changes == [("low", True), ("low", False), ("low", True)]
    assert not rig.of(PlanReplaced) and not rig.of(NoPlanFound)
    rig.run_until(LapCompleted, lap=1)
    assert len(rig.plans) == 1


def test_a_failed_skill_replans_without_its_belief() -> None:
    """Two skills do the same; the cheaper one fails, so the other one is taken."""
    skills = [
        command("cheap", "at(H)", "done", cost_s=3.0),
        command("dear", "at(H)", "done", cost_s=9.0),
    ]
    rig = Rig(mission("F done", skills=skills)).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied")), (1.0, Progress.DONE)]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.story == [
        "cheap, (wait)^w",
        SkillFailed("cheap", "denied"),
        BeliefWithdrawn("can_cheap"),
        Replan("cheap failed: denied", "dear, (wait)^w"),
        SkillCompleted("dear"),
    ]


def test_no_plan_says_which_belief_is_to_blame() -> None:
    rig = Rig(mission("F done", skills=[command("do", "at(H)", "done")])).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert "with can_do there would be a plan" in rig.one(NoPlanFound).explanation


def test_the_vehicle_holds_where_no_plan_is_left() -> None:
    rig = Rig(mission("F done", skills=[command("do", "at(H)", "done")])).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    rig.run_to_the_end()
    assert rig.vehicle.setpoint == hold_at(POSITIONS["H"], 0.0)


def test_the_reason_is_found_in_slices_while_the_vehicle_holds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Setpoints do not wait for it; what is told is what would be told at once."""
    monkeypatch.setattr(slices, "SLICE_US", 20)
    conjuncts = {f"c{i}": f"F at({name}) | F done" for i, name in enumerate("AB" * 5)}
    explain = Solver.explain_soon
    asked: list[Problem] = []

    def explained(solver: Solver, problem: Problem) -> Explanation:
        asked.append(problem)
        return explain(solver, problem)

    monkeypatch.setattr(Solver, "explain_soon", explained)
    rig = Rig(mission({"do": "F done", **conjuncts}, skills=[DO])).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN, limit_s=20.0)
    taken_s = rig.time_of(NoPlanFound) - rig.time_of(BeliefWithdrawn)
    assert taken_s > 10 * TICK_S
    assert rig.vehicle.setpoint == hold_at(POSITIONS["H"], 0.0)
    (problem,) = asked
    why = why_no_plan(problem, Search().is_solvable)
    assert rig.one(NoPlanFound) == NoPlanFound(1, "do failed: denied", str(why))


def test_a_belief_that_comes_back_meanwhile_gives_a_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slices, "SLICE_US", 20)
    again = replace(event("again"), restores=frozenset({"can_do"}))
    conjuncts = {f"c{i}": f"F at({name}) | F done" for i, name in enumerate("AB" * 5)}
    rig = Rig(mission({"do": "F done", **conjuncts}, skills=[DO], events=[again])).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied")), (0.0, Progress.DONE)]
    rig.run(lambda: bool(rig.of(BeliefWithdrawn)), limit_s=2.0)
    rig.tick(reading("again"))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of(NoPlanFound) == []


def test_what_flaps_while_the_reason_is_looked_for_does_not_hold_the_vehicle_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(slices, "SLICE_US", 20)
    conjuncts = {f"c{i}": f"F at({name}) | F done" for i, name in enumerate("AB" * 5)}
    task = {"do": "F done", "go": "G (found -> F at(A))", **conjuncts}
    asked = mission(task, skills=[DO], events=[FOUND])
    rig = Rig(replace(asked, patience_s=0.0)).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    rig.run(lambda: bool(rig.of(BeliefWithdrawn)), limit_s=2.0)
    for i in range(round(2 * MAX_IDLE_REPLANS * FLAPPING_S / TICK_S)):
        rig.tick(reading("found", float(i % 2 == 0)))
    assert rig.executive.status is TaskStatus.NO_PLAN
    assert f"{MAX_IDLE_REPLANS} plans in a row led nowhere" in rig.of(NoPlanFound)[-1].explanation


@pytest.mark.parametrize(("extra", "plans"), [({}, 5), ({"again": "F done"}, 6)])
def test_so_many_plans_lead_nowhere_as_are_told(extra: dict[str, str], plans: int) -> None:
    """With a line that may be dropped, another plan without it follows the five."""
    ways = [command(f"do{number}", "at(H)", "done") for number in range(9)]
    asked = mission({"do": "F done", **extra}, skills=ways, priorities=dict.fromkeys(extra, 1))
    rig = Rig(asked).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))] * 20
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert len(rig.of(SkillFailed)) == plans
    assert rig.one(NoPlanFound).explanation == f"no plan: {plans} plans in a row led nowhere"


@pytest.mark.parametrize("slice_us", [pytest.param(slices.SLICE_US, marks=pytest.mark.long), 200])
def test_a_flapping_event_makes_a_plan_a_second_and_ends_nothing(
    slice_us: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 10 Hz for 30 s, each plan another one, whether it is made at once or takes ticks."""
    monkeypatch.setattr(slices, "SLICE_US", slice_us)
    rig = Rig(mission(A_OR_B, events=[FOUND])).begin()
    for i in range(600):
        rig.tick(reading("found", float(i // 2 % 2 == 0)))
    assert rig.executive.status is TaskStatus.RUNNING
    times_s = [stamped.time_s for stamped in rig.reports if isinstance(stamped.event, PlanReplaced)]
    assert len(times_s) > 5
    assert all(b - a >= FLAPPING_S - TICK_S / 2 for a, b in pairwise(times_s))


def test_an_event_that_nothing_mentions_begins_no_search_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It changes more often than a plan can be made."""
    replan = Solver.replan

    def slow(solver: Solver, problem: Problem, histories: Sequence[Sequence[Letter]]) -> Any:
        for _ in range(50):
            slices.spent(slices.SLICE_US)
        return replan(solver, problem, histories)

    monkeypatch.setattr(Solver, "replan", slow)
    rig = Rig(mission(A_OR_B, events=[FOUND, event("noise")])).begin()
    rig.tick(reading("found"))
    for i in range(100):
        rig.tick(reading("noise", float(i // 25 % 2 == 0)))
    assert rig.one(PlanReplaced).reason == "found"


def test_another_event_is_answered_at_once_while_one_flaps() -> None:
    task = f"{A_OR_B} & G (asked -> F at(H))"
    rig = Rig(mission(task, events=[FOUND, event("asked")])).begin()
    for i in range(30):
        rig.tick(reading("found", float(i % 2 == 0)))
    rig.tick(reading("found", 1.0), reading("asked"))
    assert "asked" in rig.of(PlanReplaced)[-1].reason


def test_a_position_between_two_replans_shows_that_they_led_somewhere() -> None:
    rig = Rig(mission(A_OR_B, events=[FOUND])).begin()
    value = 1.0
    for arrival in range(1, 3 * MAX_IDLE_REPLANS):
        rig.run(lambda arrival=arrival: len(rig.places) >= arrival)  # type: ignore[misc]
        for _ in range(10):
            rig.tick()
        rig.tick(reading("found", value))
        value = 1.0 - value
    assert rig.executive.reports.replans > 2 * MAX_IDLE_REPLANS
    assert rig.executive.status is TaskStatus.RUNNING


def test_a_last_resort_flies_to_a_place_and_rests() -> None:
    rig = Rig(mission("F done", skills=[command("do", "at(A)", "done")])).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.leave_for("H")
    assert str(rig.executive.lasso) == "move(here, H), (wait)^w"
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.task.facts == {"at(H)"}


def test_a_last_resort_does_not_ask_for_beliefs() -> None:
    rig = Rig(mission("F at(A)")).begin()
    rig.task.withdraw(facts_of("trans_ok(here, B)"))
    assert rig.leave_for("B")
    assert rig.run_to_the_end() is TaskStatus.SATISFIED


def test_a_last_resort_needs_no_skill_that_flies_there() -> None:
    rig = Rig(mission("F at(A)", skills=[move(precondition="!at(nowhere)")])).begin()
    assert rig.leave_for("B")
    assert str(rig.executive.lasso) == "reach(here, B), (wait)^w"
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.task.facts == {"at(B)"}


def test_stop_interrupts_the_skill_under_way() -> None:
    rig = Rig(mission("F done", skills=[command("do", "at(H)", "done")])).begin()
    rig.vehicle.payloads.answers = [(0.0, Progress.RUNNING)]
    rig.tick()
    rig.executive.stop()
    assert rig.vehicle.payloads.left == [1]
    assert rig.vehicle.setpoint == hold_at(POSITIONS["H"], 0.0)


def test_a_stuck_vehicle_fails_the_skill() -> None:
    rig = Rig(mission("F at(A)")).begin()
    rig.vehicle.is_stuck = True
    rig.run(lambda: rig.of(BeliefWithdrawn, belief="trans_ok(H, A)") != [], limit_s=600.0)


def test_no_skill_is_repeated_for_ever_in_place_of_rest() -> None:
    do = command("do", "at(H)", "done", cost_s=0.01)
    lasso = Rig(mission("F done", skills=[do])).begin().executive.lasso
    assert lasso is not None and lasso.ends_at_rest


def test_what_is_done_needs_no_precondition() -> None:
    do = command("do", "!low & at(H)", "done")
    rig = Rig(mission("F done & F at(A)", skills=[do], events=[event("low")])).begin()
    rig.run_until(SkillCompleted, action="do")
    for _ in range(20):
        rig.tick()
    rig.tick(reading("low"))
    assert rig.executive.reports.replans == 0


def test_an_event_that_does_not_matter_is_no_reason() -> None:
    skills = [command("a", "at(H)", "done"), command("b", "at(H)", "done", cost_s=9.0)]
    rig = Rig(mission("F done", skills=skills, events=[event("lamp")])).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))]
    rig.tick(reading("lamp"))
    rig.run(lambda: rig.executive.reports.replans == 1)
    replaced = rig.one(PlanReplaced)
    assert (replaced.number, replaced.reason) == (1, "a failed: denied")
    assert str(replaced.plan) == "b, (wait)^w"


def test_a_belief_about_here_can_be_to_blame() -> None:
    rig = Rig(mission("F at(A)", places="HA")).begin()
    rig.tick()
    rig.task.interrupt()
    rig.task.withdraw(facts_of("trans_ok(here, A)", "trans_ok(H, A)"))
    with pytest.raises(NoPlanError, match=r"or trans_ok\(here, A\) there would be a plan"):
        rig.planner.solver.solve(*rig.task.problem())


def test_a_search_that_is_given_up_in_flight_is_told_as_that(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig = Rig(search_and_report()).begin()
    rig.tick()
    tiny = replace(IN_FLIGHT, product_edges=3)
    monkeypatch.setattr("companion.planning.solver.IN_FLIGHT", tiny)
    rig.tick(reading("found"))
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert isinstance(rig.executive.failure, SearchLimit)
    told = rig.one(NoPlanFound)
    assert (told.number, told.reason) == (1, "found")
    assert told.explanation.startswith("the search was given up at its limit of 3 edges")
    assert "there may be a plan" in told.explanation


def test_a_map_that_has_changed_takes_moves_out_of_the_next_plan() -> None:
    """B is walled in: the way there over A is not even tried."""
    rig = Rig(mission("F at(B)")).begin()
    rig.tick()
    occupied = np.zeros((20, 20), dtype=np.bool_)
    occupied[12:, 12:] = True  # B and what is around it
    rig.flight.routes.see(OccupancyGrid(occupied, 0.5, (-2.0, -2.0)))
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.of(BeliefWithdrawn) == [BeliefWithdrawn("trans_ok(H, B)")]
    assert rig.executive.reports.replans == 1


# -- states and triggers ---------------------------------------------------------------------------


def test_the_state_says_what_is_done() -> None:
    rig = Rig(mission("F done", skills=[DO], events=[FOUND]))
    states = [type(rig.executive.state)]
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    rig.begin()
    states.append(type(rig.executive.state))
    while rig.executive.status is TaskStatus.RUNNING:
        rig.tick()
        if type(rig.executive.state) is not states[-1]:
            states.append(type(rig.executive.state))
    assert states in (
        [Idle, Executing, Searching, WithoutPlan],
        [Idle, Executing, WithoutPlan],  # the reason was found in the same tick
    )


class GuardChecked(ReplanTrigger):
    """A trigger whose guard is checked.

    Attributes:
        guarding: whether a guard is being asked.
        guarded: the triggers whose guard has held.
    """

    guarding = False
    guarded: ClassVar[set[type[ReplanTrigger]]] = set()

    def __init__(self, rig: Rig, trigger: ReplanTrigger) -> None:
        self._rig, self._trigger = rig, trigger

    @property
    def _state(self) -> object:
        return len(self._rig.flight.reports), self._rig.task.facts, self._rig.task.withdrawn

    def guard(self, plan: PlanUnderWay) -> bool:
        before = self._state
        GuardChecked.guarding = True
        holds = self._trigger.guard(plan)
        GuardChecked.guarding = False
        assert self._state == before
        self.guarded.update([type(self._trigger)] if holds else [])
        return holds

    def reason(self, plan: PlanUnderWay) -> ReplanReason | None:
        return self._trigger.reason(plan)


def test_a_guard_changes_nothing_and_searches_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """So it may be asked in every tick; what it lets through may take a search."""
    monkeypatch.setattr(GuardChecked, "guarded", set())

    def unguarded(owner: type, name: str) -> None:
        search = getattr(owner, name)

        def watched(*args: object) -> object:
            assert not GuardChecked.guarding
            return search(*args)

        monkeypatch.setattr(owner, name, watched)

    for owner, name in ((Solver, "replan"), (Planner, "reinstantiate"), (RouteMap, "find")):
        unguarded(owner, name)
    rig = Rig(search_and_report(FOUND, LOW))
    triggers = rig.executive.deliberation.triggers
    before, after = triggers.of_task.before, triggers.of_task.after
    triggers.of_task = TriggerOrder(
        before=tuple(GuardChecked(rig, each) for each in before),
        after=tuple(GuardChecked(rig, each) for each in after),
    )
    rig.begin()
    rig.run_until(PlaceReached, place="A")
    rig.tick(reading("found"))
    rig.run_to_the_end()
    assert GuardChecked.guarded == {TreeFailed}


def test_the_triggers_are_looked_at_in_their_order() -> None:
    """What the map and the beliefs say is known before the tree acts on it."""
    triggers = Rig(load_mission(two_docks())).executive.deliberation.triggers
    of_task, of_safe_place = triggers.of_task, triggers.of_safe_place
    assert [type(trigger) for trigger in of_task.before] == [
        CutOffByMap,
        ChargeShort,
        EnergyFigureWrong,
        DroppedLineKept,
        BoundLate,
    ]
    assert [type(trigger) for trigger in of_task.after] == [TreeFailed, LineViolated, EndSurprised]
    before_the_tree = CutOffByMap, TaskPossibleAgain, DroppedLineKept
    assert tuple(type(trigger) for trigger in of_safe_place.before) == before_the_tree
    assert [type(trigger) for trigger in of_safe_place.after] == [WayLost]
