"""Suggesters and tests of a place's own: asked in slices where a flight to it begins."""

from __future__ import annotations

from dataclasses import replace

import pytest
from leaves import later, run, tick
from py_trees.common import Status
from rig import Rig
from scripted_functions import ScriptedFunctions
from synthetic import POSITIONS, mission

from companion.acting.behaviour_tree.leaves import UpdateParam
from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.place_functions import ASKED_S, IN_ALL_S
from companion.acting.symbols import ASKED_AT_ONCE
from companion.flight_events.skills import PlaceFunctionFailed, SymbolMoved
from companion.mission.python_call import PythonCall
from companion.motion.region import Disc
from companion.outcomes import Failed
from companion.skills.authoring import FunctionKind, WaypointEnu
from companion.skills.calls import Answer, CommandAsked, Function, Returned

NEAR = PythonCall(Function(FunctionKind.SUGGESTER, "near"))
DRY = PythonCall(Function(FunctionKind.PLACE_TEST, "dry"), keywords=(("by_m", 0.5),))
A_NORTH_M, A_EAST_M, _ = POSITIONS["A"]


def verdicts(*passes: bool) -> list[tuple[float, Answer]]:
    return [(0.0, Returned(verdicts=passes))]


def proposed(*waypoints: WaypointEnu) -> list[tuple[float, Answer]]:
    return [(0.0, Returned(waypoints=waypoints))]


def leaf_of(*script: list[tuple[float, Answer]]) -> tuple[Rig, ScriptedFunctions, UpdateParam]:
    """A leaf that grounds A, a wide region with a suggester and a test."""
    made = mission("F at(A)")
    wide = replace(made.places["A"], region=Disc(2.0), suggesters=(NEAR,), tests=(DRY,))
    rig = Rig(replace(made, places={**made.places, "A": wide}))
    functions = ScriptedFunctions(*script)
    rig.flight.functions = functions
    later(rig)
    return rig, functions, UpdateParam(rig.flight, "A", MoveCommand(rig.flight, "A", None))


def test_the_waypoint_that_passes_is_kept_and_nothing_is_proposed() -> None:
    rig, functions, leaf = leaf_of(verdicts(True))
    assert run(rig, leaf) is Status.SUCCESS
    (request,) = functions.requests
    assert request.call.text == "python(dry, by_m=0.5)"
    assert (request.place, request.waypoints) == ("A", (WaypointEnu(A_EAST_M, A_NORTH_M, 2.0),))
    assert rig.flight.collect_reports() == []


def test_what_a_suggester_proposes_is_flown_to_if_it_passes() -> None:
    east = WaypointEnu(A_EAST_M + 1, A_NORTH_M)
    second = verdicts(True, *[False] * (ASKED_AT_ONCE - 1))
    rig, functions, leaf = leaf_of(verdicts(False), proposed(east), second)
    assert run(rig, leaf) is Status.SUCCESS
    assert [request.call.function.name for request in functions.requests] == ["dry", "near", "dry"]
    assert len(functions.requests[2].waypoints) == ASKED_AT_ONCE
    moved = rig.flight.collect_reports()[-1].event
    assert isinstance(moved, SymbolMoved)
    assert (moved.source, moved.east_m) == ("near", A_EAST_M + 1)


def test_without_a_waypoint_that_passes_the_flight_does_not_begin() -> None:
    rig, _, leaf = leaf_of(verdicts(False), proposed(), [(0.0, Failed("no sensor"))])
    assert run(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "no waypoint of A can be flown to"
    told = {str(stamped.event.text) for stamped in rig.flight.collect_reports()}
    assert told == {"dry failed for A: no sensor"}


@pytest.mark.parametrize("up_m", [None, 2.0, 40.0])
def test_waypoints_outside_the_region_or_the_altitudes_are_told_and_not_taken(
    up_m: float | None,
) -> None:
    away_m = 0.5 if up_m == 40.0 else 2.5
    far = WaypointEnu(A_EAST_M + away_m, A_NORTH_M, up_m)
    rig, _, leaf = leaf_of(verdicts(False), proposed(far), verdicts(*[False] * ASKED_AT_ONCE))
    run(rig, leaf)
    told = [s.event for s in rig.flight.collect_reports()]
    outside = "1 waypoints outside the region or the altitudes"
    assert told[0] == PlaceFunctionFailed("A", "near", outside)


def test_a_test_that_does_not_answer_passes_nothing_and_the_vehicle_holds_meanwhile() -> None:
    rig, functions, leaf = leaf_of([])
    begun_s = rig.flight.now_s
    for _ in range(20):
        assert tick(rig, leaf) is Status.RUNNING
    assert rig.vehicle.setpoint is not None and rig.vehicle.setpoint.velocity == (0.0, 0.0, 0.0)
    assert run(rig, leaf) is Status.FAILURE
    assert ASKED_S < rig.flight.now_s - begun_s < IN_ALL_S + 1
    assert functions.cancelled == [*range(1, len(functions.requests) + 1)]


def test_a_grounding_that_is_left_cancels_the_call() -> None:
    rig, functions, leaf = leaf_of([])
    tick(rig, leaf)
    leaf.stop(Status.INVALID)
    assert functions.cancelled == [1]


def test_who_is_asked_about_a_place_commands_no_payload() -> None:
    asked = CommandAsked(25, "MAV_CMD_DO_GRIPPER", ())
    rig, functions, leaf = leaf_of([(0.0, asked), *verdicts(True)])
    assert run(rig, leaf) is Status.SUCCESS
    assert functions.replies == ["a skill alone may command payloads"]
    assert rig.vehicle.payloads.sent == []
