"""`retry` in a tree written by hand, together with all that a skill may do, and with pauses."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rig import Rig
from synthetic import POSITIONS, command, event, facts_of, mission, move, reading, skill

from companion.acting.executive_states import TaskStatus
from companion.acting.sortie.sortie import Sortie
from companion.flight_events.facts import BeliefRestored, BeliefWithdrawn
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed, SymbolMoved
from companion.flight_events.sortie import Phase, VehicleAirborne, VehicleLanded
from companion.flight_events.word import PositionLeft
from companion.mission.skills import Skill
from companion.mission.steps import Charge, Command, Fly, Land, TakeOff
from companion.mission.tree_nodes import (
    Act,
    Check,
    Fallback,
    Repeat,
    Retry,
    Steps,
    Timeout,
    Tree,
    Watch,
)
from companion.outcomes import Failed, Progress
from companion.vehicle.ports.goals import Goal

DENIED = (0.1, Failed("denied"))
DONE = (0.1, Progress.DONE)
UNSEEN = Check("!seen", frozenset(), facts_of("seen"))
DO = command("do", "", "done")


def fly(*nodes: Tree, skills: tuple[Skill, ...] = (DO,), answers: object = ()) -> Rig:
    again = replace(event("again"), restores=frozenset({"can_do"}))
    made = mission({}, skills=skills, events=[event("seen"), again])
    rig = Rig(replace(made, tree=Steps(nodes))).begin()
    rig.vehicle.payloads.answers = list(answers)  # type: ignore[call-overload]
    return rig


def retry(times: int, *nodes: Tree) -> Retry:
    return Retry(Steps(nodes), times)


# -- how often -------------------------------------------------------------------------------------


@pytest.mark.parametrize("times", [1, 2, 4])
def test_a_skill_that_assumes_something_is_tried_so_often(times: int) -> None:
    rig = fly(retry(times, Act("do")), answers=[DENIED] * 9)
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert len(rig.vehicle.payloads.sent) == times
    assert rig.of(SkillFailed) == [SkillFailed("do", "denied")] * times
    assert rig.of(BeliefWithdrawn) == [BeliefWithdrawn("can_do")]
    assert rig.events[-2] == BeliefWithdrawn("can_do")


def test_a_try_that_succeeds_leaves_the_belief() -> None:
    rig = fly(retry(3, Act("do")), Act("do"), answers=[DENIED, DENIED, DONE, DONE])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of(BeliefWithdrawn) == []
    assert rig.of(SkillCompleted) == [SkillCompleted("do")] * 2


@pytest.mark.parametrize(("tries", "times"), [(1, 3), (2, 2), (3, 1)])
def test_the_tries_of_a_skill_are_counted_within_each_of_the_retry(tries: int, times: int) -> None:
    rig = fly(retry(times, Act("do")), skills=(replace(DO, tries=tries),), answers=[DENIED] * 19)
    rig.run_to_the_end()
    assert len(rig.vehicle.payloads.sent) == tries * times
    assert len(rig.of(SkillFailed)) == times


def test_a_retry_in_a_retry_gives_up_with_the_last_of_all_tries() -> None:
    rig = fly(retry(2, retry(3, Act("do"))), answers=[DENIED] * 19)
    rig.run_to_the_end()
    assert len(rig.vehicle.payloads.sent) == 6
    assert len(rig.of(BeliefWithdrawn)) == 1


def test_a_retry_that_begins_anew_has_all_of_its_tries() -> None:
    answers = [DENIED, DONE, DENIED, DONE, DENIED, DENIED]
    rig = fly(Repeat(Steps((retry(2, Act("do")),)), None), answers=answers)
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert len(rig.vehicle.payloads.sent) == 6
    assert len(rig.of(BeliefWithdrawn)) == 1


def test_what_fails_in_a_fallback_of_a_retry_is_another_way_and_not_the_last_try() -> None:
    rig = fly(retry(2, Fallback((Act("do"), Act("move(H, A)")))), answers=[DENIED])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A"]
    assert rig.task.withdrawn == frozenset()


def test_a_belief_comes_back_after_its_time_counted_from_the_last_try() -> None:
    patient = replace(DO, retry_after_s=5.0)
    either = Fallback((retry(2, Act("do")), Act("move(H, A)")))
    rig = fly(either, Act("move(A, H)"), Act("do"), skills=(patient,), answers=[DENIED, DENIED])
    rig.run_until(BeliefWithdrawn)
    assert rig.of(BeliefRestored) == []
    withdrawn_s = rig.flight.now_s
    rig.run_until(BeliefRestored)
    assert rig.flight.now_s - withdrawn_s == pytest.approx(5.0, abs=0.1)


def test_an_event_that_restores_beliefs_finds_none_to_restore_between_tries() -> None:
    rig = fly(retry(2, Act("do")), answers=[DENIED, (5.0, Progress.DONE)])
    rig.run_until(SkillFailed)
    rig.tick(reading("again"))
    assert rig.of(BeliefRestored) == []
    assert rig.run_to_the_end() is TaskStatus.SATISFIED


# -- flights ---------------------------------------------------------------------------------------


def stuck(*nodes: Tree) -> Rig:
    """Somewhere between H and A the vehicle comes no further, for two tries."""
    rig = fly(*nodes, skills=(move(tries=1, timeout_s=2.0), DO))
    for _ in range(20):
        rig.tick()
    rig.vehicle.is_stuck = True
    rig.run_until(SkillFailed, times=2)
    rig.vehicle.is_stuck = False
    return rig


@pytest.mark.parametrize("name", ["move(H, A)", "move(*, A)"])
def test_a_flight_is_tried_again_from_where_it_has_failed(name: str) -> None:
    rig = stuck(retry(3, Act(name)))
    assert rig.task.withdrawn == frozenset()
    assert len(rig.of(SymbolMoved)) == 1  # each try has another waypoint
    rig.vehicle.change(position=POSITIONS["A"])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of(PlaceReached) == [PlaceReached("A", "move(H, A)")]
    assert rig.task.facts == facts_of("at(A)")
    assert [p.facts for p in rig.positions] == [("at(H)",), ("at(A)",)]


def test_after_its_last_try_a_flight_has_failed_and_the_vehicle_is_between_places() -> None:
    rig = stuck(Fallback((retry(2, Act("move(H, A)")), Act("move(here, B)"))))
    assert rig.task.withdrawn == facts_of("trans_ok(H, A)")
    assert rig.task.facts == facts_of("at(here)")
    rig.vehicle.change(position=POSITIONS["B"])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["B"]


def test_a_flight_that_something_else_has_followed_does_not_begin_again() -> None:
    """A retry goes on with a flight only as long as no position was reached since."""
    rig = stuck(retry(2, Fallback((retry(2, Act("move(H, A)")), Act("move(here, B)"))), Act("do")))
    rig.vehicle.change(position=POSITIONS["B"])
    rig.vehicle.payloads.answers = [DENIED]
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.task.facts == facts_of("at(B)")
    assert [e.action for e in rig.of(PlaceReached)] == ["move(here, B)"]
    assert len(rig.of(SkillFailed, action="move(H, A)")) == 2


def test_without_a_retry_an_interrupted_flight_is_over() -> None:
    watched = Watch(UNSEEN, Steps((Act("move(H, A)"),)))
    rig = fly(Fallback((watched, Act("move(H, A)"))))
    rig.tick()
    rig.tick(reading("seen"))
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN


def test_a_watch_that_ends_a_try_is_followed_by_another_one() -> None:
    rig = fly(retry(2, Watch(UNSEEN, Steps((Act("move(H, A)"),)))))
    for _ in range(20):
        rig.tick()
    rig.tick(reading("seen"))
    assert rig.executive.status is TaskStatus.RUNNING
    rig.tick(reading("seen", 0.0))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A"]


# -- landings --------------------------------------------------------------------------------------


def on_the_ground(*nodes: Tree, skills: tuple[Skill, ...]) -> tuple[Rig, Sortie]:
    """A whole sortie, which takes off by itself."""
    made = replace(mission({}, skills=skills), tree=Steps(nodes))
    rig = Rig(made)
    rig.vehicle.change(is_landed=True, is_armed=False, position=(0.0, 0.0, 0.0))
    return rig, Sortie(rig.acting, made)


def until_the_end(rig: Rig, sortie: Sortie) -> None:
    for _ in range(round(300 / 0.05)):
        rig.pass_time()
        sortie.step(rig.flight.now_s, ())
        if sortie.phase in (Phase.LANDING, Phase.ENDED):
            return
    raise AssertionError(sortie.phase)


DOCK = replace(
    skill("dock", Land(), "from to", "at(from)", ["pad(to)"], "at(to) & !at(from)"),
    execute=(Fly("to"), Land(), Command(25, 31010, "MAV_CMD_USER_1", ())),
    distinct=(("to", "H"),),
)
LEAVE = replace(command("leave", "", "left"), execute=(Charge(10), TakeOff()))


def test_a_skill_that_fails_on_the_ground_is_tried_again_in_the_air() -> None:
    rig, sortie = on_the_ground(retry(2, Act("dock(H, A)")), Act("leave"), skills=(DOCK, LEAVE))
    rig.vehicle.payloads.answers = [DENIED, DONE]
    until_the_end(rig, sortie)
    assert sortie.failure is None
    told = [s.event for s in rig.flight.reports]
    assert told.count(VehicleLanded()) == 2
    up = [Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD]
    assert rig.vehicle.pursued == [*up, Goal.LANDED, *up, Goal.LANDED, *up]


def test_what_follows_a_failure_on_the_ground_begins_in_the_air() -> None:
    either = Fallback((Act("dock(H, A)"), Act("move(*, B)")))
    rig, sortie = on_the_ground(either, skills=(DOCK, LEAVE))
    rig.vehicle.payloads.answers = [DENIED]
    until_the_end(rig, sortie)
    assert sortie.failure is None
    assert PlaceReached("B", "move(here, B)") in [s.event for s in rig.flight.reports]


def test_a_skill_that_begins_on_the_ground_is_tried_again_there() -> None:
    ask = replace(LEAVE, execute=(Command(25, 31010, "MAV_CMD_USER_1", ()), TakeOff()))
    rig, sortie = on_the_ground(Act("dock(H, A)"), retry(3, Act("leave")), skills=(DOCK, ask))
    rig.vehicle.payloads.answers = [DONE, DENIED, DENIED, DONE]
    until_the_end(rig, sortie)
    assert sortie.failure is None
    assert len(rig.vehicle.payloads.sent) == 4
    told = [s.event for s in rig.flight.reports]
    assert (told.count(VehicleLanded()), told.count(VehicleAirborne())) == (1, 1)


# -- pauses ----------------------------------------------------------------------------------------


def pause(rig: Rig, duration_s: float) -> None:
    rig.executive.pause()
    for _ in range(round(duration_s / 0.05)):
        rig.pass_time()
    rig.executive.resume()


def test_a_pause_is_no_failed_try_and_the_answer_counts() -> None:
    rig = fly(retry(2, Act("do")), answers=[DENIED, (9.0, Progress.DONE), DONE])
    rig.run_until(SkillFailed)
    rig.tick()
    pause(rig, 5.0)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert len(rig.vehicle.payloads.sent) == 2
    assert len(rig.of(SkillFailed)) == 1


def test_after_a_pause_the_tree_goes_on_where_it_was() -> None:
    rig = fly(Act("move(H, A)"), Act("move(A, B)"), Act("move(B, H)"))
    rig.run_until(PlaceReached, place="A")
    for _ in range(30):
        rig.tick()
    pause(rig, 5.0)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A", "B", "H"]
    assert [p.facts for p in rig.positions] == [("at(H)",), ("at(A)",), ("at(B)",), ("at(H)",)]
    assert isinstance(rig.positions[-1], PositionLeft)


def test_time_limits_do_not_count_a_pause() -> None:
    limited = Timeout(Steps((Act("move(H, A)"),)), 8.0)
    rig = fly(limited)
    for _ in range(20):
        rig.tick()
    pause(rig, 20.0)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED


def test_a_vehicle_that_was_moved_in_a_pause_flies_on_from_there() -> None:
    rig = fly(Act("move(H, A)"), Act("move(A, B)"))
    for _ in range(20):
        rig.tick()
    rig.executive.pause()
    rig.vehicle.change(position=POSITIONS["B"])
    rig.flight.guidance.forget_setpoint()
    rig.executive.resume()
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A", "B"]


def test_a_timeout_around_a_retry_on_the_ground_ends_all_of_its_tries() -> None:
    slow = replace(LEAVE, execute=(Command(25, 31010, "MAV_CMD_USER_1", ()), TakeOff()))
    limited = Timeout(Steps((retry(3, Act("leave")),)), 5.0)
    nodes = (Act("dock(H, A)"), Fallback((limited, Act("move(*, B)"))))
    rig, sortie = on_the_ground(*nodes, skills=(DOCK, slow))
    rig.vehicle.payloads.answers = [DONE, (0.0, Progress.RUNNING)]
    until_the_end(rig, sortie)
    assert sortie.failure is None
    told = [s.event for s in rig.flight.reports]
    assert PlaceReached("B", "move(A, B)") in told


def test_no_watch_interrupts_on_the_ground() -> None:
    """What was begun there is finished first, as in a plan."""
    slow = replace(DOCK, execute=(Fly("to"), Land(), Charge(80), TakeOff()))
    rig = fly(Watch(UNSEEN, Steps((Act("dock(H, A)"), Act("move(A, B)")))), skills=(slow,))
    rig.vehicle.change(battery_percent=20)
    rig.run_until(VehicleLanded)
    rig.tick(reading("seen"))
    rig.vehicle.change(battery_percent=90)
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN  # in the air again it is interrupted
    assert rig.of(VehicleAirborne) == [VehicleAirborne()]
    assert rig.places == []
