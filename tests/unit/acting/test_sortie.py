"""From the ground to the ground: the table of phases, and what comes before the table."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sortie_rig import SortieRig
from synthetic import command, event, mission, reading

from companion.acting import authority, beginning
from companion.acting.authority import LINK_LOST_S, SILENT_S
from companion.acting.phases import GOALS, TRANSITIONS, SortieEvent
from companion.acting.preflight.arming_terms import ArmingTerms
from companion.acting.preflight.failsafe_check import ANSWER_TIMEOUT_S
from companion.errors import Aborted, LinkError, NoPlanError, SearchLimit
from companion.flight_events.fence import FenceMissing
from companion.flight_events.plans import PlanMade
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    GoalFailed,
    Phase,
    PhaseEntered,
    ReturnBegun,
    RunFailed,
    SetpointRefused,
    StoppedAsAsked,
    StopRequested,
    TaskSatisfied,
    VehicleCrashed,
    WeakFailsafeAccepted,
)
from companion.geometry import distance
from companion.mission.model import Land, Otherwise, TakeOff
from companion.outcomes import Refusal
from companion.planning.effort import Effort
from companion.vehicle.port import Failed, Goal, Mode, Progress, Takeover

NEVER = (1e9, Progress.RUNNING)
OTHERWISE = {
    Otherwise.LAND: Goal.LANDED,
    Otherwise.HOLD: Goal.HOLDING,
    Otherwise.RETURN_HOME: Goal.LANDED,
}
"""The last goal of a sortie without a plan."""
SHORT = mission("F at(A)")
HOLDING = PhaseEntered(Phase.HOLDING)
FINISHED = (SortieEvent.REACHED, SortieEvent.FAILED, SortieEvent.SATISFIED)
NO_WAY_OUT = command("do", "at(A)", "done")
"""When it is refused at A, "F done" has no plan any longer."""


def aborted(reason: str) -> RunFailed:
    return RunFailed(reason, Aborted.exit_code)


def hit(run: SortieRig) -> None:
    """The velocity jumps between two measurements."""
    for measured_s, north_mps in ((7.0, 2.0), (7.1, 0.0)):
        run.vehicle.change(measured_s=measured_s, velocity=(north_mps, 0.0, 0.0))
        run.sortie.step(run.rig.flight.now_s, ())


def give_up_searches(monkeypatch: pytest.MonkeyPatch, effort: str) -> None:
    """Searches have a limit that they reach at once."""
    tiny = Effort(1, 1, 1, 1, 1)
    monkeypatch.setattr(f"companion.planning.solver.{effort}", tiny)


def test_a_sortie_that_goes_well() -> None:
    run = SortieRig(SHORT).until(Phase.ENDED)
    assert run.story == [
        "move(H, A), (wait)^w",
        PhaseEntered(Phase.CHECKING),
        FenceMissing("the autopilot tells no position on the earth"),
        PhaseEntered(Phase.ARMING),
        PhaseEntered(Phase.TAKE_OFF),
        PhaseEntered(Phase.OFFBOARD),
        PhaseEntered(Phase.TASK),
        PlaceReached("A", "move(H, A)"),
        PhaseEntered(Phase.LANDING),
        TaskSatisfied(),
    ]
    assert run.vehicle.pursued == [Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD, Goal.LANDED]
    assert run.end == TaskSatisfied()
    assert run.sortie.failure is None


def test_setpoints_are_streamed_before_offboard_is_entered() -> None:
    """PX4 refuses OFFBOARD without them; and they hold the vehicle where it is."""
    run = SortieRig(SHORT)
    run.vehicle.script[Goal.OFFBOARD] = (2.0, Failed("denied"))
    run.until(Phase.OFFBOARD)
    assert run.vehicle.flown == []
    for _ in range(10):
        run.step()
    assert run.vehicle.setpoint is not None and run.vehicle.state is not None
    assert run.vehicle.setpoint.position == run.vehicle.state.position
    assert run.vehicle.setpoint.velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("phase", [Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD])
def test_a_goal_that_fails_is_followed_by_what_the_table_says(phase: Phase) -> None:
    run = SortieRig(SHORT)
    run.vehicle.script[GOALS[phase]] = (1.0, Failed("not there: denied"))
    run.until(phase)
    run.until(TRANSITIONS.next(phase, SortieEvent.FAILED))
    assert GoalFailed("not there: denied") in run.events
    run.until(Phase.ENDED)
    assert run.end == aborted("not there: denied")
    assert run.vehicle.setpoint is None


def test_a_landing_that_fails_leaves_the_failure_and_ends() -> None:
    run = SortieRig(SHORT)
    run.vehicle.script[Goal.LANDED] = (1.0, Failed("not landed"))
    run.until(Phase.ENDED)
    left = "setpoints end, so that the autopilot's offboard-loss failsafe takes the vehicle"
    assert run.end == aborted(f"not landed; {left}")


def test_a_landing_on_the_way_that_the_autopilot_does_not_notice_ends_the_sortie() -> None:
    """It stands with a height that is wrong: it does not take off again from there."""
    on_the_way = replace(command("rest", "at(H)", "rested"), execute=(Land(), TakeOff()))
    run = SortieRig(mission("F rested", skills=[on_the_way]))
    run.vehicle.script[Goal.LANDED] = (1.0, Failed("not landed after 120 s"))
    run.until(Phase.TASK)
    run.vehicle.change(mode=Mode.LAND)
    run.until(Phase.ENDED)
    hint = "the autopilot goes on landing; where the vehicle stands already, disarm it by hand"
    assert run.end == aborted(f"not landed after 120 s\n    {hint}")
    assert run.vehicle.pursued[-1] is Goal.LANDED and run.vehicle.setpoint is None


def test_the_first_failure_is_the_one_that_counts() -> None:
    run = SortieRig(SHORT)
    run.vehicle.script[Goal.OFFBOARD] = (0.0, Failed("first"))
    run.vehicle.script[Goal.LANDED] = (0.0, Failed("second"))
    run.until(Phase.ENDED)
    assert run.end == aborted("first")


def test_nothing_happens_before_a_vehicle_is_heard() -> None:
    run = SortieRig(SHORT)
    run.vehicle.state = None
    for _ in range(2000):
        run.step()
    assert run.sortie.phase is Phase.WAITING
    assert run.events == []


# -- before the flight -----------------------------------------------------------------------------


@pytest.mark.parametrize("fields", [{"is_armed": True}, {"is_landed": False}])
def test_a_vehicle_that_is_under_way_is_not_ours_to_take(fields: dict[str, bool]) -> None:
    run = SortieRig(SHORT)
    run.vehicle.change(**fields)
    run.step()
    assert run.end == aborted("the vehicle is armed or flying already; it is left alone")
    assert run.vehicle.pursued == []


@pytest.mark.parametrize(("north_m", "is_home"), [(0.59, True), (0.61, False)])
def test_the_vehicle_has_to_stand_where_the_mission_begins(north_m: float, is_home: bool) -> None:
    run = SortieRig(SHORT)
    run.vehicle.change(position=(north_m, 0.0, 0.0))
    run.step()
    assert run.sortie.has_ended is not is_home
    if not is_home:
        assert run.end == aborted(
            "the vehicle stands 0.6 m from H, where the mission begins; put it there"
        )


def test_without_a_plan_nothing_is_armed() -> None:
    run = SortieRig(mission("G at(H) & X at(A)"))
    run.step()
    assert run.end.exit_code == NoPlanError.exit_code
    assert run.failure.reason.startswith("no plan: task cannot hold")
    assert run.vehicle.pursued == []


def test_weak_failsafes_are_refused() -> None:
    run = SortieRig(SHORT)
    run.vehicle.parameters["COM_OF_LOSS_T"] = 30.0
    run.until(Phase.ENDED)
    assert run.end.exit_code == Aborted.exit_code
    assert "COM_OF_LOSS_T is 30; set 1.0 or less" in run.failure.reason
    assert run.vehicle.pursued == []


def test_weak_failsafes_are_accepted_by_name() -> None:
    run = SortieRig(SHORT, terms=ArmingTerms(accepts_weak_failsafes=True))
    run.vehicle.parameters["COM_LOW_BAT_ACT"] = 0.0
    run.until(Phase.ENDED)
    assert run.end == TaskSatisfied()
    assert run.one(WeakFailsafeAccepted).weakness.startswith("COM_LOW_BAT_ACT is 0")


def test_an_autopilot_that_does_not_answer_is_given_its_time() -> None:
    run = SortieRig(SHORT)
    del run.vehicle.parameters["COM_OBL_RC_ACT"]
    run.until(Phase.CHECKING)
    start_s = run.rig.flight.now_s
    run.until(Phase.ENDED)
    assert run.rig.flight.now_s - start_s == pytest.approx(ANSWER_TIMEOUT_S, abs=0.11)
    assert "COM_OBL_RC_ACT was not answered" in run.failure.reason


def test_the_time_for_an_answer_begins_with_the_question() -> None:
    """The tick before has planned, and taken longer than an answer may."""
    run = SortieRig(SHORT)
    run.vehicle.parameters.clear()
    run.until(Phase.CHECKING)
    late_s = run.rig.flight.now_s + 2 * ANSWER_TIMEOUT_S
    run.vehicle.step(late_s)
    run.sortie.step(late_s, [])
    run.vehicle.step(late_s + ANSWER_TIMEOUT_S)
    run.sortie.step(late_s + ANSWER_TIMEOUT_S, [])
    assert run.sortie.phase is Phase.CHECKING
    run.vehicle.step(late_s + ANSWER_TIMEOUT_S + 0.1)
    run.sortie.step(late_s + ANSWER_TIMEOUT_S + 0.1, [])
    assert run.sortie.has_ended
    assert "was not answered" in run.failure.reason


def test_that_there_is_no_plan_is_told_at_the_start() -> None:
    run = SortieRig(mission("F at(A) & G !at(A)"))
    assert run.events == []
    assert run.until(Phase.ENDED).end.exit_code == NoPlanError.exit_code


# -- the table -------------------------------------------------------------------------------------


def test_each_phase_is_reached_and_left() -> None:
    left = {row.state for row in TRANSITIONS}
    reached = {row.then for row in TRANSITIONS}
    assert left == set(Phase) - {Phase.ENDED}
    assert reached == set(Phase) - {Phase.WAITING}


def test_every_phase_can_be_given_up() -> None:
    for phase in set(Phase) - {Phase.ENDED}:
        assert TRANSITIONS.next(phase, SortieEvent.GIVEN_UP) is Phase.ENDED


def test_only_the_operator_leads_out_of_a_takeover() -> None:
    events = {row.event for row in TRANSITIONS if row.state is Phase.YIELDED}
    assert events == {SortieEvent.HANDED_BACK, SortieEvent.STOPPED, SortieEvent.GIVEN_UP}


def test_a_vehicle_that_may_be_in_the_air_is_not_left_without_a_hold_or_a_landing() -> None:
    """But for a pilot or a failsafe that has it, and a mission that asks for a hold."""
    ending = {row.state for row in TRANSITIONS if row.then is Phase.ENDED and row.event in FINISHED}
    assert ending == {Phase.ARMING, Phase.PARTING, Phase.LANDING}


# -- loss of control -------------------------------------------------------------------------------


@pytest.mark.parametrize("phase", [Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD, Phase.TASK])
def test_the_pilot_wins_in_every_phase(phase: Phase) -> None:
    run = SortieRig(SHORT)
    if phase in GOALS:
        run.vehicle.script[GOALS[phase]] = NEVER
    run.until(phase)
    run.step()
    run.vehicle.takeover = Takeover(Mode.POSCTL, is_failsafe=False)
    asked = len(run.vehicle.pursued)
    run.step()
    assert run.end == aborted("the pilot has control, in POSCTL")
    assert run.vehicle.setpoint is None
    flown = len(run.vehicle.flown)
    for _ in range(100):
        run.step()
    assert (len(run.vehicle.pursued), len(run.vehicle.flown)) == (asked, flown)


def fall_silent(run: SortieRig) -> float:
    """Nothing is heard from now on; returns when the vehicle was heard last."""
    assert run.vehicle.state is not None
    run.vehicle.step = lambda now_s: None  # type: ignore[method-assign]
    return run.vehicle.state.stamp_s


def test_a_vehicle_that_falls_silent_on_the_ground_is_given_up() -> None:
    run = SortieRig(SHORT)
    run.vehicle.script[Goal.ARMED] = NEVER
    heard_s = fall_silent(run.until(Phase.ARMING))
    run.until(Phase.ENDED)
    assert run.rig.flight.now_s - heard_s == pytest.approx(LINK_LOST_S, abs=0.11)
    assert run.end == RunFailed("no position from the vehicle for 10 s", LinkError.exit_code)


def test_a_vehicle_that_falls_silent_in_the_air_is_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nothing is sent meanwhile, and no battery lasts for ever."""
    monkeypatch.setattr(authority, "NEVER_BACK_S", 60.0)
    run = SortieRig(mission("G F at(A) & G F at(B)")).until(Phase.TASK)
    heard_s = fall_silent(run)
    run.until(Phase.YIELDED)
    assert run.rig.flight.now_s - heard_s == pytest.approx(SILENT_S, abs=0.11)
    assert run.vehicle.flown[-1] is None
    run.until(Phase.ENDED)
    assert run.rig.flight.now_s - heard_s == pytest.approx(60.0, abs=0.11)
    assert run.failure.exit_code == LinkError.exit_code


