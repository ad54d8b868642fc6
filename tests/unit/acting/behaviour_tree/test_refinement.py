"""Skills made of several steps, of other skills, and of landings; and beliefs that come back."""

from __future__ import annotations

from dataclasses import replace

import py_trees
import pytest
from rig import Rig
from synthetic import command, event, facts_of, mission, reading, skill

from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.landing import NO_CHARGE_S
from companion.acting.deliberation import PlanChosen
from companion.acting.executive_states import TaskStatus
from companion.acting.replanning.assumptions import Assumptions
from companion.acting.sortie.sortie import Sortie
from companion.flight_events.event import FlightEvent
from companion.flight_events.facts import BeliefRestored, BeliefWithdrawn, MissionEventChanged
from companion.flight_events.plans import LapCompleted, PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.flight_events.sortie import Phase, VehicleAirborne, VehicleLanded
from companion.mission.model import Mission
from companion.mission.skills import Skill
from companion.mission.steps import Charge, Command, Do, Fly, Land, TakeOff, Wait
from companion.outcomes import Failed, Progress
from companion.planning.instances import instantiate
from companion.planning.lasso import ChosenPlan, Lasso
from companion.vehicle.ports.goals import Goal

LOW = event("low")
PHOTO = Command(25, 31010, "MAV_CMD_USER_1", ())


def steps(name: str, *execute: object, **more: object) -> Skill:
    """A skill that goes to `to`, made of steps."""
    made = skill(name, Wait(0.0), "from to", "at(from)", [f"can_{name}(to)"], "at(to) & !at(from)")
    return replace(made, execute=execute, **more)  # type: ignore[arg-type]


def charging(task: str = "F charged") -> Mission:
    """Charge at A: fly there and land, charge, take off; the flight and the landing are a skill."""
    dock = skill("dock", Wait(0.0), "to", assumes=["pad(to)"])
    dock = replace(dock, execute=(Fly("to"), Land()), is_planned=False, tries=2)
    charge = skill("charge", Wait(0.0), "from to", "at(from)", [], "at(to) & !at(from) & charged")
    charge = replace(charge, execute=(Do("dock", ("to",)), Charge(90), TakeOff()))
    charge = replace(charge, distinct=(("to", "H"), ("to", "B")))
    return mission(task, skills=[charge, dock], events=[LOW])


# -- the task model --------------------------------------------------------------------------------


def test_a_skill_that_is_not_planned_only_refines_others_and_lends_them_its_beliefs() -> None:
    model = instantiate(charging(), lambda origin, goal: 7.0)
    assert [a.name for a in model.actions if a.skill == "dock"] == []
    charge = next(a for a in model.actions if a.name == "charge(H, A)")
    assert charge.assumes == {"pad(A)"}
    assert charge.destination == "A"
    assert [type(step).__name__ for step in charge.execute] == ["Refinement", "Charge", "TakeOff"]


# -- the tree --------------------------------------------------------------------------------------


def test_the_tree_is_refined_down_to_primitives() -> None:
    rig = Rig(charging())
    action = next(a for a in rig.planner.actions.model.actions if a.name == "charge(H, A)")
    lines = py_trees.display.ascii_tree(
        build(rig.flight, Lasso((), (action,)), Assumptions(rig.planner, rig.flight))
    ).splitlines()
    start = next(i for i, line in enumerate(lines) if "{-} steps" in line)
    assert [line.strip() for line in lines[start : start + 11]] == [
        "{-} steps",
        "-^- MAX_TRY(2)",
        "{-} another try",
        "--> as at first?",
        "{-} dock(A)",
        "{-} move",
        "--> update_param A",
        "--> move_cmd A",
        "--> land",
        "--> charge 90 %",
        "--> take off",
    ]


def test_steps_are_done_one_after_the_other() -> None:
    shoot = steps("shoot", Fly("to"), PHOTO, Wait(1.0), PHOTO)
    rig = Rig(mission("F at(A) & F at(B)", skills=[shoot]), None).begin()
    action = next(a for a in rig.planner.actions.model.actions if a.name == "shoot(H, A)")
    lasso = Lasso((action,), (next(iter(rig.planner.actions.model.actions)),))
    rig.executive._fly_on(PlanChosen(ChosenPlan(lasso, ()), "", is_rest=False))
    rig.run_until(SkillCompleted, action="shoot(H, A)")
    assert [sent[1] for sent in rig.vehicle.payloads.sent] == [31010, 31010]


def test_steps_have_one_time_limit_together() -> None:
    shoot = steps("shoot", Wait(3.0), Wait(3.0), timeout_s=5.0)
    shoot = replace(
        shoot, parameters=(), precondition=(), assumes=(), effect=command("x", "", "done").effect
    )
    rig = Rig(mission("F done", skills=[shoot])).begin()
    rig.run_to_the_end()
    failed_s = rig.time_of(SkillFailed, action="shoot", reason="not done after 5 s")
    assert failed_s == pytest.approx(5.0, abs=0.15)


# -- landing, charging, taking off -----------------------------------------------------------------


