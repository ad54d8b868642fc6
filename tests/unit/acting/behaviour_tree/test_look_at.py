"""Headings in the tree: of a place, and of a skill that looks at something."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from leaves import a_rig, later, run, tick
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from pytest import approx
from rig import Rig
from synthetic import POSITIONS, command, mission, move, skill

from companion.acting.behaviour_tree import pausing
from companion.acting.behaviour_tree.builder import action_tree
from companion.acting.behaviour_tree.intention import Intention
from companion.acting.behaviour_tree.leaves import Rest
from companion.acting.behaviour_tree.look_at import TURN_TIMEOUT_S, LookAt
from companion.acting.behaviour_tree.move import ARRIVAL_TIMEOUT_S, MoveCommand
from companion.flight_events.skills import SkillFailed
from companion.mission.model import Mission
from companion.mission.places import PointOfInterest
from companion.mission.skills import Skill
from companion.mission.steps import Do, Land, TakeOff, Wait
from companion.motion.heading import HEADING_TOLERANCE_RAD, error_rad
from companion.tick import TICK_S
from companion.vehicle_profile import VehicleProfile

RATE = VehicleProfile().yaw_rate_radps
EAST, SOUTH, WEST = math.pi / 2, math.pi, -math.pi / 2
TOWER = PointOfInterest("tower", (0.0, -50.0))
"""West of H."""


def heading_at(place: str, heading_rad: float) -> Rig:
    """A flight to the place leaves the heading free otherwise."""
    places = a_rig().mission.places
    turned = replace(places[place], heading_rad=heading_rad)
    return a_rig(places={**places, place: turned})


def told(rig: Rig) -> list[float]:
    return [setpoint.yaw_rad for setpoint in rig.vehicle.flown if setpoint is not None]


# -- the heading of a place --------------------------------------------------------------------


def test_the_vehicle_flies_as_ever_and_turns_at_the_place() -> None:
    rig, free = heading_at("A", SOUTH), a_rig()
    assert run(rig, MoveCommand(rig.flight, "A", None)) is Status.SUCCESS
    assert run(free, MoveCommand(free.flight, "A", None)) is Status.SUCCESS
    flown = len(free.vehicle.flown)
    assert rig.vehicle.flown[: flown - 1] == free.vehicle.flown[:-1]
    turning = rig.vehicle.flown[flown:]
    assert {s.position for s in turning if s is not None} == {POSITIONS["A"]}
    assert error_rad(told(rig)[-1], SOUTH) <= HEADING_TOLERANCE_RAD
    steps = [error_rad(a, b) for a, b in pairwise(told(rig))]
    assert max(steps) <= RATE * TICK_S + 1e-9


def test_a_slow_vehicle_has_the_time_for_its_turn() -> None:
    rig = heading_at("A", SOUTH)
    rig.flight.profile = replace(rig.flight.profile, yaw_rate_radps=0.1)
    assert math.pi / 0.1 > ARRIVAL_TIMEOUT_S
    assert run(rig, MoveCommand(rig.flight, "A", None)) is Status.SUCCESS


def test_a_vehicle_that_does_not_turn_has_not_arrived() -> None:
    rig = heading_at("A", EAST)
    rig.vehicle.is_turning = False
    leaf = MoveCommand(rig.flight, "A", None)
    assert run(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "at A, but 90 degrees off the heading"


def test_a_flight_that_is_interrupted_amid_its_turn_keeps_the_heading() -> None:
    rig = heading_at("A", SOUTH)
    leaf = MoveCommand(rig.flight, "A", None)
    while error_rad(rig.vehicle.state.attitude.yaw_rad, 0.0) < 1.0:  # type: ignore[union-attr]
        tick(rig, leaf)
    leaf.stop(Status.INVALID)
    stopped_rad = told(rig)[-1]
    for _ in range(40):
        rig.pass_time()
        rig.flight.guidance.brake()
        rig.flight.guidance.hold()
    assert told(rig)[-1] == stopped_rad != approx(SOUTH)


def test_a_pose_on_the_way_home_is_that_of_the_place_too() -> None:
    """Whoever flies there: the operator's return and a flight without a plan have the same leaf."""
    rig = heading_at("H", WEST)
    rig.vehicle.change(position=(3.0, 3.0, -2.0))
    assert run(rig, MoveCommand(rig.flight, "H", None)) is Status.SUCCESS
    assert error_rad(told(rig)[-1], WEST) <= HEADING_TOLERANCE_RAD


# -- what a skill looks at ---------------------------------------------------------------------


def looking(execute: object, look_at: object = TOWER, **more: object) -> Skill:
    photo = replace(command("photo", "at(H)", "taken"), look_at=look_at)  # type: ignore[arg-type]
    steps = execute if isinstance(execute, tuple) else (execute,)
    return replace(photo, execute=steps, **more)  # type: ignore[arg-type]


def asked(photo: Skill, *others: Skill) -> Mission:
    return mission("F taken", skills=[move(), photo, *others])


def tree_of(rig: Rig, name: str = "photo") -> Behaviour:
    action = next(a for a in rig.planner.actions.model.actions if a.name == name)
    return action_tree(rig.flight, Intention(action.name, (action,)), None)


