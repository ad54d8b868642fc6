"""Without a plan the vehicle lands at the safe place that it reaches soonest just then."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sortie_rig import SortieRig
from synthetic import command, event, facts_of, mission, move, reading

from companion.acting.replanning.replanner import Replanner
from companion.acting.sortie.flight_limit import FlightLimit
from companion.errors import NoPlanError
from companion.flight_events.plans import NoPlanFound, PlanReplaced
from companion.flight_events.sortie import (
    Phase,
    PhaseEntered,
    ReturnBegun,
    ReturnedAsAsked,
    ReturnFailed,
    TaskSatisfied,
)
from companion.geometry import Ned
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.otherwise import LandAtSafePlace, Otherwise
from companion.mission.skills import Skill
from companion.mission.steps import Execution, Land, TakeOff, Wait
from companion.mission.tree_nodes import Act, Steps
from companion.motion.grid import OccupancyGrid
from companion.outcomes import Failed
from companion.planning.planner import Planner
from companion.planning.task_changes import ActionBegun, TaskChange
from companion.planning.task_replay import TaskReplay
from companion.planning.task_state import TaskState
from companion.slices import SLICE_US, spent
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Mode

MISSIONS = Path(__file__).parents[3] / "missions"
NO_WAY_OUT = command("do", "at(A)", "done")
"""When it is refused at A, "F done" has no plan any longer."""
NEAR_B, NEAR_C, NEAR_H = ((10, 20), (10, 20)), ((0, 9), (10, 20)), ((0, 9), (0, 9))
"""Rows and columns of the map."""


def stranded(*places: str, skills: Iterable[Skill] = (), names: str = "HABC") -> Mission:
    """A mission that cannot be done at A, and the safe places."""
    return mission(
        "F done",
        places=names,
        skills=[*skills, NO_WAY_OUT],
        otherwise=LandAtSafePlace(tuple(places)),
    )


def refused(asked: Mission, **options: Any) -> SortieRig:
    """On the way to A, where the payload refuses."""
    run = SortieRig(asked, **options)
    run.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    return run.until(Phase.TASK)


def leaving(run: SortieRig, place: str) -> SortieRig:
    """On the way to a safe place, for a second."""
    while ReturnBegun(place) not in run.events:
        assert not run.sortie.has_ended, run.events
        run.step()
    return run.run(1.0)


def block(run: SortieRig, *parts: tuple[tuple[int, int], tuple[int, int]]) -> None:
    """The map shows walls from now on, and no others."""
    occupied = np.zeros((20, 20), dtype=np.bool_)
    for (south, north), (west, east) in parts:
        occupied[south:north, west:east] = True
    run.rig.flight.routes.see(OccupancyGrid(occupied, 0.5, (-2.0, -2.0)))


def landed(run: SortieRig, place: str) -> None:
    """It has landed at a place, for want of a plan."""
    run.until(Phase.ENDED)
    assert run.end.exit_code == NoPlanError.exit_code
    assert run.places[-1] == place
    assert run.vehicle.pursued[-1] is Goal.LANDED and Goal.HOLDING not in run.vehicle.pursued
    assert run.vehicle.state is not None and run.vehicle.state.is_landed
    assert away_m(run.position, run.rig.mission.places[place].position) < 0.3


def away_m(a: Ned, b: Ned) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))


def begun(run: SortieRig) -> list[str]:
    return [each.place for each in run.of(ReturnBegun)]


def test_it_lands_at_the_one_that_is_reached_soonest() -> None:
    run = refused(stranded("C", "B"))
    landed(run, "B")
    assert begun(run) == ["B"] and not run.of(ReturnFailed)


def test_the_time_decides_and_not_the_distance() -> None:
    """A wall stands between A and B: the way round takes longer than the way to C."""
    run = refused(stranded("B", "C"))
    while run.sortie.phase is Phase.TASK and away_m(run.position, (6.0, 0.0, 0.0)) > 0.5:
        run.step()
    block(run, ((6, 20), (9, 11)))
    landed(run, "C")


def test_no_skill_has_to_fly_there() -> None:
    asked = stranded("B")
    asked = replace(asked, sets={"Place": ("H", "A")})
    run = refused(asked)
    landed(run, "B")
    assert str(run.rig.executive.lasso) == "reach(here, B), (wait)^w"


def test_what_the_skill_that_flies_there_asks_for_does_not_matter() -> None:
    locked = move(precondition="at(from) & open")
    asked = replace(stranded("B", skills=[locked]), initially=facts_of("at(H)", "open"))
    run = refused(asked)
    landed(run, "B")


def test_one_that_is_walled_in_is_not_flown_to() -> None:
    run = refused(stranded("B", "C"))
    block(run, NEAR_B)
    landed(run, "C")
    assert begun(run) == ["C"]


def test_when_the_way_is_blocked_it_goes_to_the_next() -> None:
    run = leaving(refused(stranded("B", "C")), "B")
    block(run, NEAR_B)
    blocked_s = run.rig.flight.now_s
    leaving(run, "C")
    assert run.rig.flight.now_s - blocked_s < 5.0, "it does not wait for the way"
    landed(run, "C")
    (failed,) = run.of(ReturnFailed)
    assert failed.place == "B" and "B" in failed.reason
    assert begun(run) == ["B", "C"]


def test_one_that_was_blocked_is_not_flown_to_again() -> None:
    """The way to B is clear again when that to C is lost."""
    run = leaving(refused(stranded("B", "C")), "B")
    block(run, NEAR_B)
    leaving(run, "C")
    block(run, NEAR_C)
    run.until(Phase.ENDED)
    assert begun(run) == ["B", "C"]
    assert run.vehicle.pursued[-2:] == [Goal.HOLDING, Goal.LANDED]


def test_when_none_can_be_reached_it_lands_where_it_is() -> None:
    run = refused(stranded("B", "C", "H"))
    while run.sortie.phase is Phase.TASK and away_m(run.position, (6.0, 0.0, 0.0)) > 0.2:
        run.step()
    block(run, NEAR_B, NEAR_C, NEAR_H)
    run.until(Phase.ENDED)
    assert begun(run) == [] and run.end.exit_code == NoPlanError.exit_code
    assert run.vehicle.pursued[-2:] == [Goal.HOLDING, Goal.LANDED]
    assert run.position[0] > 5.5


def test_at_one_of_them_already_it_lands_there() -> None:
    landed(refused(stranded("H", "A", "B")), "A")


def test_a_pause_on_the_way_goes_on_to_the_same() -> None:
    run = leaving(refused(stranded("B", "C")), "B")
    assert run.sortie.pause() is None
    run.run(3.0)
    assert run.sortie.resume() is None
    landed(run, "B")
    assert begun(run) == ["B", "B"] and not run.of(ReturnFailed)


def test_after_a_takeover_it_goes_to_the_one_that_is_nearest_then() -> None:
    run = leaving(refused(stranded("B", "C"), may_yield=True), "B")
    run.vehicle.control.takeover = Takeover(Mode.POSCTL, is_failsafe=False)
    run.vehicle.change(mode=Mode.POSCTL, heartbeat_received_s=run.rig.flight.now_s)
    run.run(1.0)
    assert run.sortie.phase is Phase.YIELDED
    run.vehicle.change(position=(0.5, 3.0, -2.0), mode=Mode.LOITER)
    run.vehicle.change(heartbeat_received_s=run.rig.flight.now_s)
    run.vehicle.control.takeover = None
    assert run.sortie.resume() is None
    landed(run, "C")


def test_an_operator_calls_it_home_and_not_to_a_safe_place() -> None:
    run = leaving(refused(stranded("B", "C")), "B")
    assert run.sortie.return_home() is None
    run.until(Phase.ENDED)
    assert away_m(run.position, (0.0, 0.0, 0.0)) < 0.3
    assert run.end == ReturnedAsAsked()


def test_a_limit_of_the_flight_leads_home_and_not_to_a_safe_place() -> None:
    asked = replace(mission("G F at(A) & G F at(B)"), otherwise=LandAtSafePlace(("A", "B")))
    run = SortieRig(asked, limit=FlightLimit(laps=1)).until(Phase.ENDED)
    assert away_m(run.position, (0.0, 0.0, 0.0)) < 0.3 and run.end.exit_code == 0
    assert not run.of(ReturnBegun)


def test_a_plan_that_comes_back_on_the_way_is_flown() -> None:
    do = command("do", "!low & at(A)", "done")
    task, events = "F done & G (low -> F calm)", [event("low"), event("calm")]
    asked = mission(task, "HAB", [do], events, otherwise=LandAtSafePlace(("B",)))
    run = SortieRig(asked).until(Phase.TASK).run(2.0)
    run.step(reading("low"))
    leaving(run, "B")
    run.step(reading("low", 0.0), reading("calm"))
    assert run.until(Phase.ENDED).end == TaskSatisfied()


def alarmed(*places: str) -> Mission:
    """It cannot be done at A; an event on the way home matters to the task, and brings no plan."""
    do = command("do", "at(A)", "done")
    otherwise = LandAtSafePlace(places) if places else Otherwise.RETURN_HOME
    task = "F done & G (low -> F at(C))"
    return mission(task, "HABC", [do], [event("low")], otherwise=otherwise)


@pytest.mark.parametrize(("places", "first"), [((), "H"), (("B", "C"), "B")])
def test_an_event_on_the_way_that_brings_no_plan_changes_nothing(
    places: tuple[str, ...], first: str
) -> None:
    run = leaving(refused(alarmed(*places)), first)
    before = len(run.events)
    run.step(reading("low"))
    landed(run, first)
    assert not run.of(ReturnFailed) and begun(run) == [first]
    assert not [e for e in run.events[before:] if isinstance(e, NoPlanFound | PlanReplaced)]


def test_a_plan_is_found_on_the_way_although_other_events_change_meanwhile(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The search takes half a second; an event that nothing mentions changes in each tick."""

    def slow(replanner: Replanner) -> bool:
        for _ in range(10):
            spent(SLICE_US)
        return replanner.plan_now() is not None

    again = replace(event("again"), restores=frozenset({"can_do"}))
    run = refused(replace(stranded("B"), events={"again": again, "noise": event("noise")}))
    leaving(run, "B")
    monkeypatch.setattr(Replanner, "is_possible", property(slow))
    run.step(reading("again"))
    for i in range(20):
        run.step(reading("noise", float(i % 2)))
    assert run.one(PlanReplaced).reason == "a belief came back"


