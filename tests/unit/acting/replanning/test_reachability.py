"""What the map takes away is not believed, before a flight fails for it; and it comes back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig import Rig
from synthetic import command, event, mission, reading, skill

from companion import slices
from companion.acting.executive_states import TaskStatus
from companion.acting.replanning.reachability import BeliefChange
from companion.acting.safe_places import flight_to
from companion.flight_events.facts import BeliefWithdrawn, PlacesConnected, PlacesCutOff
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import SkillFailed, SymbolMoved
from companion.mission.steps import Fly
from companion.motion.grid import OccupancyGrid
from companion.outcomes import Failed
from companion.tick import TICK_S

INSPECT = skill(
    "inspect",
    Fly("s"),
    "from s",
    "at(from)",
    ["accessible(s)"],
    "at(s) & !at(from) & seen(s)",
    cost_s=None,
    tries=3,
)
TO_AND_FROM_B = ("trans_ok(A, B)", "trans_ok(B, A)", "trans_ok(B, H)", "trans_ok(H, B)")
ALL_OF_B = "accessible(B), trans_ok(*, B), trans_ok(B, *)"
"""The same in few words."""


def inspection() -> Rig:
    """Look at A and then at B, as far as they are believed to be accessible."""
    task = {
        "A": "F (seen(A) | !accessible(A))",
        "B": "F (seen(B) | !accessible(B))",
        "order": "!seen(B) W (seen(A) | !accessible(A))",
        "home": "F G at(H)",
    }
    rig = Rig(mission(task, skills=[INSPECT])).begin()
    rig.tick()
    return rig


def show(rig: Rig, *walled_in: str) -> None:
    """The vehicle sees these corners of the room as solid, and nothing else."""
    occupied = np.zeros((20, 20), dtype=np.bool_)
    corners = {"A": np.s_[12:, :8], "B": np.s_[12:, 12:], "C": np.s_[:8, 12:]}
    for place in walled_in:
        occupied[corners[place]] = True
    rig.flight.routes.see(OccupancyGrid(occupied, 0.5, (-2.0, -2.0)))


def until_known(rig: Rig) -> None:
    """Up to the tick that begins with all ways known; each before it finds a few."""
    while not rig.flight.routes.find(0):
        rig.tick()
    rig.tick()


def test_a_task_that_speaks_of_a_belief_hears_at_once_that_the_map_contradicts_it() -> None:
    rig = inspection()
    assert rig.plans[-1].names(2) == ["inspect(H, A)", "inspect(A, B)"]
    show(rig, "B")
    until_known(rig)
    cut_off = rig.one(PlacesCutOff)
    assert cut_off == PlacesCutOff(ALL_OF_B, withdrawn=("accessible(B)", *TO_AND_FROM_B))
    replaced = rig.one(PlanReplaced)
    assert (replaced.number, replaced.reason) == (1, cut_off.text)
    assert str(replaced.plan) == "inspect(here, A), move(A, H), (wait)^w"
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert not rig.of(SkillFailed) and not rig.of(BeliefWithdrawn)
    assert rig.executive.reports.replans == 1
    assert "accessible(B)" in rig.positions[-1].withdrawn


def test_the_answer_is_the_same_where_it_takes_many_ticks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slices, "SLICE_US", 500)
    rig = inspection()
    show(rig, "B")
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.one(PlanReplaced).reason == rig.one(PlacesCutOff).text
    assert rig.time_of(PlanReplaced) > rig.time_of(PlacesCutOff) + TICK_S
    assert not rig.of(SkillFailed) and not rig.of(BeliefWithdrawn)
    assert rig.places == ["A", "H"]


def test_a_way_that_is_seen_again_is_used_from_the_next_completed_skill_on() -> None:
    rig = inspection()
    show(rig, "B")
    until_known(rig)
    show(rig)
    until_known(rig)
    connected = PlacesConnected(ALL_OF_B, restored=("accessible(B)", *TO_AND_FROM_B))
    assert rig.of(PlacesConnected) == [connected]
    assert rig.task.withdrawn == frozenset()
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["A", "B", "H"]


def test_a_place_of_no_concern_that_is_cut_off_leaves_the_plan_as_it_is() -> None:
    rig = Rig(mission("F at(A) & F at(B)", places="HABC")).begin()
    rig.tick()
    show(rig, "C")
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.one(PlacesCutOff).summary == "trans_ok(*, C), trans_ok(C, *)"
    assert rig.executive.reports.replans == 0


def test_the_flight_under_way_finds_out_itself_and_the_rest_is_told_once() -> None:
    """Fig. 6 withdraws what has failed; and that too is believed again with the way."""
    rig = Rig(mission("F at(B)")).begin()
    rig.tick()
    show(rig, "B")
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.of(BeliefWithdrawn) == [BeliefWithdrawn("trans_ok(H, B)")]
    assert rig.one(PlacesCutOff).summary == "trans_ok(*, B), trans_ok(B, *)"
    assert rig.executive.reports.replans == 1
    assert rig.leave_for("H")
    show(rig)
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.places == ["B"]
    assert rig.task.withdrawn == frozenset()


def test_on_the_way_home_a_way_that_helps_nothing_is_no_reason_to_stop() -> None:
    rig = Rig(mission("F at(B)", places="HABC")).begin()
    rig.tick()
    show(rig, "B", "C")
    assert rig.run_to_the_end() is TaskStatus.NO_PLAN
    assert rig.leave_for("H")
    show(rig, "B")
    until_known(rig)
    assert rig.of(PlacesConnected)[-1].restored[0] == "trans_ok(A, C)"
    assert rig.run_to_the_end() is TaskStatus.SATISFIED  # it is home
    assert rig.executive.is_leaving and rig.executive.reports.replans == 1


def test_what_the_map_changes_in_beliefs_is_handed_on_as_it_is_reported() -> None:
    rig = inspection()
    reachability = rig.executive.deliberation.replanner.reachability
    assert reachability.follow() == BeliefChange(cut_off=None, connected=None)
    show(rig, "B")
    cut_off = PlacesCutOff(ALL_OF_B, withdrawn=("accessible(B)", *TO_AND_FROM_B))
    assert reachability.follow() == BeliefChange(cut_off, connected=None)
    show(rig)
    connected = PlacesConnected(ALL_OF_B, restored=("accessible(B)", *TO_AND_FROM_B))
    assert reachability.follow() == BeliefChange(None, connected)


def test_what_was_refused_is_not_believed_again_because_of_a_way() -> None:
    rig = Rig(mission("F did", skills=[command("do", "at(A)", "did")])).begin()
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    rig.run_until(BeliefWithdrawn, belief="can_do")
    before = rig.task.withdrawn
    for walled_in in (("B",), ()):
        show(rig, *walled_in)
        rig.executive.deliberation.replanner.reachability.follow()
    assert rig.task.withdrawn == before == {"can_do"}


def test_a_new_plan_reckons_with_the_speed_limit_as_it_is_now() -> None:
    rig = inspection()
    before = {action.name: action.cost_ms for action in rig.planner.actions.model.actions}
    rig.speed_limit.set_operator_limit(0.5)
    assert rig.executive.resume() is TaskStatus.RUNNING
    after = {action.name: action.cost_ms for action in rig.planner.actions.model.actions}
    assert after.keys() == before.keys()
    assert all(after[name] > 2 * before[name] for name in before if "move" in name)


# -- what moves cost when an event comes -----------------------------------------------------------


def test_an_event_is_judged_by_what_moves_cost_on_the_map_as_it_is_then() -> None:
    """A wall made the way to A long when the plan was made; it has gone since, and A will do."""
    task = {"home": "G F at(H)", "there": "G F (at(B) | at(A) & open)"}
    rig = Rig(mission(task, events=[event("open")]))
    occupied = np.zeros((20, 20), dtype=np.bool_)
    occupied[9:11, :13] = True
    rig.flight.routes.see(OccupancyGrid(occupied, 0.5, (-2.0, -2.0)))
    rig.begin()
    for _ in range(20):
        rig.tick()
    show(rig)
    rig.tick(reading("open"))
    rig.run_until(PlanReplaced)
    assert "move(H, A)" in str(rig.plans[-1]) and "move(A, H)" in str(rig.plans[-1])


def test_a_flight_home_asks_for_the_way_home_alone() -> None:
    """With many places on a map that has changed, all their ways would take longer than a tick."""
    rig = Rig(mission("F at(B)", places="HABC")).begin()
    asked: list[str] = []
    flight_time = rig.planner.actions.flight_time

    def noted(origin: str, goal: str) -> float:
        asked.append(goal)
        return flight_time(origin, goal)

    rig.planner.actions.flight_time = noted
    assert flight_to(rig.planner, "H") is not None
    assert asked == ["H"]


def test_a_waypoint_is_moved_in_parts_before_ways_are_searched(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig = inspection()
    monkeypatch.setattr("companion.acting.symbols.CELLS_PER_TICK", 1)
    monkeypatch.setattr(slices, "SLICE_US", 0.1)
    occupied = np.zeros((100, 100), dtype=np.bool_)
    rig = Rig(replace(rig.mission, grid=OccupancyGrid(occupied, 0.1, (-2.0, -2.0)))).begin()
    covered = occupied.copy()
    covered[86, 80] = True  # half a metre north of B
    rig.flight.routes.see(OccupancyGrid(covered, 0.1, (-2.0, -2.0)))
    reachability, parts = rig.executive.deliberation.replanner.reachability, 0
    while not reachability.is_known:
        assert parts < 1000 and not rig.of(SymbolMoved)
        reachability.search()
        parts += 1
        rig._collect()
    assert parts > 3
    assert rig.one(SymbolMoved).place == "B"