def test_a_command_is_sent_when_the_vehicle_looks_there() -> None:
    rig = Rig(asked(looking(command("photo").execute)))
    tree = tree_of(rig)
    while not rig.vehicle.payloads.sent:
        tick(rig, tree)
    assert rig.vehicle.state is not None
    assert error_rad(rig.vehicle.state.attitude.yaw_rad, WEST) <= HEADING_TOLERANCE_RAD
    assert rig.flight.now_s == approx(math.pi / 2 / RATE, abs=3 * TICK_S)


def test_a_vehicle_that_cannot_turn_fails_and_says_why() -> None:
    rig = Rig(asked(looking(Wait(1.0)))).begin()
    rig.vehicle.is_turning = False
    rig.run_until(SkillFailed)
    (failed,) = rig.of(SkillFailed)
    assert failed.reason == "90 degrees off the direction of tower"
    assert rig.flight.now_s == approx(TURN_TIMEOUT_S + math.pi / RATE, abs=1.0)


@pytest.mark.parametrize("why", ["too near", "on the ground", "no state"])
def test_where_nothing_can_turn_the_step_begins_at_once(why: str) -> None:
    rig = a_rig()
    point = PointOfInterest("H", (0.2, 0.2)) if why == "too near" else TOWER
    if why == "on the ground":
        rig.flight.progress.take_to_ground()
    if why == "no state":
        rig.vehicle.state = None
    rest = Rest(rig.flight, "rest", 1.0)
    assert tick(rig, LookAt(rig.flight, point, rest)) is Status.SUCCESS


def test_a_skill_of_steps_lands_as_it_stands_and_looks_there_after_the_take_off() -> None:
    steps = (Land(), TakeOff(), Wait(1.0))
    rig = Rig(asked(looking(steps)))
    tree = tree_of(rig)
    names = [node.name for node in tree.iterate() if not node.children]
    assert [name for name in names if name in ("land", "take off", "look at tower", "rest")] == [
        *("land", "take off", "look at tower", "rest")
    ]
    run(rig, tree)
    assert rig.vehicle.state is not None
    assert error_rad(rig.vehicle.state.attitude.yaw_rad, WEST) <= HEADING_TOLERANCE_RAD


def test_a_skill_that_refines_another_one_looks_where_it_says_or_where_that_one_does() -> None:
    own = replace(skill("own", Wait(0.5)), look_at=PointOfInterest("hill", (-50.0, 0.0)))
    none = skill("none", Wait(0.5))
    refining = [replace(each, is_planned=False) for each in (own, none)]
    photo = looking((Do("own", ()), Do("none", ())))
    rig = Rig(asked(photo, *refining))
    tree = tree_of(rig)
    looks = [leaf.name for leaf in tree.iterate() if isinstance(leaf, LookAt)]
    assert looks == ["look at hill", "look at tower"]


def test_a_parameter_is_looked_at_as_the_place_that_it_is() -> None:
    photo = replace(looking(Wait(0.5), "q"), parameters=(("q", "Place"),), distinct=(("q", "H"),))
    rig = Rig(asked(photo))
    assert run(rig, tree_of(rig, "photo(B)")) is Status.SUCCESS
    assert error_rad(told(rig)[-1], EAST / 2) <= HEADING_TOLERANCE_RAD


def test_a_flight_goes_on_looking_and_arrives_so_whatever_the_place_says() -> None:
    rig = heading_at("A", EAST)
    leaf = MoveCommand(rig.flight, "A", None, TOWER.position)
    assert run(rig, leaf) is Status.SUCCESS
    north, east, _ = POSITIONS["A"]
    there = math.atan2(TOWER.position[1] - east, TOWER.position[0] - north)
    assert error_rad(told(rig)[-1], there) <= HEADING_TOLERANCE_RAD


def test_a_flight_to_what_it_looks_at_keeps_the_heading_near_it() -> None:
    rig = a_rig()
    leaf = MoveCommand(rig.flight, "A", None, POSITIONS["A"][:2])
    assert run(rig, leaf) is Status.SUCCESS
    assert set(told(rig)) == {0.0}


def test_after_a_pause_by_hand_the_vehicle_looks_there_again() -> None:
    """A pilot may have turned it; the wait begins anew, when it is turned back."""
    rig = Rig(asked(looking(Wait(1.0))))
    tree = tree_of(rig)
    later(rig)
    rest = next(node for node in tree.iterate() if isinstance(node, Rest))
    while rest.status is not Status.RUNNING:
        tick(rig, tree)
    pausing.pause(tree)
    rig.flight.guidance.forget_setpoint()
    rig.vehicle.change(yaw_rad=EAST)
    rig.vehicle.is_turning = False
    pausing.resume(tree, 5.0)
    tick(rig, tree)
    assert rest.status is not Status.RUNNING
    rig.vehicle.is_turning = True
    assert run(rig, tree) is Status.SUCCESS
    assert error_rad(told(rig)[-1], WEST) <= HEADING_TOLERANCE_RAD
