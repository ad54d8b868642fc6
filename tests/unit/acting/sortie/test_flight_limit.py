"""A mission without an end is called home after so many laps, or so long."""

from __future__ import annotations

import pytest
from sortie_rig import SortieRig
from synthetic import command, event, mission, reading

from companion.acting.sortie.flight_limit import FlightLimit
from companion.errors import NoPlanError
from companion.flight_events.plans import LapCompleted, PlanReplaced
from companion.flight_events.sortie import (
    EndedAtLimit,
    FlightLimitReached,
    Phase,
    PhaseEntered,
    ReturnFailed,
    StoppedAsAsked,
    TaskSatisfied,
)
from companion.outcomes import Failed
from companion.tick import TICK_S

PATROL = "G F at(A) & G F at(B)"


def at_s(run: SortieRig, event: object) -> float:
    return next(stamped.time_s for stamped in run.reports if stamped.event == event)


def test_after_its_laps_the_vehicle_flies_home_and_lands() -> None:
    run = SortieRig(mission(PATROL), limit=FlightLimit(laps=2)).until(Phase.ENDED)
    assert run.reports[-1].event == EndedAtLimit("2 laps", "the task holds so far")
    assert run.places == ["A", "B", "A", "B"]
    assert run.sortie.failure is None
    state = run.vehicle.state
    assert state is not None and state.is_landed and abs(state.motion.position[0]) < 0.3


def test_laps_of_an_earlier_plan_count() -> None:
    found = event("found")
    task = f"{PATROL} & G (found -> F at(H))"
    run = SortieRig(mission(task, events=[found]), limit=FlightLimit(laps=2)).until(Phase.TASK)
    while run.places != ["A", "B", "A"]:
        run.step()
    for _ in range(20):
        run.step()
    run.step(reading("found"), reading("found", 0.0))
    run.until(Phase.ENDED)
    assert run.places == ["A", "B", "A", "H", "B"]
    assert run.of(PlanReplaced)
    assert isinstance(run.reports[-1].event, EndedAtLimit)


def test_laps_that_no_plan_flies_to_its_end_count() -> None:
    """An interruption on every leg: no plan is flown to the end of its loop."""
    found = event("found")
    task = f"{PATROL} & G (found -> F at(H))"
    asked = mission(task, events=[found])
    run = SortieRig(asked, limit=FlightLimit(laps=3)).until(Phase.TASK)
    while not run.sortie.has_ended:
        seen = len(run.places)
        for _ in range(20):
            run.step()
        run.step(reading("found"), reading("found", 0.0))
        while not run.sortie.has_ended and run.places[seen:][-2:-1] != ["H"]:
            run.step()
    assert [event.lap for event in run.of(LapCompleted)] == [1, 2, 3]
    assert min(map(run.places.count, "AB")) == 3
    assert run.reports[-1].event == EndedAtLimit("3 laps", "the task holds so far")


def test_a_plan_that_ends_has_no_laps_and_is_flown_to_its_end() -> None:
    """Nothing recurs in it, so each of its positions counted as a lap, and it was cut short."""
    search = "G (F (at(A) | found) & F (at(B) | found))"
    tell = command("tell", "at(B)", "told")
    task = f"{search} & G (found -> F told & F G at(H))"
    asked = mission(task, events=[event("found")], skills=[tell])
    run = SortieRig(asked, limit=FlightLimit(laps=2)).until(Phase.TASK)
    while run.places != ["A", "B", "A"]:
        run.step()
    run.step()
    run.step(reading("found"))
    run.until(Phase.ENDED)
    assert run.places == ["A", "B", "A", "B", "H"]
    assert run.reports[-1].event == TaskSatisfied()


def test_after_its_time_in_the_middle_of_a_leg() -> None:
    run = SortieRig(mission(PATROL), limit=FlightLimit(duration_s=25.0)).until(Phase.ENDED)
    armed_s = at_s(run, PhaseEntered(Phase.ARMING))
    assert at_s(run, FlightLimitReached("25 s")) == pytest.approx(armed_s + 25.0, abs=2 * TICK_S)
    assert run.reports[-1].event == EndedAtLimit("25 s", "the task holds so far")


def test_what_is_dropped_at_the_end_is_told() -> None:
    lines = {"patrol": PATROL, "dry": "G !at(C)", "far": "G F at(C)"}
    asked = mission(lines, places="HABC", priorities={"far": 1})
    run = SortieRig(asked, limit=FlightLimit(laps=2)).until(Phase.ENDED)
    told = EndedAtLimit("2 laps", "the task holds so far, without far")
    assert run.reports[-1].event == told and run.sortie.failure is None
    assert run.places == ["A", "B", "A", "B"]


def test_a_task_that_ends_before_ends_as_ever() -> None:
    run = SortieRig(mission("F at(A)"), limit=FlightLimit(laps=1, duration_s=500.0)).until(
        Phase.ENDED
    )
    assert run.reports[-1].event == TaskSatisfied()


def test_without_a_way_home_it_holds_and_lands_where_it_is() -> None:
    run = SortieRig(mission(PATROL), limit=FlightLimit(laps=1)).until(Phase.RETURNING)
    run.vehicle.drift = (0.0, 0.9, 0.0)
    run.until(Phase.ENDED)
    assert run.of(ReturnFailed)
    assert run.events.index(PhaseEntered(Phase.HOLDING)) > 0
    assert isinstance(run.reports[-1].event, EndedAtLimit)
    assert run.sortie.failure is None


def test_a_pause_goes_before_the_limit() -> None:
    run = SortieRig(mission(PATROL), limit=FlightLimit(duration_s=20.0)).until(Phase.TASK)
    assert run.sortie.pause() is None
    for _ in range(round(40.0 / TICK_S)):
        run.step()
    assert run.sortie.phase is Phase.PAUSED
    assert run.sortie.resume() is None
    run.until(Phase.ENDED)
    assert isinstance(run.reports[-1].event, EndedAtLimit)


def test_a_flight_home_for_want_of_a_plan_is_not_an_end_at_the_limit() -> None:
    asked = mission("F done & G F at(B)", skills=[command("do", "at(A)", "done")])
    run = SortieRig(asked, limit=FlightLimit(duration_s=40.0))
    run.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    run.until(Phase.ENDED)
    assert run.sortie.failure is not None
    assert run.sortie.failure.exit_code == NoPlanError.exit_code


def test_a_stop_on_the_way_home_is_a_stop() -> None:
    run = SortieRig(mission(PATROL), limit=FlightLimit(laps=1)).until(Phase.RETURNING)
    run.sortie.stop()
    run.until(Phase.ENDED)
    assert run.reports[-1].event == StoppedAsAsked()