@pytest.mark.parametrize("phase", [Phase.OFFBOARD, Phase.TASK])
def test_a_vehicle_that_is_disarmed_in_flight_is_given_up(phase: Phase) -> None:
    run = SortieRig(SHORT)
    if phase is Phase.OFFBOARD:
        run.vehicle.script[Goal.OFFBOARD] = NEVER
    run.until(phase)
    run.vehicle.change(is_armed=False)
    run.until(Phase.ENDED)
    assert run.end == aborted("the vehicle was disarmed in the air")


def test_a_vehicle_that_was_landed_and_disarmed_by_somebody_is_given_up() -> None:
    run = SortieRig(SHORT).until(Phase.TASK)
    run.vehicle.change(is_armed=False, is_landed=True)
    run.step()
    assert run.end == aborted("the vehicle was disarmed")


def test_a_landing_that_ends_disarmed_in_the_air_is_a_crash() -> None:
    """It was "task satisfied, landed": a fallen vehicle is soon said to have landed."""
    run = SortieRig(SHORT)
    run.vehicle.script[Goal.LANDED] = (1.0, Progress.DONE)
    run.until(Phase.LANDING)
    run.vehicle.change(is_armed=False)
    run.until(Phase.ENDED)
    assert run.story[-2] == VehicleCrashed("the vehicle was disarmed in the air")
    assert run.end == aborted("the vehicle was disarmed in the air")


