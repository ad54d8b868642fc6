"""Trees that were written by hand: each kind of node, and what ends the task."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes import DONE, failed
from rig import Rig
from synthetic import command, event, mission, reading

from companion.acting.executive import TaskStatus
from companion.errors import CompanionError
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

SEEN = Check("seen", frozenset({"seen"}), frozenset())
UNSEEN = Check("!seen", frozenset(), frozenset({"seen"}))


def fly(*nodes: Tree) -> Rig:
    do = command("do", "", "done")
    made = mission({}, skills=[do], events=[event("seen")])
    return Rig(replace(made, tree=Steps(nodes))).begin()


def test_steps_are_done_in_order_and_the_end_satisfies_the_task() -> None:
    rig = fly(Act("move(H, A)"), Act("do"), Act("move(A, B)"))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.texts == ["the mission's own tree", "at A", "do done", "at B"]
    assert rig.task.facts == {"at(B)", "done"}


def test_a_tree_may_break_the_task_and_that_is_told() -> None:
    """No planner has seen to it; the task is recorded, so that the flight can be audited."""
    lines = {"visit": "F at(A)", "never": "G !at(B)"}
    steps = Steps((Act("move(H, A)"), Act("move(A, B)")))
    rig = Rig(replace(mission(lines), tree=steps)).begin()
    assert rig.reports[0].data["task"] == lines
    rig.run_to_the_end()
    assert rig.of_kind("violation") == ["never violated at position 2: G !at(B)"]
    assert [(p["facts"], p["for_ever"]) for p in rig.positions] == [
        *((["at(H)"], False), (["at(A)"], False), (["at(B)"], True)),
    ]


def test_a_belief_that_comes_back_does_not_stop_the_tree() -> None:
    """Nothing better can be planned for it."""
    do = replace(command("do", "", "done"), retry_after_s=0.5)
    either = Fallback((Act("do"), Act("move(H, A)")))
    steps = Steps((either, Act("move(A, B)")))
    rig = Rig(replace(mission({}, skills=[do]), tree=steps)).begin()
    rig.vehicle.answers = [(0.1, failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.texts[1:] == [
        *("do failed: denied", "belief can_do withdrawn", "belief can_do restored"),
        *("at A", "at B"),
    ]


def test_a_failure_ends_the_task_in_words() -> None:
    rig = fly(Act("do"), Act("move(H, A)"))
    rig.vehicle.answers = [(0.1, failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert str(rig.executive.failure) == "the tree has failed: do failed: denied"
    assert rig.executive.go_to("H")


def test_a_fallback_takes_what_succeeds_first() -> None:
    rig = fly(Fallback((SEEN, Act("do"), Act("move(H, A)"))), Act("move(H, B)"))
    rig.vehicle.answers = [(0.1, DONE)]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of_kind("at") == ["at B"]


def test_again_after_a_failure_and_so_often_at_most() -> None:
    rig = fly(Retry(Steps((Act("do"),)), 3))
    rig.vehicle.answers = [(0.1, failed("denied")), (0.1, DONE)]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN  # the belief is gone after the first
    assert len(rig.vehicle.sent) == 1


def test_a_number_of_times_and_for_ever() -> None:
    there_and_back = Steps((Act("move(H, A)"), Act("move(A, H)")))
    rig = fly(Repeat(there_and_back, 2))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of_kind("at") == ["at A", "at H"] * 2
    rig = fly(Repeat(there_and_back, None))
    rig.run(lambda: len(rig.of_kind("at")) >= 6)
    assert rig.executive.status is TaskStatus.RUNNING


def test_a_watch_interrupts_what_is_under_way_and_the_vehicle_flies_on_from_here() -> None:
    watched = Watch(UNSEEN, Steps((Act("move(H, A)"),)))
    rig = fly(Fallback((watched, SEEN)), Act("move(here, B)"))
    for _ in range(20):
        rig.tick()
    rig.tick(reading("seen"))
    assert rig.task.facts == {"at(here)", "seen"}
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of_kind("at") == ["at B"]


def test_an_action_that_does_not_exist_is_told_before_the_flight() -> None:
    with pytest.raises(CompanionError, match=r"cannot do move\(A, A\)"):
        fly(Act("move(A, A)"))
