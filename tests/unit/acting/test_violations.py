"""What is told when a position of the word is left, and what a violation leads to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import pytest
from rig import Rig
from synthetic import command, event, mission, reading

from companion.acting.executive_states import TaskStatus
from companion.flight_events.plans import (
    LapCompleted,
    NoPlanFound,
)
from companion.flight_events.skills import SkillCompleted
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.mission.skills import Skill
from companion.mission.steps import Execution, Land, TakeOff, Wait

LOW = event("low")


def safe_visit() -> Rig:
    return Rig(mission({"visit": "F at(A)", "safe": "G !low"}, events=[LOW])).begin()


def test_each_position_of_the_word_is_reported_when_it_is_left() -> None:
    rig = safe_visit()
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert [replace(position, reached_s=0.0) for position in rig.positions] == [
        PositionLeft(0, ("at(H)",), (), 0.0, (), (), for_ever=False),
        PositionLeft(1, ("at(A)",), (), 0.0, (), (), for_ever=False),
        PositionLeft(2, ("at(A)",), (), 0.0, (), (), for_ever=True),
    ]
    assert rig.of(ConjunctViolated) == []


def test_an_event_that_no_plan_survives_violates_where_the_vehicle_arrives() -> None:
    """On the way there is no position; the first one after the event is that of the way home."""
    rig = safe_visit()
    for _ in range(30):
        rig.tick()
    rig.tick(reading("low"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN, limit_s=0.5)
    assert rig.one(NoPlanFound).reason == "low"
    assert rig.one(NoPlanFound).explanation.startswith("no plan: safe cannot hold from here")
    assert rig.leave_for("H")
    assert rig.of(ConjunctViolated) == []
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    violated = ConjunctViolated("safe", "G !low", position=1, facts=("at(H)", "low"))
    assert rig.of(ConjunctViolated) == [violated]
    assert rig.executive.failure is not None  # the way home does not make it well


def test_a_violation_at_the_start_is_told_when_the_start_is_left() -> None:
    rig = safe_visit()
    rig.tick(reading("low"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN, limit_s=0.5)
    assert rig.of(ConjunctViolated) == []
    assert rig.leave_for("H")
    rig.tick()
    violated = ConjunctViolated("safe", "G !low", position=0, facts=("at(H)", "low"))
    assert rig.of(ConjunctViolated) == [violated]
    assert rig.positions[0].facts == violated.facts


def violated_at_the_start(restarts: Iterable[str] = ()) -> Rig:
    """Low comes while the vehicle is at position 0; it flies to A, in want of a plan."""
    events = [LOW, event("calm", restarts=restarts), event("lamp")]
    task = {"tour": "G F at(A) & G F at(B)", "safe": "G !low", "or": "F lamp | F calm | F at(H)"}
    rig = Rig(mission(task, events=events)).begin()
    rig.tick(reading("low"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN, limit_s=0.5)
    assert rig.leave_for("A")
    rig.run(lambda: rig.flight.now_s > 2.0)
    assert rig.one(ConjunctViolated).conjunct == "safe"
    assert rig.one(ConjunctViolated).position == 0
    return rig


@pytest.mark.parametrize("name", ["low", "calm", "lamp"])
def test_no_event_ends_the_way_home_after_a_violation(name: str) -> None:
    """What is lost stays lost when the event has passed: there is no reason to stop on the way."""
    rig = violated_at_the_start()
    rig.tick(reading(name, 0.0 if name == "low" else 1.0))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert "at(A)" in rig.task.facts
    assert rig.executive.failure is not None
    assert len(rig.of(ConjunctViolated)) == 1


def test_an_event_by_which_the_violated_line_begins_anew_resumes_the_task() -> None:
    rig = violated_at_the_start(restarts=["safe"])
    rig.tick(reading("low", 0.0), reading("calm"))
    assert rig.executive.failure is None
    rig.run_until(LapCompleted, lap=1)
    assert len(rig.of(ConjunctViolated)) == 1


def service(*steps: Execution) -> Skill:
    return replace(command("service", "at(H)", "serviced"), execute=steps)


@pytest.mark.parametrize("steps", [(Land(), Wait(1.0), TakeOff()), (Land(), Wait(1.0))])
def test_a_task_that_is_violated_on_the_ground_is_not_satisfied_in_the_end(
    steps: tuple[Execution, ...],
) -> None:
    """There nothing interrupts the plan. In the air again, no plan reads what has happened."""
    task = {"goal": "F serviced", "safe": "G !low"}
    rig = Rig(mission(task, skills=[service(*steps)], events=[LOW])).begin()
    rig.run(lambda: rig.flight.progress.is_landed_by_plan)
    rig.tick(reading("low"))
    rig.run_until(SkillCompleted, action="service")
    rig.tick(reading("low", 0.0))  # the facts are again as the plan has them
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    violated = [(told.conjunct, told.position) for told in rig.of(ConjunctViolated)]
    assert violated == ([] if TakeOff() in steps else [("safe", 1)])
    told = rig.one(NoPlanFound)
    assert told.reason in ("low", "safe violated")
    assert told.explanation.startswith("no plan: safe cannot hold from here")
