"""No rise of an event is lost: what rises for a moment, on the way, is read and answered."""

from __future__ import annotations

from dataclasses import replace

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from rig import Rig
from sortie_rig import SortieRig
from synthetic import command, event, mission, reading

from companion.acting.executive_states import TaskStatus
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillFailed
from companion.flight_events.sortie import Phase, TaskSatisfied
from companion.mission.conditions import parse_condition
from companion.mission.events import Event
from companion.mission.model import Mission
from companion.mission.signals import COMMAND, Signal
from companion.mission.steps import Land, TakeOff, Wait
from companion.outcomes import Failed

ASKED = event("asked")
PATROL = "G F at(A) & G F at(B)"
CALL = Signal(COMMAND, "", "MAV_CMD_USER_1")


def on_request(*lines: str, asked: Event = ASKED) -> Mission:
    """Patrol A and B; come to H whenever asked."""
    return mission({"patrol": PATROL, "come": "G (asked -> F at(H))"}, events=[asked])


def raise_for(rig: Rig, ticks: int) -> None:
    """The event is true for so many ticks; for none it falls in the tick in which it rises."""
    if ticks == 0:
        rig.tick(reading("asked"), reading("asked", 0.0))
        return
    rig.tick(reading("asked"))
    for _ in range(ticks - 1):
        rig.tick()
    rig.tick(reading("asked", 0.0))


def requests(rig: Rig) -> list[int]:
    """The positions with the event."""
    return [position.number for position in rig.positions if "asked" in position.facts]


@pytest.mark.parametrize("ticks", [0, 1, 20])
def test_a_moment_in_the_middle_of_a_leg_is_in_the_word_once_and_answered(ticks: int) -> None:
    rig = Rig(on_request()).begin()
    rig.run_until(PlaceReached, place="A")
    for _ in range(40):
        rig.tick()
    raise_for(rig, ticks)
    rig.run_until(PlaceReached, place="H")
    rig.run_until(PlaceReached, times=4)
    (number,) = requests(rig)
    (read,) = (p for p in rig.positions if p.number == number)
    assert read.risen == ("asked",)
    visits = [reached.place for reached in rig.of(PlaceReached)]
    assert "H" in visits[number - 1 :], "after the position that has it"
    assert rig.of(PlanReplaced)[0].reason == "asked"


def test_a_command_is_a_pulse_and_each_one_is_answered() -> None:
    called = Event(
        "asked", parse_condition("COMMAND.MAV_CMD_USER_1"), None, False, 0.0, frozenset()
    )
    rig = Rig(on_request(asked=called)).begin()
    for visit in (1, 2, 3):
        rig.run_until(PlaceReached, times=2 * visit, place="A")
        rig.tick((CALL, 1.0))
        rig.run_until(PlaceReached, times=visit, place="H")
    assert [change.holds for change in rig.of(MissionEventChanged)] == [True, False] * 3
    assert len(requests(rig)) == 3


def test_a_rise_that_changes_nothing_in_the_plan_interrupts_nothing() -> None:
    rig = Rig(mission({"come": "G (asked -> F at(A))", "patrol": PATROL}, events=[ASKED])).begin()
    for _ in range(10):
        rig.tick()
    raise_for(rig, 1)
    rig.run_until(PlaceReached, times=4)
    assert rig.executive.reports.replans == 0
    assert requests(rig) == [1]


def test_interruptions_and_replans_on_the_way_consume_no_rise() -> None:
    """Another event interrupts twice before the next position is read."""
    other = event("other")
    task = {
        "patrol": "G (F at(A) | other) & G F at(B)",
        "come": "G (asked -> F at(H))",
    }
    rig = Rig(mission(task, places="HABC", events=[ASKED, other])).begin()
    rig.run_until(PlaceReached, place="A")
    for _ in range(10):
        rig.tick()
    raise_for(rig, 0)
    for value in (1.0, 0.0):
        for _ in range(10):
            rig.tick()
        rig.tick(reading("other", value))
    rig.executive.stop()
    rig.executive.resume()
    rig.run_until(PlaceReached, place="H")
    assert len(requests(rig)) == 1


def on_the_ground(come: str, *more: TakeOff) -> Mission:
    """A service at H on the ground, of which nothing goes on; and come to A whenever asked."""
    service = replace(command("service", "at(H)", "serviced"), execute=(Land(), Wait(1.0), *more))
    task = {"goal": "F serviced", "come": f"G (asked -> {come})"}
    return mission(task, skills=[service], events=[ASKED])


