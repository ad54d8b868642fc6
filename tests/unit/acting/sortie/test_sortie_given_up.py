"""A sortie that is given up: control is lost, it is stopped, or no plan is left in the air."""

from __future__ import annotations

import pytest
from kept_journal import KeptJournal
from sortie_rig import SortieRig, aborted
from synthetic import command, mission

from companion.acting.journal import EndingBegun
from companion.acting.sortie import authority
from companion.acting.sortie.authority import LINK_LOST_S, SILENT_S
from companion.acting.sortie.phases import GOALS
from companion.errors import Aborted, LinkError, NoPlanError, SearchLimit
from companion.flight_events.sortie import (
    Phase,
    PhaseEntered,
    ReturnBegun,
    RunFailed,
    StoppedAsAsked,
    StopRequested,
    VehicleCrashed,
)
from companion.geometry import distance
from companion.mission.otherwise import Otherwise
from companion.outcomes import Failed, Progress
from companion.planning.effort import Effort
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Mode

NEVER = (1e9, Progress.RUNNING)
OTHERWISE = {
    Otherwise.LAND: Goal.LANDED,
    Otherwise.HOLD: Goal.HOLDING,
    Otherwise.RETURN_HOME: Goal.LANDED,
}
"""The last goal of a sortie without a plan."""
SHORT = mission("F at(A)")
HOLDING = PhaseEntered(Phase.HOLDING)
NO_WAY_OUT = command("do", "at(A)", "done")
"""When it is refused at A, "F done" has no plan any longer."""


def hit(run: SortieRig) -> None:
    """The velocity jumps between two measurements."""
    for boot_s, north_mps in ((7.0, 2.0), (7.1, 0.0)):
        run.vehicle.change(boot_s=boot_s, velocity=(north_mps, 0.0, 0.0))
        run.sortie.step(run.rig.flight.now_s, ())


def give_up_searches(monkeypatch: pytest.MonkeyPatch, effort: str) -> None:
    """Searches have a limit that they reach at once."""
    tiny = Effort(1, 1, 1, 1, 1)
    monkeypatch.setattr(f"companion.planning.solver.{effort}", tiny)


# -- loss of control -------------------------------------------------------------------------------


@pytest.mark.parametrize("phase", [Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD, Phase.TASK])
def test_the_pilot_wins_in_every_phase(phase: Phase) -> None:
    run = SortieRig(SHORT)
    if phase in GOALS:
        run.vehicle.goals.script[GOALS[phase]] = NEVER
    run.until(phase)
    run.step()
    run.vehicle.control.takeover = Takeover(Mode.POSCTL, is_failsafe=False)
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
    return run.vehicle.state.motion.received_s


def test_a_vehicle_that_falls_silent_on_the_ground_is_given_up() -> None:
    run = SortieRig(SHORT)
    run.vehicle.goals.script[Goal.ARMED] = NEVER
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
        run.vehicle.goals.script[Goal.OFFBOARD] = NEVER
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
    run.vehicle.goals.script[Goal.LANDED] = (1.0, Progress.DONE)
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
    run.rig.flight.journal = journal = KeptJournal()
    run.vehicle.goals.script[Goal.LANDED] = (1.0, Progress.DONE)
    run.until(Phase.LANDING)
    hit(run)
    assert journal.noted[-1] == EndingBegun(
        is_satisfied=True,
        is_called_home=False,
        reason="the vehicle has hit something",
        exit_code=Aborted.exit_code,
    )
    run.until(Phase.ENDED)
    assert run.end == aborted("the vehicle has hit something")


def test_what_a_pilot_does_is_not_judged() -> None:
    run = SortieRig(SHORT, may_yield=True).until(Phase.TASK)
    run.vehicle.control.takeover = Takeover(Mode.POSCTL, is_failsafe=False)
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
    run.vehicle.goals.script[Goal.HOLDING] = NEVER
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
    run.vehicle.goals.script[Goal.LANDED] = (3.0, Failed("not landed"))
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
    assert run.vehicle.state is not None and run.vehicle.state.motion.position[0] > 5.5


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
    assert abs(run.vehicle.state.motion.position[0]) < 0.3


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