def test_a_vehicle_that_has_hit_something_and_still_flies_is_landed() -> None:
    run = SortieRig(SHORT).until(Phase.TASK)
    hit(run)
    assert run.story[-2:] == [VehicleCrashed("the vehicle has hit something"), HOLDING]
    run.until(Phase.ENDED)
    assert run.vehicle.pursued[-2:] == [Goal.HOLDING, Goal.LANDED]
    assert run.end == aborted("the vehicle has hit something")


def test_a_hit_while_landing_ends_the_landing_with_exit_code_5() -> None:
    run = SortieRig(SHORT)
    run.vehicle.script[Goal.LANDED] = (1.0, Progress.DONE)
    run.until(Phase.LANDING)
    hit(run)
    run.until(Phase.ENDED)
    assert run.end == aborted("the vehicle has hit something")


def test_what_a_pilot_does_is_not_judged() -> None:
    run = SortieRig(SHORT, may_yield=True).until(Phase.TASK)
    run.vehicle.takeover = Takeover(Mode.POSCTL, is_failsafe=False)
    run.step()
    assert run.sortie.phase is Phase.YIELDED
    hit(run)
    assert run.sortie.phase is Phase.YIELDED


# -- stop ------------------------------------------------------------------------------------------


def test_a_stop_on_the_ground_ends_at_once() -> None:
    run = SortieRig(SHORT)
    run.sortie.stop()
    run.step()
    assert run.events == [StopRequested(), StoppedAsAsked()]