def test_charging_lands_waits_for_the_battery_and_goes_on_in_the_air() -> None:
    rig = Rig(charging("F (charged & F at(B))")).begin()
    rig.vehicle.change(battery_percent=20)
    rig.run_until(VehicleLanded)
    assert rig.vehicle.state is not None and not rig.vehicle.state.heartbeat.is_armed
    for _ in range(200):
        rig.tick()
    assert VehicleAirborne() not in rig.events
    rig.vehicle.change(battery_percent=91)
    rig.run_until(VehicleAirborne)
    assert rig.vehicle.pursued == [Goal.LANDED, Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["B"]
    assert rig.executive.reports.replans == 0


def test_nothing_interrupts_the_vehicle_on_the_ground_and_the_event_counts_afterwards() -> None:
    rig = Rig(charging("F charged & G (low -> F at(B))")).begin()
    rig.vehicle.change(battery_percent=20)
    rig.run_until(VehicleLanded)
    rig.tick(reading("low"))
    rig.vehicle.change(battery_percent=95)
    rig.run_until(PlaceReached, place="B")
    low, airborne = MissionEventChanged("low", holds=True), VehicleAirborne()
    (replaced,) = rig.of(PlanReplaced, number=1, reason="low")
    moments = [rig.events.index(event) for event in (low, airborne, replaced)]
    assert moments == sorted(moments)


def test_a_charger_that_gives_nothing_is_given_up_and_the_sortie_takes_off_again() -> None:
    """On the ground by its own plan the vehicle takes off before the next plan begins."""
    asked = charging("F charged | G F at(B)")
    rig = Rig(asked)
    vehicle = rig.vehicle
    vehicle.change(battery_percent=20, is_landed=True, is_armed=False, position=(0.0, 0.0, 0.0))
    sortie = Sortie(rig.acting, asked)

    def until(event: FlightEvent, limit_s: float = 400.0) -> None:
        for _ in range(round(limit_s * 20)):
            if event in [stamped.event for stamped in rig.flight.reports]:
                return
            rig.pass_time()
            sortie.step(rig.flight.now_s, ())
        raise AssertionError(rig.flight.reports)

    until(VehicleLanded())
    landed_s = rig.flight.now_s
    until(SkillFailed("charge(H, A)", "the battery does not charge, it is at 20 %"))
    assert rig.flight.now_s - landed_s == pytest.approx(NO_CHARGE_S, abs=0.5)
    assert sortie.phase is Phase.ARMING
    until(PlaceReached("B", "move(here, B)"))
    assert vehicle.pursued[-3:] == [Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD]


def test_a_landing_that_fails_is_a_failed_skill() -> None:
    rig = Rig(charging("F charged | G F at(B)")).begin()
    rig.vehicle.goals.script[Goal.LANDED] = (1.0, Failed("not landed after 120 s"))
    rig.run_until(SkillFailed, action="charge(H, A)", reason="not landed after 120 s")
    assert rig.task.withdrawn == {"pad(A)"}


# -- beliefs that come back ------------------------------------------------------------------------


def test_a_belief_comes_back_after_its_time_and_the_plan_changes_at_the_next_place() -> None:
    short = replace(command("short", "at(A)", "done"), retry_after_s=10.0)
    asked = mission("(G F done) | (G F at(A) & G F at(B))", skills=[short])
    rig = Rig(asked).begin()
    rig.vehicle.payloads.answers = [(0.5, Failed("denied"))]
    rig.run_until(BeliefWithdrawn, belief="can_short")
    withdrawn_s = rig.flight.now_s
    rig.run_until(BeliefRestored, belief="can_short")
    assert rig.flight.now_s - withdrawn_s == pytest.approx(10.0, abs=0.1)
    rig.run_until(SkillCompleted, action="short")
    reasons = [replaced.reason for replaced in rig.of(PlanReplaced)]
    assert reasons == ["short failed: denied", "a belief came back"]


def test_an_event_restores_beliefs_by_their_predicate() -> None:
    again = replace(event("again"), restores=frozenset({"can_do"}))
    asked = mission(
        "F done | (G F at(A) & G F at(B))", skills=[command("do", "at(A)", "done")], events=[again]
    )
    rig = Rig(asked).begin()
    rig.vehicle.payloads.answers = [(0.5, Failed("denied"))]
    rig.run_until(BeliefWithdrawn, belief="can_do")
    rig.tick(reading("again"))
    assert BeliefRestored("can_do") in rig.events
    assert rig.run_to_the_end() is TaskStatus.SATISFIED


def test_a_belief_that_makes_no_better_plan_leaves_the_plan_as_it_is() -> None:
    again = replace(event("again"), restores=frozenset({"trans_ok"}))
    rig = Rig(mission("G F at(A) & G F at(B)", events=[again])).begin()
    rig.run_until(PlaceReached, place="A")
    rig.task.withdraw(facts_of("trans_ok(A, H)"))
    plans = len(rig.plans)
    rig.tick(reading("again"))
    rig.run_until(LapCompleted, lap=2)
    assert rig.executive.reports.replans == 0
    assert all(str(plan) for plan in rig.plans[plans:])


def test_an_event_that_leaves_the_plan_the_best_one_interrupts_nothing() -> None:
    rig = Rig(mission("F at(A) & (F at(B) | G low)", events=[LOW])).begin()
    for _ in range(20):
        rig.tick()
    rig.tick(reading("low"))
    rig.run_until(PlaceReached, place="A")
    assert rig.executive.reports.replans == 0
    assert rig.of(MissionEventChanged) == [MissionEventChanged("low", holds=True)]


def test_what_is_denied_while_there_is_still_hope_is_not_asked_for_ever() -> None:
    """Three refusals in a row, each ten seconds after the other: one command each."""
    short = replace(command("short", "at(A)", "done"), retry_after_s=10.0)
    rig = Rig(mission("F done | (G F at(A) & G F at(B))", skills=[short])).begin()
    rig.vehicle.payloads.answers = [
        (0.1, Failed("denied")),
        (0.1, Failed("denied")),
        (0.1, Progress.DONE),
    ]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert len(rig.vehicle.payloads.sent) == 3
