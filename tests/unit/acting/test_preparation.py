"""What takes long before a run: all of it is made beforehand, and the run takes it over."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes import FakeVehicle
from synthetic import command, event, mission, reading

from companion.acting.assembly import ActingParts, assemble
from companion.acting.event_detector import EventDetector
from companion.acting.preparation import PreparedMission, prepare
from companion.errors import CompanionError, NoPlanError
from companion.flight_events.plans import PlanMade
from companion.mission.tree_nodes import Act
from companion.motion.routes import RouteMap
from companion.planning.builtin import restrictions
from companion.planning.lasso import ChosenPlan, Lasso
from companion.planning.planner import Planner
from companion.planning.solver import Solver

ROUND = "G F at(A) & G F at(B)"


def begun(prepared: PreparedMission) -> ActingParts:
    """The parts of a run whose task begins, above home."""
    return assemble(prepared, FakeVehicle().take_off(2.0), EventDetector(prepared.mission.events))


def first_lasso(prepared: PreparedMission) -> Lasso:
    assert prepared.first_plan is not None and isinstance(prepared.first_plan.outcome, ChosenPlan)
    return prepared.first_plan.outcome.lasso


def forbid(monkeypatch: pytest.MonkeyPatch, owner: object, *names: str) -> None:
    def too_late(*_: object) -> None:
        raise AssertionError("this takes long, and the run has begun")

    for name in names:
        monkeypatch.setattr(owner, name, too_late)


def test_nothing_that_takes_long_is_left_to_the_first_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    prepared = prepare(mission(ROUND))
    forbid(monkeypatch, Solver, "solve", "replan")
    forbid(monkeypatch, Planner, "reinstantiate")
    forbid(monkeypatch, RouteMap, "distance_m", "find")
    acting = begun(prepared)
    acting.executive.plan()
    (made,) = [s.event for s in acting.flight.reports if isinstance(s.event, PlanMade)]
    assert acting.executive.lasso is first_lasso(prepared)
    assert made.plan == first_lasso(prepared).planned


def test_what_an_event_leaves_of_the_automata_is_known_before_it_comes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = mission("G (F at(A) | found) & G (F at(B) | found)", events=[event("found")])
    acting = begun(prepare(asked))
    forbid(monkeypatch, restrictions, "restricted")
    acting.executive.plan()
    acting.executive.tick()
    acting.perception.take([reading("found")])
    acting.executive.tick()
    assert str(acting.executive.lasso) == "move(here, A), move(A, B), (wait)^w"


def test_a_plan_that_does_not_exist_is_kept_to_be_told(monkeypatch: pytest.MonkeyPatch) -> None:
    prepared = prepare(mission("F at(A) & G !at(A)"))
    forbid(monkeypatch, Solver, "solve")
    assert isinstance(begun(prepared).executive.plan(), NoPlanError)


def test_an_event_before_the_start_makes_another_plan() -> None:
    asked = mission("G (F at(A) | found) & G (F at(B) | found)", events=[event("found")])
    prepared = prepare(asked)
    acting = begun(prepared)
    acting.perception.take([reading("found")])
    acting.executive.plan()
    assert str(first_lasso(prepared)) != str(acting.executive.lasso) == "(wait)^w"


def test_a_speed_limit_of_an_operator_counts_in_the_first_plan() -> None:
    fast, slow = (first_lasso(prepare(mission("F at(A)"), mps)) for mps in (50.0, 0.5))
    assert slow.prefix_cost_ms > 2 * fast.prefix_cost_ms


def test_a_speed_limit_that_changes_after_the_preparation_counts_as_well() -> None:
    prepared = prepare(mission("F at(A)"))
    acting = begun(prepared)
    acting.flight.speed_limit.set_operator_limit(0.5)
    acting.executive.plan()
    slow = first_lasso(prepare(mission("F at(A)"), 0.5))
    assert acting.executive.lasso is not None
    assert acting.executive.lasso.prefix_cost_ms == slow.prefix_cost_ms


def test_a_tree_that_does_what_does_not_exist_is_an_error_before_the_run() -> None:
    asked = mission("F done", skills=[command("do", "at(H)", "done")])
    assert prepare(replace(asked, tree=Act("do"))).first_plan is None
    with pytest.raises(CompanionError, match="move"):
        prepare(replace(asked, tree=Act("move(H, Nowhere)")))
