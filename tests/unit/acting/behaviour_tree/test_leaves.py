"""Each leaf by itself: what it asks of the vehicle, when it ends, and what it says then."""

from __future__ import annotations

import numpy as np
import pytest
from fakes import FakeVehicle
from leaves import a_rig, later, run, tick
from py_trees.common import Status
from rig import Rig
from synthetic import PAYLOAD, POSITIONS, USER_1, command, event, facts_of, mission

from companion.acting.behaviour_tree.intention import Intention
from companion.acting.behaviour_tree.leaves import (
    AssumptionsHold,
    Effects,
    Precondition,
    Rest,
    SendCommand,
    UpdateParam,
    Withdraw,
)
from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.replanning.assumptions import Assumptions
from companion.flight_events.event import FlightEvent
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.mission.steps import Command
from companion.motion.grid import OccupancyGrid
from companion.outcomes import Failed, Progress
from companion.planning.domain import WAIT, Action
from companion.tick import TICK_S
from companion.vehicle.ports.setpoints import hold_at

ASK = Command(PAYLOAD, USER_1, "MAV_CMD_USER_1", (1.5, -2.0))


def reported(rig: Rig) -> list[FlightEvent]:
    return [stamped.event for stamped in rig.flight.reports]


def action(rig: Rig, name: str) -> Action:
    return next(a for a in rig.planner.actions.model.actions if a.name == name)


def intention(rig: Rig, name: str) -> Intention:
    return Intention(name, (action(rig, name),))


# -- conditions and effects ------------------------------------------------------------------------


@pytest.mark.parametrize("predicted", [True, False])
@pytest.mark.parametrize("present", [True, False])
def test_as_predicted_compares_each_event(predicted: bool, present: bool) -> None:
    rig = a_rig()
    assumptions = Assumptions(rig.planner, rig.flight)
    rig.task.take(event("found"), predicted)
    assumptions.renew()
    rig.task.take(event("found"), present)
    leaf = AssumptionsHold(rig.flight, assumptions)
    expected = Status.SUCCESS if predicted == present else Status.FAILURE
    assert tick(rig, leaf) is expected
    assert leaf.feedback_message == ("" if predicted == present else "found")


def test_a_precondition_that_holds_leaves_the_position() -> None:
    rig = a_rig()
    assert tick(rig, Precondition(rig.flight, intention(rig, "do"), None)) is Status.SUCCESS
    assert rig.task.word.positions == 1
    assert rig.task.running is action(rig, "do")


