"""`tries` and `timeout_s` of skills, whatever they are made of: how often, how long each time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from rig import Rig
from synthetic import POSITIONS, command, mission, move, skill

from companion.acting.docks import AnyDock
from companion.acting.executive_states import TaskStatus
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.skills import SkillCompleted, SkillFailed, SymbolMoved
from companion.flight_events.sortie import VehicleAirborne, VehicleLanded
from companion.mission.skills import Skill
from companion.mission.steps import Charge, Command, Do, Execution, Fly, Land, TakeOff, Wait
from companion.outcomes import Failed, Progress
from companion.vehicle.ports.goals import Goal

DENIED = (0.1, Failed("denied"))
DONE = (0.1, Progress.DONE)
SILENT = (0.0, Progress.RUNNING)
ALMOST_EMPTY = type("AlmostEmpty", (AnyDock,), {"lasts_for_another_try": False})()
PHOTO = Command(25, 31010, "MAV_CMD_USER_1", (1.0,))
SHOT = Command(25, 31010, "MAV_CMD_USER_1", (2.0,))


def made_of(*steps: object, **more: object) -> Skill:
    """The skill `do`, which makes `done` true and assumes `can_do`."""
    return replace(command("do", "", "done"), execute=steps, **more)  # type: ignore[arg-type]


def begin(*skills: Skill, answers: object = ()) -> Rig:
    rig = Rig(mission("F done", skills=skills)).begin()
    rig.vehicle.payloads.answers = list(answers)  # type: ignore[call-overload]
    return rig


def sent(rig: Rig) -> list[float]:
    """The first parameters of the commands, in order."""
    return [parameters[0] for _, _, parameters in rig.vehicle.payloads.sent]


# -- how often -------------------------------------------------------------------------------------


@pytest.mark.parametrize("tries", [1, 2, 5])
def test_a_command_is_tried_so_often_and_then_its_belief_is_given_up(tries: int) -> None:
    rig = begin(made_of(PHOTO, tries=tries), answers=[DENIED] * 9)
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert len(rig.vehicle.payloads.sent) == tries
    assert rig.of(SkillFailed) == [SkillFailed("do", "denied")]
    assert rig.of(BeliefWithdrawn) == [BeliefWithdrawn("can_do")]


def test_a_try_that_succeeds_is_the_last_and_nothing_has_failed() -> None:
    rig = begin(made_of(PHOTO, tries=3), answers=[DENIED, DONE])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert len(rig.vehicle.payloads.sent) == 2
    assert rig.of(SkillFailed) == []
    assert rig.task.withdrawn == frozenset()


def test_of_a_list_of_steps_all_are_tried_again() -> None:
    rig = begin(made_of(PHOTO, SHOT, tries=3), answers=[DONE, DENIED, DENIED, DONE, DONE])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert sent(rig) == [1.0, 2.0, 1.0, 1.0, 2.0]


def test_a_skill_in_a_skill_has_its_own_tries_each_time() -> None:
    inner = replace(made_of(SHOT, tries=3), name="shoot", is_planned=False, assumes=())
    outer = made_of(PHOTO, Do("shoot", ()), tries=2)
    rig = begin(outer, inner, answers=[DONE, DENIED, DENIED, DENIED, DONE, DENIED, DONE])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert sent(rig) == [1.0, 2.0, 2.0, 2.0, 1.0, 2.0, 2.0]


def look(tries: int) -> Skill:
    """Flies to a place and asks the payload; all that `look` needs is assumed."""
    looked = "at(to) & !at(from) & done"
    made = skill("look", PHOTO, "from to", "at(from)", ["can_see(to)"], looked, tries=tries)
    return replace(made, execute=(Fly("to"), PHOTO))


def test_a_place_that_was_reached_is_flown_to_at_the_same_waypoint_again() -> None:
    """The payload has refused; the flight has not failed."""
    rig = begin(look(tries=3), answers=[DENIED, DENIED, DONE])
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert len(rig.vehicle.payloads.sent) == 3
    assert rig.of(SymbolMoved) == []


def test_a_place_to_which_the_flight_has_failed_is_flown_to_at_another_waypoint() -> None:
    rig = begin(look(tries=3), answers=[DONE])
    rig.vehicle.drift = (0.4, 0.0, 0.0)  # it never comes as near as arrival asks for
    rig.run_until(SymbolMoved)
    rig.vehicle.drift = (0.0, 0.0, 0.0)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    (moved,) = rig.of(SymbolMoved)
    assert moved.position != POSITIONS[moved.place]
    assert rig.task.withdrawn == frozenset()


# -- how long --------------------------------------------------------------------------------------


@pytest.mark.parametrize("tries", [1, 2, 3])
@pytest.mark.parametrize(
    "steps",
    [(PHOTO,), (Wait(1.0), PHOTO), (Wait(60.0),), (Wait(2.0), Wait(2.0)), (Do("inner", ()),)],
    ids=["command", "list", "wait", "waits", "skill"],
)
def test_each_try_has_the_time_limit(steps: tuple[object, ...], tries: int) -> None:
    inner = replace(made_of(Wait(60.0)), name="inner", is_planned=False, assumes=())
    rig = begin(made_of(*steps, tries=tries, timeout_s=3.0), inner, answers=[SILENT] * tries)
    rig.run_until(SkillFailed)
    assert rig.flight.now_s == pytest.approx(tries * 3.0, abs=tries * 0.2)


def test_a_flight_has_the_time_limit_for_each_try() -> None:
    rig = Rig(mission("F at(A)", places="HA", skills=[move(tries=3, timeout_s=2.0)])).begin()
    rig.vehicle.is_stuck = True
    rig.run_until(SkillFailed)
    assert rig.flight.now_s == pytest.approx(6.0, abs=0.5)
    assert len(rig.of(SymbolMoved)) == 2


@pytest.mark.parametrize(
    ("outer_s", "inner_s", "expected"),
    [(30.0, None, [30.0, 30.0]), (30.0, 12.0, [30.0, 12.0]), (None, 12.0, [None, 12.0])],
)
def test_a_command_among_steps_may_take_all_of_the_skills_time(
    outer_s: float | None, inner_s: float | None, expected: list[float | None]
) -> None:
    """Else the command protocol would give up a payload that has half a minute."""
    inner = replace(made_of(Wait(0.1), SHOT, timeout_s=inner_s), name="shoot", is_planned=False)
    outer = made_of(PHOTO, Do("shoot", ()), timeout_s=outer_s)
    rig = begin(outer, replace(inner, assumes=()))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.vehicle.payloads.patience == expected


# -- landings --------------------------------------------------------------------------------------


def dock(*steps: Execution, tries: int) -> Rig:
    made = skill("dock", PHOTO, "from to", "at(from)", ["pad(to)"], "at(to) & !at(from) & done")
    docks = replace(made, execute=steps, tries=tries, distinct=(("to", "H"), ("to", "B")))
    return Rig(mission("F done", skills=[docks])).begin()


def test_another_try_of_a_landing_begins_in_the_air() -> None:
    rig = dock(Fly("to"), Land(), PHOTO, TakeOff(), tries=3)
    rig.vehicle.payloads.answers = [DENIED, DONE]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.of(SkillFailed) == []
    assert len(rig.of(VehicleLanded)) == len(rig.of(VehicleAirborne)) == 2
    up = [Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD]
    assert rig.vehicle.pursued == [Goal.LANDED, *up, Goal.LANDED, *up]


def test_without_the_charge_for_it_a_landing_is_not_tried_again() -> None:
    """It stays on the ground."""
    rig = dock(Fly("to"), Land(), PHOTO, TakeOff(), tries=3)
    rig.flight.dock = ALMOST_EMPTY
    rig.vehicle.payloads.answers = [DENIED] * 9
    rig.run_until(SkillFailed)
    (failed,) = rig.of(SkillFailed)
    assert failed.reason == "not tried again: the charge does not last for it, the reserve left"
    assert len(rig.of(VehicleLanded)) == 1 and not rig.of(VehicleAirborne)
    assert rig.vehicle.pursued == [Goal.LANDED]


def test_a_landing_that_fails_is_begun_again_from_the_air() -> None:
    rig = dock(Fly("to"), Land(), TakeOff(), tries=2)
    rig.vehicle.goals.script[Goal.LANDED] = (1.0, Failed("not landed"))
    rig.run_until(VehicleAirborne)
    del rig.vehicle.goals.script[Goal.LANDED]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.task.withdrawn == frozenset()


def test_what_began_on_the_ground_and_has_taken_off_is_not_tried_again() -> None:
    """Nobody has said where it may land."""
    leave = replace(made_of(Charge(10), TakeOff(), PHOTO, tries=3), name="leave", assumes=())
    leave = replace(leave, is_planned=False)
    rig = begin(made_of(Land(), Do("leave", ())), leave, answers=[DENIED] * 9)
    rig.run_until(SkillFailed, reason="not tried again: it began on the ground, and is in the air")
    assert len(rig.vehicle.payloads.sent) == 1
    assert rig.vehicle.pursued.count(Goal.LANDED) == 1


# -- against a reference ---------------------------------------------------------------------------

Outcomes = Iterator[bool]
Node = str | tuple[int, list["Node"]]
"""A photo, or steps with a number of tries."""
NESTED = st.recursive(
    st.just("photo"),
    lambda inner: st.tuples(st.integers(1, 3), st.lists(inner, min_size=1, max_size=3)),
    max_leaves=5,
)


def tried(node: Node, outcomes: Outcomes, log: list[bool]) -> bool:
    """What a refinement does, written down once more: so many tries of steps in order."""
    if isinstance(node, str):
        log.append(next(outcomes))
        return log[-1]
    tries, steps = node
    return any(all(tried(s, outcomes, log) for s in steps) for _ in range(tries))


def skills_of(node: Node, name: str) -> list[Skill]:
    """The skill of a node, and those that refine it."""
    tries, nodes = (1, [node]) if isinstance(node, str) else node
    found: list[Skill] = []
    steps: list[Execution] = []
    for i, each in enumerate(nodes):
        if isinstance(each, str):
            steps.append(PHOTO)
        else:
            steps.append(Do(f"{name}_{i}", ()))
            found += skills_of(each, f"{name}_{i}")
    made = replace(made_of(*steps, tries=tries), name=name)
    is_inner = name != "do"
    own = replace(made, is_planned=not is_inner, assumes=() if is_inner else made.assumes)
    return [own, *found]


@pytest.mark.slow
@drawn(60)
@given(NESTED, st.lists(st.booleans(), min_size=20, max_size=20))
def test_any_refinement_does_what_the_reference_does(node: Node, outcomes: list[bool]) -> None:
    log: list[bool] = []
    endless = iter([*outcomes, *[True] * 500])
    is_done = tried(node, endless, log)
    rig = begin(*skills_of(node, "do"))
    rig.vehicle.payloads.answers = [
        (0.0, Progress.DONE if o else Failed("denied")) for o in outcomes
    ]
    rig.run(lambda: bool(rig.of(SkillCompleted) or rig.of(SkillFailed)))
    assert len(rig.vehicle.payloads.sent) == len(log)
    assert bool(rig.of(SkillCompleted)) == is_done
