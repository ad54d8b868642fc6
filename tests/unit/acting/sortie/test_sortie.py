"""From the ground to the ground: the table of phases, and what comes before the table."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sortie_rig import SortieRig, aborted
from synthetic import command, event, mission, reading

from companion.acting.sortie import beginning
from companion.acting.sortie.phases import GOALS, TRANSITIONS, SortieEvent
from companion.acting.sortie.preflight.arming_terms import ArmingTerms
from companion.acting.sortie.preflight.failsafe_check import ANSWER_TIMEOUT_S
from companion.errors import Aborted, NoPlanError
from companion.flight_events.fence import FenceMissing
from companion.flight_events.plans import PlanMade
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    GoalFailed,
    Phase,
    PhaseEntered,
    SetpointRefused,
    TaskSatisfied,
    WeakFailsafeAccepted,
)
from companion.mission.otherwise import Otherwise
from companion.mission.steps import Land, TakeOff
from companion.outcomes import Failed, Refusal
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Mode

SHORT = mission("F at(A)")
FINISHED = (SortieEvent.REACHED, SortieEvent.FAILED, SortieEvent.SATISFIED)


def test_a_sortie_that_goes_well() -> None:
    run = SortieRig(SHORT).until(Phase.ENDED)
    assert run.story == [
        "move(H, A), (wait)^w",
        PhaseEntered(Phase.CHECKING),
        FenceMissing("the autopilot reports no position on the earth"),
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
    run.vehicle.goals.script[Goal.OFFBOARD] = (2.0, Failed("denied"))
    run.until(Phase.OFFBOARD)
    assert run.vehicle.flown == []
    for _ in range(10):
        run.step()
    assert run.vehicle.setpoint is not None and run.vehicle.state is not None
    assert run.vehicle.setpoint.position == run.vehicle.state.motion.position
    assert run.vehicle.setpoint.velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("phase", [Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD])
def test_a_goal_that_fails_is_followed_by_what_the_table_says(phase: Phase) -> None:
    run = SortieRig(SHORT)
    run.vehicle.goals.script[GOALS[phase]] = (1.0, Failed("not there: denied"))
    run.until(phase)
    run.until(TRANSITIONS.next(phase, SortieEvent.FAILED))
    assert GoalFailed("not there: denied") in run.events
    run.until(Phase.ENDED)
    assert run.end == aborted("not there: denied")
    assert run.vehicle.setpoint is None


def test_a_landing_that_fails_leaves_the_failure_and_ends() -> None:
    run = SortieRig(SHORT)
    run.vehicle.goals.script[Goal.LANDED] = (1.0, Failed("not landed"))
    run.until(Phase.ENDED)
    left = "setpoints end, so that the autopilot's offboard-loss failsafe takes the vehicle"
    assert run.end == aborted(f"not landed; {left}")


def test_a_landing_on_the_way_that_the_autopilot_does_not_notice_ends_the_sortie() -> None:
    """It stands with a height that is wrong: it does not take off again from there."""
    on_the_way = replace(command("rest", "at(H)", "rested"), execute=(Land(), TakeOff()))
    run = SortieRig(mission("F rested", skills=[on_the_way]))
    run.vehicle.goals.script[Goal.LANDED] = (1.0, Failed("not landed after 120 s"))
    run.until(Phase.TASK)
    run.vehicle.change(mode=Mode.LAND)
    run.until(Phase.ENDED)
    hint = "the autopilot goes on landing; where the vehicle stands already, disarm it by hand"
    assert run.end == aborted(f"not landed after 120 s\n    {hint}")
    assert run.vehicle.pursued[-1] is Goal.LANDED and run.vehicle.setpoint is None


def test_the_first_failure_is_the_one_that_counts() -> None:
    run = SortieRig(SHORT)
    run.vehicle.goals.script[Goal.OFFBOARD] = (0.0, Failed("first"))
    run.vehicle.goals.script[Goal.LANDED] = (0.0, Failed("second"))
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
    run = SortieRig(SHORT, arming=ArmingTerms(accepts_weak_failsafes=True))
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


# -- reports ---------------------------------------------------------------------------------------


def test_the_gate_is_reported_when_it_begins_to_refuse_and_not_at_every_tick() -> None:
    run = SortieRig(mission("G F at(A) & G F at(B)")).until(Phase.TASK)
    fence, speed = Refusal("outside the fence"), Refusal("too fast")
    for refusal in (fence, fence, None, speed, None):
        run.vehicle.setpoints.refusal = refusal
        run.step()
    refused = [SetpointRefused("outside the fence"), SetpointRefused("too fast")]
    assert run.of(SetpointRefused) == refused


def test_a_refusal_that_flickers_is_told_once() -> None:
    run = SortieRig(mission("G F at(A) & G F at(B)")).until(Phase.TASK)

    def flicker(reason: str) -> None:
        for refusal in (Refusal(reason), None, None):
            run.vehicle.setpoints.refusal = refusal
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