def test_a_precondition_that_does_not_hold_names_what_is_missing() -> None:
    rig = a_rig()
    rig.task.withdraw(facts_of("trans_ok(A, B)"))
    leaf = Precondition(rig.flight, intention(rig, "move(A, B)"), None)
    assert tick(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "move(A, B) cannot begin: at(A), trans_ok(A, B)"
    assert rig.task.word.positions == 0


def test_a_forbidden_fact_does_not_allow_it() -> None:
    rig = Rig(mission("F done", skills=[command("do", "!at(H)", "done")]))
    leaf = Precondition(rig.flight, intention(rig, "do"), None)
    assert tick(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "do cannot begin: a forbidden fact"


@pytest.mark.parametrize(
    ("name", "events"),
    [
        ("move(H, A)", [PlaceReached("A", "move(H, A)")]),
        ("do", [SkillCompleted("do")]),
        ("wait", []),
    ],
)
def test_effects_are_taken_over_and_reported(name: str, events: list[FlightEvent]) -> None:
    rig = a_rig()
    done = action(rig, name)
    rig.task.begin(done)
    assert (
        tick(rig, Effects(rig.flight, Intention(name, (done,)), ends_lap=False)) is Status.SUCCESS
    )
    assert rig.task.facts == done.apply(facts_of("at(H)"))
    assert reported(rig) == events
    assert rig.flight.progress.laps == 0


def test_the_last_effects_of_a_lap_count_it_and_rest_is_not_worth_a_word() -> None:
    rig = a_rig()
    tick(rig, Effects(rig.flight, intention(rig, "do"), ends_lap=False))
    tick(rig, Effects(rig.flight, Intention("wait", (WAIT,)), ends_lap=True))
    assert rig.flight.progress.laps == 1
    assert rig.flight.progress.completed == 2
    assert reported(rig) == [SkillCompleted("do")]


def test_withdraw_gives_up_what_was_assumed_and_says_why() -> None:
    rig = a_rig()
    rig.task.begin(action(rig, "do"))
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    left = SendCommand(rig.flight, ASK, None)
    run(rig, left)
    leaf = Withdraw(rig.flight, intention(rig, "do"), left)
    assert tick(rig, leaf) is Status.SUCCESS
    assert rig.task.withdrawn == {"can_do"}
    assert reported(rig) == [SkillFailed("do", "denied"), BeliefWithdrawn("can_do")]
    assert leaf.feedback_message == "do failed: denied"


def test_a_skill_that_has_not_begun_disproves_nothing() -> None:
    rig = a_rig()
    leaf = Withdraw(rig.flight, intention(rig, "do"), Rest(rig.flight, "rest", 1.0))
    assert tick(rig, leaf) is Status.SUCCESS
    assert (rig.task.withdrawn, rig.flight.reports) == (frozenset(), [])


# -- update_param and move_cmd ---------------------------------------------------------------------


def update_param(rig: Rig) -> UpdateParam:
    return UpdateParam(rig.flight, "A", MoveCommand(rig.flight, "A", None))


def test_a_place_that_is_free_grounds_its_symbol() -> None:
    rig = a_rig()
    assert tick(rig, update_param(rig)) is Status.SUCCESS


def test_a_place_that_is_not_free_does_not() -> None:
    rig = a_rig()
    occupied = np.zeros((20, 20), dtype=np.bool_)
    occupied[14:19, 2:7] = True  # the cells around A
    rig.flight.routes.see(OccupancyGrid(occupied, 0.5, (-2.0, -2.0)))
    leaf = update_param(rig)
    assert tick(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "no waypoint of A can be flown to"


def test_a_symbol_is_grounded_in_parts_while_the_vehicle_holds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("companion.acting.symbols.CELLS_PER_TICK", 1)
    monkeypatch.setattr("companion.slices.SLICE_US", 0.1)
    occupied = np.zeros((100, 100), dtype=np.bool_)
    occupied[40:45, 15:25] = True  # on the way, so that it is searched
    rig = a_rig(grid=OccupancyGrid(occupied, 0.1, (-2.0, -2.0)))
    rig.flight.routes.aim("A", (5.9, 0.0, -2.0))
    leaf = update_param(rig)
    ticks = 1
    while tick(rig, leaf) is Status.RUNNING:
        ticks += 1
    assert leaf.status is Status.SUCCESS and ticks > 3
    assert set(rig.vehicle.flown) == {hold_at(POSITIONS["H"], 0.0)}
    assert rig.flight.routes.goal("A") == POSITIONS["A"]


# -- commands and rest -----------------------------------------------------------------------------


def test_a_command_is_sent_once_and_waited_for_on_hold() -> None:
    rig = a_rig()
    rig.vehicle.payloads.answers = [(1.0, Progress.DONE)]
    leaf = SendCommand(rig.flight, ASK, None)
    assert run(rig, leaf) is Status.SUCCESS
    assert rig.vehicle.payloads.sent == [(PAYLOAD, USER_1, (1.5, -2.0))]
    assert rig.vehicle.payloads.forgotten == [1]
    at_home = hold_at(POSITIONS["H"], 0.0)
    assert set(rig.vehicle.flown) == {at_home}
    assert rig.flight.now_s == pytest.approx(1.0, abs=1.5 * TICK_S)


def test_a_refused_command_fails_with_the_answer() -> None:
    rig = a_rig()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    leaf = SendCommand(rig.flight, ASK, None)
    assert tick(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "denied"


def test_a_command_without_a_final_answer_fails_at_its_timeout() -> None:
    rig = a_rig()
    rig.vehicle.payloads.answers = [(0.0, Progress.RUNNING)]
    start_s = later(rig)
    leaf = SendCommand(rig.flight, ASK, timeout_s=3.0)
    assert run(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "no final answer in 3 s"
    assert rig.flight.now_s - start_s == pytest.approx(3.0, abs=3 * TICK_S)
    assert rig.vehicle.payloads.forgotten == [1]


def test_an_interrupted_command_is_not_waited_for_any_longer() -> None:
    rig = a_rig()
    rig.vehicle.payloads.answers = [(9.0, Progress.DONE)]
    leaf = SendCommand(rig.flight, ASK, None)
    assert tick(rig, leaf) is Status.RUNNING
    leaf.stop(Status.INVALID)
    leaf.stop(Status.INVALID)
    assert rig.vehicle.payloads.left == [1]
    assert rig.vehicle.payloads.forgotten == []


def test_rest_holds_for_its_time() -> None:
    rig = a_rig()
    start_s = later(rig)
    assert run(rig, Rest(rig.flight, "rest", 2.0)) is Status.SUCCESS
    assert rig.flight.now_s - start_s == pytest.approx(2.0, abs=2 * TICK_S)
    assert set(rig.vehicle.flown) == {hold_at(POSITIONS["H"], 0.0)}


def test_nothing_is_flown_while_no_position_is_known() -> None:
    vehicle = FakeVehicle()
    vehicle.state = None
    rig = Rig(mission("F at(A)"), vehicle=vehicle)
    rig.flight.guidance.hold()
    assert vehicle.flown == []