def test_a_stop_before_a_vehicle_is_heard_ends_at_once() -> None:
    run = SortieRig(SHORT)
    run.vehicle.state = None
    run.sortie.stop()
    run.step()
    assert run.end == StoppedAsAsked()


def test_a_stop_in_the_air_holds_and_lands() -> None:
    run = SortieRig(mission("G F at(A) & G F at(B)")).until(Phase.TASK)
    for _ in range(40):
        run.step()
    run.sortie.stop()
    run.until(Phase.ENDED)
    assert run.events[-4:] == [
        StopRequested(),
        PhaseEntered(Phase.HOLDING),
        PhaseEntered(Phase.LANDING),
        StoppedAsAsked(),
    ]
    assert run.vehicle.pursued[-2:] == [Goal.HOLDING, Goal.LANDED]
    assert run.end == StoppedAsAsked()


def test_the_vehicle_does_not_fly_on_after_a_stop() -> None:
    run = SortieRig(mission("G F at(A) & G F at(B)"))
    run.vehicle.script[Goal.HOLDING] = NEVER
    run.until(Phase.TASK)
    for _ in range(40):
        run.step()
    before = run.vehicle.setpoint
    run.sortie.stop()
    for _ in range(40):
        run.step()
    held = run.vehicle.setpoint
    assert before is not None and held is not None and held.velocity == (0.0, 0.0, 0.0)
    assert 0.5 < distance(held.position, before.position) < 2.0  # it takes that to stop
    for _ in range(40):
        run.step()
    assert run.vehicle.setpoint == held