def test_where_the_plan_that_was_hoped_for_is_none_it_goes_on_to_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is possible may have changed when the plan is made."""
    run = leaving(refused(alarmed("B", "C")), "B")
    with monkeypatch.context() as patch:
        patch.setattr(Replanner, "is_possible", property(lambda self: True))
        run.step(reading("low"))
    landed(run, "B")
    assert not run.of(ReturnFailed) and begun(run) == ["B", "B"]


def test_a_tree_that_fails_leads_there() -> None:
    asked = stranded("B", "C")
    run = refused(replace(asked, task={}, tree=Steps((Act("move(H, A)"), Act("do")))))
    leaving(run, "B")
    block(run, NEAR_B)
    landed(run, "C")


@pytest.mark.parametrize("is_blocked", [False, True])
def test_a_tree_that_failed_goes_on_there_after_a_pause(is_blocked: bool) -> None:
    asked = stranded("B", "C")
    run = refused(replace(asked, task={}, tree=Steps((Act("move(H, A)"), Act("do")))))
    leaving(run, "B")
    assert run.sortie.pause() is None
    run.run(3.0)
    if is_blocked:
        block(run, ((10, 20), (13, 20)))
    assert run.sortie.resume() is None
    landed(run, "C" if is_blocked else "B")


def test_skills_of_a_pddl_domain_lead_there_as_well() -> None:
    """No skill of it flies to the platform without its own conditions."""
    delivery = load_mission(MISSIONS / "delivery.yaml")
    places = tuple(name for name in delivery.places if name != delivery.home.name)
    run = SortieRig(replace(delivery, otherwise=LandAtSafePlace(places)))
    run.vehicle.payloads.answers = [(0.0, Failed("denied"))] * 99
    run.until(Phase.ENDED)
    assert run.end.exit_code == NoPlanError.exit_code
    (place,) = begun(run)
    assert away_m(run.position, delivery.places[place].position) < 0.3


LOW = event("low")


def service(*steps: Execution) -> Mission:
    """A task that is violated while the vehicle is on the ground at H, by its plan."""
    serviced = replace(command("service", "at(H)", "serviced"), execute=steps)
    task = {"goal": "F serviced", "safe": "G !low"}
    return mission(task, "HABC", [serviced], [LOW], otherwise=LandAtSafePlace(("B", "H")))


def on_the_dock(asked: Mission) -> SortieRig:
    run = SortieRig(asked).until(Phase.TASK)
    while not run.rig.flight.progress.is_landed_by_plan:
        run.step()
    run.step(reading("low"))
    return run


def test_on_the_ground_at_one_of_them_it_stays_there() -> None:
    run = on_the_dock(service(Land(), Wait(1.0))).until(Phase.ENDED)
    assert run.vehicle.pursued.count(Goal.ARMED) == 1
    assert run.end.exit_code == NoPlanError.exit_code and not run.of(ReturnBegun)


def test_on_the_ground_elsewhere_it_takes_off_to_the_nearest() -> None:
    asked = replace(service(Land(), Wait(1.0)), otherwise=LandAtSafePlace(("C", "B")))
    run = on_the_dock(asked)
    landed(run, "C")
    assert run.vehicle.pursued.count(Goal.ARMED) == 2
    assert PhaseEntered(Phase.ARMING) in run.events


def test_in_the_air_after_the_dock_it_flies_to_the_nearest() -> None:
    landed(on_the_dock(service(Land(), Wait(1.0), TakeOff())), "H")


@pytest.mark.parametrize("members", [("H", "A"), ("H", "A", "B", "C")])
def test_another_process_knows_the_flight_there(members: tuple[str, ...]) -> None:
    """The journal has the action by its name, whether a skill of the mission flies there or not."""
    run = refused(replace(stranded("B", "C"), sets={"Place": members}))
    changes: list[TaskChange] = []
    run.rig.task.on_change = changes.append
    leaving(run, "B")
    assert run.rig.task.running is not None
    planner = Planner(run.rig.mission, lambda origin, goal: 4.0)
    again = TaskReplay(TaskState(planner), planner)
    begun = next(each for each in reversed(changes) if isinstance(each, ActionBegun))
    assert again.action(begun.action).destination == "B"
