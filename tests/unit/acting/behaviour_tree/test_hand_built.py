"""Trees that were written by hand: each kind of node, and what ends the task."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rig import Rig
from sortie_rig import SortieRig
from synthetic import POSITIONS, command, event, facts_of, mission, reading, skill

from companion.acting.executive_states import TaskStatus
from companion.acting.written_end import failure_at_the_end
from companion.errors import CompanionError
from companion.flight_events.facts import BeliefRestored, BeliefWithdrawn
from companion.flight_events.plans import WrittenTreeAdopted
from companion.flight_events.skills import (
    PlaceReached,
    SkillCompleted,
    SkillFailed,
    WrittenTreeFailed,
)
from companion.flight_events.sortie import Phase, TaskSatisfied
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.geometry import distance
from companion.mission.steps import Fly
from companion.mission.tree_nodes import (
    Act,
    Check,
    Fallback,
    Inverter,
    Parallel,
    Repeat,
    Steps,
    Subtree,
    Timeout,
    Tree,
    WaitFor,
    Watch,
)
from companion.outcomes import Failed, Progress

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
    assert [replace(position, reached_s=0.0) for position in rig.positions] == [
        PositionLeft(0, ("at(H)",), (), 0.0, (), (), for_ever=False),
        PositionLeft(1, ("at(A)",), (), 0.0, (), (), for_ever=False),
        PositionLeft(2, ("at(B)",), (), 0.0, (), (), for_ever=True),
    ]


@pytest.mark.parametrize(("never", "exit_code"), [("G !at(B)", 3), ("G !at(C)", 0)])
def test_a_tree_that_has_violated_the_task_does_not_end_well(never: str, exit_code: int) -> None:
    """It is flown to its end, which is no end of the task."""
    steps = Steps((Act("move(H, A)"), Act("move(A, B)")))
    asked = replace(mission({"visit": "F at(A)", "never": never}, places="HABC"), tree=steps)
    run = SortieRig(asked).until(Phase.ENDED)
    assert run.end.exit_code == exit_code
    assert run.position[:2] == (6.0, 6.0)
    if exit_code:
        assert run.failure.reason == "the tree is done, and has violated never"
    else:
        assert run.end == TaskSatisfied()


@pytest.mark.parametrize(
    ("lines", "priorities", "told"),
    [
        ({"visit": "F at(A)", "later": "F at(B)"}, {}, "has not met later"),
        ({"visit": "F at(A)", "later": "F at(B)"}, {"later": 1}, None),
        ({"visit": "F at(A)", "never": "G !at(A)"}, {"never": 1}, None),
        ({"again": "G F at(H)", "stay": "F G at(A)"}, {}, "has not met again"),
        (
            {"never": "G !at(A)", "later": "F at(B)", "calm": "G !at(C)"},
            {},
            "has violated never and has not met later",
        ),
        ({"next": "X at(A) & X X at(A)", "until": "at(H) U at(A)"}, {}, None),
    ],
)
def test_a_tree_that_leaves_a_line_unmet_does_not_end_well(
    lines: dict[str, str], priorities: dict[str, int], told: str | None
) -> None:
    """It rests at A for ever; `companion audit` says the same of the record."""
    steps = Steps((Act("move(H, A)"),))
    asked = replace(mission(lines, places="HABC"), tree=steps, priorities=priorities)
    run = SortieRig(asked).until(Phase.ENDED)
    assert run.position[:2] == (6.0, 0.0)
    if told is None:
        assert run.end == TaskSatisfied()
    else:
        assert run.end.exit_code == 3
        assert run.failure.reason == f"the tree is done, and {told}"


@pytest.mark.parametrize(("line", "is_met"), [("F at(H)", True), ("F at(A)", False)])
def test_a_line_that_begins_anew_at_the_end_is_judged_by_where_the_vehicle_is(
    line: str, is_met: bool
) -> None:
    """The position was left for a skill that has failed since."""
    again = event("again", restarts=["go"])
    task = Rig(replace(mission({"go": line}, events=[again]), tree=Steps(()))).flight.task
    task.leave()
    task.take(again, True)
    assert (failure_at_the_end(task) is None) == is_met


def test_a_belief_that_comes_back_does_not_stop_the_tree() -> None:
    """Nothing better can be planned for it."""
    do = replace(command("do", "", "done"), retry_after_s=0.5)
    either = Fallback((Act("do"), Act("move(H, A)")))
    steps = Steps((either, Act("move(A, B)")))
    rig = Rig(replace(mission({}, skills=[do]), tree=steps)).begin()
    rig.vehicle.payloads.answers = [(0.1, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.events[1:] == [
        *(SkillFailed("do", "denied"), BeliefWithdrawn("can_do"), BeliefRestored("can_do")),
        *(PlaceReached("A", "move(H, A)"), PlaceReached("B", "move(A, B)")),
    ]


def test_a_failure_ends_the_task_in_words() -> None:
    rig = fly(Act("do"), Act("move(H, A)"))
    rig.vehicle.payloads.answers = [(0.1, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.events[-1] == WrittenTreeFailed("do failed: denied")
    assert str(rig.executive.failure) == rig.events[-1].text
    assert rig.leave_for("H")


def test_a_fallback_takes_what_succeeds_first() -> None:
    rig = fly(Fallback((SEEN, Act("do"), Act("move(H, A)"))), Act("move(H, B)"))
    rig.vehicle.payloads.answers = [(0.1, Progress.DONE)]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["B"]


def test_an_inverter_turns_a_failure_into_a_success_and_back() -> None:
    rig = fly(Inverter(Steps((SEEN,))), Act("move(H, A)"), Inverter(Steps((UNSEEN,))))
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.places == ["A"]
    assert rig.events[-1] == WrittenTreeFailed("!seen succeeded")


def test_a_timeout_interrupts_its_steps() -> None:
    slow = Timeout(Steps((Act("move(H, A)"), Act("move(A, B)"))), 4.5)
    rig = fly(Fallback((slow, SEEN)))
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.flight.now_s == pytest.approx(4.5, abs=0.15)
    assert rig.task.facts == {"at(here)"}
    rig = fly(Timeout(Steps((Act("move(H, A)"),)), 20.0))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED


def test_the_reason_of_a_timeout_is_told() -> None:
    rig = fly(Timeout(Steps((Act("move(H, A)"),)), 2.0))
    rig.run_to_the_end()
    assert rig.events[-1] == WrittenTreeFailed("not done after 2 s")


def test_a_wait_takes_its_time_and_the_vehicle_stays() -> None:
    rig = fly(Act("move(H, A)"), WaitFor(5.0))
    rig.run_until(PlaceReached)
    there_s = rig.flight.now_s
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.flight.now_s - there_s == pytest.approx(5.0, abs=0.15)
    assert rig.vehicle.state is not None
    assert distance(rig.vehicle.state.motion.position, POSITIONS["A"]) < 0.1


def test_a_subtree_is_what_it_stands_for_each_time() -> None:
    there_and_back = Subtree("tour", Steps((Act("move(*, A)"), Act("move(*, H)"))))
    rig = fly(there_and_back, Act("move(H, B)"), there_and_back)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A", "H", "B", "A", "H"]


# -- parallel --------------------------------------------------------------------------------------


def test_a_parallel_succeeds_with_the_last_of_its_branches() -> None:
    """What has succeeded is not begun again; a wait beside a flight does not hold the vehicle."""
    flight = Steps((Act("move(H, A)"), Act("move(A, B)")))
    rig = fly(Parallel((flight, WaitFor(2.0), UNSEEN)))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A", "B"]
    alone = fly(flight)
    alone.run_to_the_end()
    assert rig.flight.now_s == alone.flight.now_s
    long = fly(Parallel((Act("move(H, A)"), WaitFor(30.0))))
    assert long.run_to_the_end() is TaskStatus.SATISFIED
    assert long.flight.now_s == pytest.approx(30.0, abs=0.15)


def test_a_parallel_fails_with_the_first_of_its_branches() -> None:
    late = Steps((WaitFor(1.0), SEEN))
    rig = fly(Fallback((Parallel((Act("move(H, A)"), late)), Act("move(here, B)"))))
    rig.run(lambda: "at(here)" in rig.task.facts)
    assert rig.flight.now_s == pytest.approx(1.0, abs=0.15)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["B"]
    assert rig.task.withdrawn == frozenset()  # it was interrupted; nothing has failed


# -- from wherever the vehicle is ------------------------------------------------------------------


def test_a_flight_from_anywhere_begins_at_a_place() -> None:
    rig = fly(Act("move(*, A)"), Act("move(*, B)"))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert [e.action for e in rig.of(PlaceReached)] == ["move(H, A)", "move(A, B)"]
    assert rig.task.facts == {"at(B)"}


def test_a_flight_from_anywhere_begins_between_places() -> None:
    watched = Watch(UNSEEN, Steps((Act("move(*, A)"),)))
    rig = fly(Fallback((watched, SEEN)), Act("move(*, B)"))
    for _ in range(20):
        rig.tick()
    rig.tick(reading("seen"))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert [e.action for e in rig.of(PlaceReached)] == ["move(here, B)"]


def test_a_flight_from_anywhere_to_where_the_vehicle_is_is_done_already() -> None:
    rig = fly(Act("move(*, H)"), Act("move(*, A)"), Act("move(*, A)"))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A"]
    assert len(rig.positions) == 2


def test_a_flight_from_anywhere_withdraws_what_the_flight_has_assumed() -> None:
    rig = fly(Fallback((Act("move(*, A)"), Act("move(*, B)"))), Act("move(*, H)"))
    rig.tick()
    rig.vehicle.is_stuck = True
    rig.run_until(BeliefWithdrawn, belief="trans_ok(H, A)")
    rig.vehicle.is_stuck = False
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert [e.action for e in rig.of(PlaceReached)] == ["move(here, B)", "move(B, H)"]
    assert rig.task.withdrawn == {"trans_ok(H, A)"}


def test_a_skill_with_more_to_do_than_to_be_there_is_not_done_by_being_there() -> None:
    made = skill("look", Fly("to"), "from to", "at(from)", (), "at(to) & !at(from) & seen_all")
    rig = Rig(replace(mission({}, skills=[made]), tree=Steps((Act("look(*, H)"),)))).begin()
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert "look(*, H) cannot begin" in rig.events[-1].text


# -- repeats and watches ---------------------------------------------------------------------------


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