def test_a_stop_while_landing_changes_nothing() -> None:
    run = SortieRig(SHORT)
    run.vehicle.script[Goal.LANDED] = (3.0, Failed("not landed"))
    run.until(Phase.LANDING)
    run.sortie.stop()
    run.step()
    assert run.sortie.phase is Phase.LANDING
    assert StopRequested() not in run.events


# -- no plan in the air ----------------------------------------------------------------------------


def without_plan(otherwise: Otherwise) -> SortieRig:
    """In the air at A when the only way to do the task is refused."""
    run = SortieRig(mission("F done", skills=[NO_WAY_OUT], otherwise=otherwise))
    run.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    run.until(Phase.ENDED)
    assert run.end.exit_code == NoPlanError.exit_code
    assert run.failure.reason.startswith("no plan: task cannot hold from here.")
    assert run.failure.reason.endswith("with can_do there would be a plan")
    return run


def test_otherwise_land_holds_and_lands_where_it_is() -> None:
    run = without_plan(Otherwise.LAND)
    assert run.vehicle.pursued[-2:] == [Goal.HOLDING, Goal.LANDED]
    assert run.vehicle.state is not None and run.vehicle.state.position[0] > 5.5


def test_otherwise_hold_leaves_the_vehicle_in_the_air() -> None:
    run = without_plan(Otherwise.HOLD)
    assert run.vehicle.pursued[-1] is Goal.HOLDING
    assert run.vehicle.state is not None and not run.vehicle.state.is_landed
    assert PhaseEntered(Phase.PARTING) in run.events


def test_otherwise_return_home_flies_home_and_lands_there() -> None:
    run = without_plan(Otherwise.RETURN_HOME)
    assert ReturnBegun("H") in run.events and "H" in run.places
    assert Goal.HOLDING not in run.vehicle.pursued
    assert run.vehicle.state is not None and run.vehicle.state.is_landed
    assert abs(run.vehicle.state.position[0]) < 0.3


def test_when_the_way_home_fails_as_well_it_lands_where_it_is() -> None:
    asked = mission("F done", skills=[NO_WAY_OUT], otherwise=Otherwise.RETURN_HOME)
    run = SortieRig(asked)
    run.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    run.until(Phase.TASK)
    while ReturnBegun("H") not in run.events:
        run.step()
    run.vehicle.drift = (0.0, 0.5, 0.0)
    run.until(Phase.ENDED)
    assert run.events.count(ReturnBegun("H")) == 1
    assert run.vehicle.pursued[-2:] == [Goal.HOLDING, Goal.LANDED]
    assert run.end.exit_code == NoPlanError.exit_code


@pytest.mark.parametrize(("otherwise", "goal"), OTHERWISE.items())
def test_a_search_that_is_given_up_in_flight_leads_to_otherwise(
    monkeypatch: pytest.MonkeyPatch, otherwise: Otherwise, goal: Goal
) -> None:
    """At A it is refused, and the other skill that would do is not found."""
    other = command("other", "at(H)", "done", cost_s=99.0)
    run = SortieRig(mission("F done", skills=[NO_WAY_OUT, other], otherwise=otherwise))
    run.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    run.until(Phase.TASK)
    give_up_searches(monkeypatch, "IN_FLIGHT")
    run.until(Phase.ENDED)
    text = "the search was given up at its limit of 1 edges of the product; there may be"
    assert text in run.failure.reason
    assert run.failure.exit_code == SearchLimit.exit_code == 7
    assert run.vehicle.pursued[-1] is goal
    assert (ReturnBegun("H") in run.events) is (otherwise is Otherwise.RETURN_HOME)