@pytest.mark.parametrize("ticks", [0, 1, 10])
@pytest.mark.parametrize("come", ["F at(A)", "X at(A)"])
def test_a_moment_on_the_ground_is_answered(ticks: int, come: str) -> None:
    """There it interrupts nothing, and was forgotten when the next skill began in the same tick."""
    rig = Rig(on_the_ground(come, TakeOff())).begin()
    rig.run(lambda: rig.flight.progress.is_landed_by_plan)
    raise_for(rig, ticks)
    assert rig.of(PlanReplaced) == []
    rig.run_until(PlanReplaced)
    assert rig.one(PlanReplaced).reason == "asked"
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.one(PlaceReached).place == "A"
    (number,) = requests(rig)
    assert "at(A)" in rig.positions[number + 1].facts


def test_a_moment_is_answered_where_the_plan_would_have_stayed_on_the_ground() -> None:
    run = SortieRig(on_the_ground("F at(A)"))
    while not run.rig.flight.progress.is_landed_by_plan:
        run.step()
    run.step(reading("asked"), reading("asked", 0.0))
    run.until(Phase.ENDED)
    assert isinstance(run.end, TaskSatisfied)
    assert run.one(PlaceReached).place == "A"


def test_a_failed_command_consumes_no_rise() -> None:
    task = {"work": "F done | F at(B)", "come": "G (asked -> F at(A))"}
    rig = Rig(mission(task, skills=[command("do", "at(H)", "done")], events=[ASKED]))
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))]
    rig.begin()
    rig.tick()
    raise_for(rig, 0)
    rig.run_until(SkillFailed, times=1)
    assert requests(rig) == []
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert requests(rig) == [1]
    assert {reached.place for reached in rig.of(PlaceReached)} == {"A", "B"}


def test_a_precondition_sees_what_holds_now() -> None:
    """A plan may not count on an event that is over."""
    answer = command("answer", "asked", "answered")
    task = {"answer": "G (asked -> F answered)", "stay": "F at(A)"}
    rig = Rig(mission(task, skills=[answer], events=[ASKED])).begin()
    for _ in range(10):
        rig.tick()
    raise_for(rig, 0)
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN


def test_an_event_that_only_restarts_lines_makes_a_new_plan() -> None:
    again = event("again", restarts=["visit"])
    rig = Rig(mission({"visit": "F at(A)", "patrol": "G F at(B)"}, events=[again])).begin()
    rig.run_until(PlaceReached, times=1, place="B")
    rig.tick(reading("again"), reading("again", 0.0))
    rig.run_until(PlaceReached, times=2, place="A")


@pytest.mark.slow
@drawn(25)
@given(
    st.lists(st.tuples(st.integers(1, 60), st.sampled_from("xy"), st.integers(0, 40)), max_size=6),
    st.sampled_from(
        [
            {"x": "G (x -> F at(H))", "y": "G (y -> F at(C))"},
            {"x": "G (x -> (F (at(C) & X F at(H))))", "y": "G (F at(B) | y)"},
            {"x": "G F at(A) & G (x -> X (!x W at(A)))", "y": "G (y -> F x | F at(C))"},
        ]
    ),
)
def test_random_moments_are_all_read_and_each_once(
    moments: list[tuple[int, str, int]], task: dict[str, str]
) -> None:
    """Held against what the flight has told of each event and each position."""
    lines = {"patrol": PATROL, **task}
    rig = Rig(mission(lines, places="HABC", events=[event("x"), event("y")])).begin()
    changes: dict[int, list[tuple[str, float]]] = {}
    tick = 0
    for pause, name, duration in moments:
        tick += pause
        changes.setdefault(tick, []).append((name, 1.0))
        changes.setdefault(tick + duration, []).append((name, 0.0))
    for now in range(tick + 400):
        rig.tick(*(reading(name, value) for name, value in changes.get(now, [])))
    _check_word(rig)


def _visits(rig: Rig) -> list[str]:
    return [reached.place for reached in rig.of(PlaceReached)]


def _check_word(rig: Rig) -> None:
    """An event is in a letter exactly if it holds then, or has risen since the letter before."""
    changes = [
        (stamped.time_s, stamped.event.event, stamped.event.holds)
        for stamped in rig.reports
        if isinstance(stamped.event, MissionEventChanged)
    ]
    for before_s, left_s, position in zip(
        [-1.0, *rig.left_s], rig.left_s, rig.positions, strict=False
    ):
        for name in "xy":
            own = [(t, holds) for t, changed, holds in changes if changed == name and t <= left_s]
            holds_now = own[-1][1] if own else False
            has_risen = any(holds and t > before_s for t, holds in own)
            assert (name in position.facts) == (holds_now or has_risen)
            assert (name in position.risen) == (has_risen and not holds_now)
