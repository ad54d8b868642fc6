"""Trees that were written by hand: each kind of node, and what ends the task."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rig import Rig
from synthetic import command, event, facts_of, mission, reading

from companion.acting.executive_states import TaskStatus
from companion.errors import CompanionError
from companion.flight_events.facts import BeliefRestored, BeliefWithdrawn
from companion.flight_events.plans import WrittenTreeAdopted
from companion.flight_events.skills import (
    PlaceReached,
    SkillCompleted,
    SkillFailed,
    WrittenTreeFailed,
)
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.mission.tree_nodes import (
    Act,
    Check,
    Fallback,
    Repeat,
    Retry,
    Steps,
    Tree,
    Watch,
)
from companion.vehicle.port import Failed, Progress

SEEN = Check("seen", facts_of("seen"), frozenset())
UNSEEN = Check("!seen", frozenset(), facts_of("seen"))


def fly(*nodes: Tree) -> Rig:
    do = command("do", "", "done")
    made = mission({}, skills=[do], events=[event("seen")])
    return Rig(replace(made, tree=Steps(nodes))).begin()


def test_steps_are_done_in_order_and_the_end_satisfies_the_task() -> None:
    rig = fly(Act("move(H, A)"), Act("do"), Act("move(A, B)"))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.events == [
        WrittenTreeAdopted(task={}),
        PlaceReached("A", "move(H, A)"),
        SkillCompleted("do"),
        PlaceReached("B", "move(A, B)"),
    ]
    assert rig.task.facts == {"at(B)", "done"}


def test_a_tree_may_break_the_task_and_that_is_told() -> None:
    """No planner has seen to it; the task is recorded, so that the flight can be audited."""
    lines = {"visit": "F at(A)", "never": "G !at(B)"}
    steps = Steps((Act("move(H, A)"), Act("move(A, B)")))
    rig = Rig(replace(mission(lines), tree=steps)).begin()
    assert rig.events == [WrittenTreeAdopted(lines)]
    rig.run_to_the_end()
    violated = ConjunctViolated("never", "G !at(B)", position=2, facts=("at(B)",))
    assert rig.of(ConjunctViolated) == [violated]
    assert rig.positions == [
        PositionLeft(0, ("at(H)",), (), (), (), for_ever=False),
        PositionLeft(1, ("at(A)",), (), (), (), for_ever=False),
        PositionLeft(2, ("at(B)",), (), (), (), for_ever=True),
    ]


def test_a_belief_that_comes_back_does_not_stop_the_tree() -> None:
    """Nothing better can be planned for it."""
    do = replace(command("do", "", "done"), retry_after_s=0.5)
    either = Fallback((Act("do"), Act("move(H, A)")))
    steps = Steps((either, Act("move(A, B)")))
    rig = Rig(replace(mission({}, skills=[do]), tree=steps)).begin()
    rig.vehicle.answers = [(0.1, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.events[1:] == [
        *(SkillFailed("do", "denied"), BeliefWithdrawn("can_do"), BeliefRestored("can_do")),
        *(PlaceReached("A", "move(H, A)"), PlaceReached("B", "move(A, B)")),
    ]


def test_a_failure_ends_the_task_in_words() -> None:
    rig = fly(Act("do"), Act("move(H, A)"))
    rig.vehicle.answers = [(0.1, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.events[-1] == WrittenTreeFailed("do failed: denied")
    assert str(rig.executive.failure) == rig.events[-1].text
    assert rig.executive.go_to("H")


def test_a_fallback_takes_what_succeeds_first() -> None:
    rig = fly(Fallback((SEEN, Act("do"), Act("move(H, A)"))), Act("move(H, B)"))
    rig.vehicle.answers = [(0.1, Progress.DONE)]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["B"]


def test_again_after_a_failure_and_so_often_at_most() -> None:
    rig = fly(Retry(Steps((Act("do"),)), 3))
    rig.vehicle.answers = [(0.1, Failed("denied")), (0.1, Progress.DONE)]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN  # the belief is gone after the first
    assert len(rig.vehicle.sent) == 1


def test_a_number_of_times_and_for_ever() -> None:
    there_and_back = Steps((Act("move(H, A)"), Act("move(A, H)")))
    rig = fly(Repeat(there_and_back, 2))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A", "H"] * 2
    rig = fly(Repeat(there_and_back, None))
    rig.run(lambda: len(rig.places) >= 6)
    assert rig.executive.status is TaskStatus.RUNNING


def test_a_watch_interrupts_what_is_under_way_and_the_vehicle_flies_on_from_here() -> None:
    watched = Watch(UNSEEN, Steps((Act("move(H, A)"),)))
    rig = fly(Fallback((watched, SEEN)), Act("move(here, B)"))
    for _ in range(20):
        rig.tick()
    rig.tick(reading("seen"))
    assert rig.task.facts == {"at(here)", "seen"}
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["B"]


def test_an_action_that_does_not_exist_is_told_before_the_flight() -> None:
    with pytest.raises(CompanionError, match=r"cannot do move\(A, A\)"):
        fly(Act("move(A, A)"))