def test_a_first_search_that_is_given_up_ends_the_sortie_on_the_ground(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    give_up_searches(monkeypatch, "BEFORE_FLIGHT")
    run = SortieRig(SHORT).until(Phase.ENDED)
    assert run.end.exit_code == SearchLimit.exit_code
    assert run.vehicle.pursued == []


# -- reports ---------------------------------------------------------------------------------------


def test_the_gate_is_reported_when_it_begins_to_refuse_and_not_at_every_tick() -> None:
    run = SortieRig(mission("G F at(A) & G F at(B)")).until(Phase.TASK)
    fence, speed = Refusal("outside the fence"), Refusal("too fast")
    for refusal in (fence, fence, None, speed, None):
        run.vehicle.refusal = refusal
        run.step()
    refused = [SetpointRefused("outside the fence"), SetpointRefused("too fast")]
    assert run.of(SetpointRefused) == refused


def test_a_refusal_that_flickers_is_told_once() -> None:
    run = SortieRig(mission("G F at(A) & G F at(B)")).until(Phase.TASK)

    def flicker(reason: str) -> None:
        for refusal in (Refusal(reason), None, None):
            run.vehicle.refusal = refusal
            run.step()

    for tenth in range(50, 60):
        flicker(f"the position is 0.{tenth} s old")
    assert run.of(SetpointRefused) == [SetpointRefused("the position is 0.50 s old")]
    for _ in range(60):
        run.step()
    flicker("the position is 0.70 s old")
    assert run.of(SetpointRefused)[1:] == [SetpointRefused("the position is 0.70 s old")]


def test_events_count_before_the_take_off_already() -> None:
    asked = mission(
        {"t": "G (at(A) -> found)", "go": "F at(A) | G !found"}, events=[event("found")]
    )
    run = SortieRig(asked)
    run.vehicle.state, state = None, run.vehicle.state
    run.step(reading("found"))
    run.vehicle.state = state
    run.until(Phase.ENDED)
    assert run.places == ["A"]
    assert run.end == TaskSatisfied()


def test_the_mode_before_the_start_does_not_matter() -> None:
    run = SortieRig(SHORT)
    run.vehicle.change(mode=Mode.MANUAL)
    assert run.until(Phase.ENDED).end == TaskSatisfied()


@pytest.mark.parametrize("stops", [False, True])
def test_a_vehicle_that_the_pilot_arms_while_we_check_is_not_ours(stops: bool) -> None:
    run = SortieRig(SHORT)
    del run.vehicle.parameters["COM_OBL_RC_ACT"]
    run.until(Phase.CHECKING)
    run.vehicle.change(is_armed=True, is_landed=False, mode=Mode.POSCTL)
    run.vehicle.parameters["COM_OBL_RC_ACT"] = 5.0
    if stops:
        run.sortie.stop()
    for _ in range(20):
        run.step()
    assert run.vehicle.pursued == []


def test_a_task_that_is_possible_again_on_the_way_home_ends_well() -> None:
    do = command("do", "!low & at(A)", "done")
    run = SortieRig(
        mission(
            "F done & G (low -> F calm)",
            skills=[do],
            events=[event("low"), event("calm")],
            otherwise=Otherwise.RETURN_HOME,
        )
    ).until(Phase.TASK)
    for _ in range(40):
        run.step()
    run.step(reading("low"))
    for _ in range(20):
        run.step()
    run.step(reading("low", 0.0), reading("calm"))
    assert run.until(Phase.ENDED).end == TaskSatisfied()


def test_a_first_plan_that_has_to_be_searched_is_searched_in_slices(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An event before the start makes another plan: it takes ticks, and no tick waits for it."""
    monkeypatch.setattr(beginning, "GROUND_SLICE_US", 50)
    run = SortieRig(mission("G F at(A) & G(warned -> F at(B))", events=[event("warned")]))
    run.step(reading("warned", 1.0))
    searching = 0
    while run.sortie.phase is Phase.WAITING:
        searching += 1
        run.step()
    assert searching > 2
    assert "B" in str(run.one(PlanMade).plan) and run.sortie.failure is None


def test_a_vehicle_that_is_armed_while_the_first_plan_is_searched_is_left_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(beginning, "GROUND_SLICE_US", 50)
    run = SortieRig(mission("G F at(A) & G(warned -> F at(B))", events=[event("warned")]))
    run.step(reading("warned", 1.0))
    run.vehicle.change(is_armed=True)
    run.step()
    assert run.failure == aborted("the vehicle is armed or flying already; it is left alone")
