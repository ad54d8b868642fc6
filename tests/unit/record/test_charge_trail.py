"""The charge over a flight, as flight.png has it: from the events of a run alone."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest
from PIL import Image
from synthetic import mission

from companion.flight_events.charge import ChargeMeasured, ChargePlanned, PlannedCharge
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.plans import PlannedAction, PlannedLasso, PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import StoppedAsAsked
from companion.flight_events.tree import (
    LeafTreeNode,
    LeafType,
    NodeChange,
    NodesChanged,
    NodeStatus,
    NodeType,
    TreeBuilt,
    TreeStopped,
)
from companion.record.backdrop import backdrop_of
from companion.record.charge_trail import MARKS_MAX, POINTS_MAX, ChargeAt, ChargeTrail
from companion.record.figure import draw_flight, figure_of
from companion.record.trail import Trail

AHEAD = (
    PlannedCharge("move(A, D)", 10.0, 70.0, 60.0),
    PlannedCharge("wait", 1.0, 69.0, 59.0),  # of which nothing is told when it is done
    PlannedCharge("recharge(D)", 60.0, 90.0, 90.0),
)
PLAN = ChargePlanned(80.0, 65.0, 20.0, AHEAD)
TREE = TreeBuilt(
    tuple(
        LeafTreeNode(1, NodeType.LEAF, does.value, does)
        for does in (LeafType.LAND, LeafType.CHARGE, LeafType.TAKE_OFF)
    )
)
LASSO = PlannedLasso((), (PlannedAction("wait", "wait", (), 1.0),), 0.0, 1.0)


def charging(status: NodeStatus, node: int = 1) -> NodesChanged:
    return NodesChanged("charge", status, (NodeChange(node, status, ""),))


def trail_of(*happened: tuple[float, FlightEvent]) -> ChargeTrail:
    trail = ChargeTrail()
    for time_s, event in happened:
        trail.take(Stamped(time_s, event))
    return trail


def test_a_plan_stands_where_its_positions_were_reached() -> None:
    trail = trail_of(
        (1.0, PLAN),
        (12.0, PlaceReached("D", "move(A, D)")),
        (13.0, PlaceReached("E", "move(A, E)")),  # of another plan
        (80.0, SkillCompleted("recharge(D)")),
        (81.0, ChargePlanned(89.5, 60.0, 20.0, AHEAD)),
    )
    first, second = trail.plans
    assert first == [
        ChargeAt(1, 1.0, 80.0, 65.0),
        ChargeAt(1, 12.0, 70.0, 60.0),
        ChargeAt(1, 80.0, 90.0, 90.0),
    ]
    assert second == [ChargeAt(2, 81.0, 89.5, 60.0)]
    assert trail.reserve_percent == 20.0


@pytest.mark.parametrize(
    "end",
    [
        charging(NodeStatus.SUCCESS),
        charging(NodeStatus.FAILURE),
        TreeStopped((NodeChange(1, NodeStatus.INVALID, ""),)),
        TREE,
        StoppedAsAsked(),
    ],
    ids=lambda event: type(event).__name__,
)
def test_it_charges_while_a_leaf_that_charges_runs(end: FlightEvent) -> None:
    trail = trail_of(
        (0.0, TREE),
        (5.0, charging(NodeStatus.RUNNING, node=0)),
        (9.0, charging(NodeStatus.RUNNING)),
        (11.0, charging(NodeStatus.RUNNING)),  # it says something else of itself
        (20.0, end),
        (30.0, charging(NodeStatus.FAILURE)),
    )
    assert [*trail.charging] == [(9.0, 20.0)]


def test_a_flight_of_days_stays_small(tmp_path: Path) -> None:
    trail = trail_of((0.0, TREE))
    for i in range(3 * POINTS_MAX):
        time_s = 10.0 * i
        for later_s, event in (
            (0.0, ChargeMeasured(i % 100)),
            (1.0, PLAN),
            (2.0, charging(NodeStatus.RUNNING)),
            (5.0, charging(NodeStatus.SUCCESS)),
            (6.0, PlanReplaced(i, "denied", LASSO)),
        ):
            trail.take(Stamped(time_s + later_s, event))
    assert POINTS_MAX / 2 <= len(trail.measured) <= POINTS_MAX
    assert len(trail.planned) <= POINTS_MAX
    assert len(trail.charging) == len(trail.replans) == MARKS_MAX
    assert trail.measured[0] == (0.0, 0)


def drawn(happened: Iterable[tuple[float, FlightEvent]]) -> Trail:
    trail = Trail(charge=trail_of(*happened))
    trail.begin("first plan")
    trail.add((0.0, 0.0, -2.0))
    return trail


MEASURED = [(0.0, ChargeMeasured(82)), (9.0, ChargeMeasured(None)), (15.0, ChargeMeasured(71))]


def test_the_strip_shows_what_is_known(tmp_path: Path) -> None:
    """Measured, planned, required, the reserve, charges and replans, each in the legend."""
    charged = [
        (20.0, TREE),
        (21.0, charging(NodeStatus.RUNNING)),
        (40.0, charging(NodeStatus.SUCCESS)),
    ]
    replan = (41.0, PlanReplaced(1, "denied", LASSO))
    trail = drawn(
        [*MEASURED, (1.0, PLAN), (12.0, PlaceReached("D", "move(A, D)")), *charged, replan]
    )
    strip = figure_of(backdrop_of(mission("F at(A)")), trail).axes[0]
    legend = strip.get_legend()
    assert legend is not None
    told = {text.get_text() for text in legend.get_texts()}
    assert told == {"measured", "planned at least", "required", "reserve", "charging"}
    assert [text.get_text() for text in strip.texts] == ["replan 1"]
    draw_flight(backdrop_of(mission("F at(A)")), trail, tmp_path / "flight.png")
    with Image.open(tmp_path / "flight.png") as image:
        assert image.height > 550
    assert strip.get_window_extent().width > 0.7 * strip.figure.bbox.width


@pytest.mark.parametrize(
    "happened",
    [
        pytest.param([], marks=pytest.mark.long),
        MEASURED,
        pytest.param([(1.0, PLAN)], marks=pytest.mark.long),
    ],
)
def test_without_anything_to_say_there_is_no_strip(
    happened: list[tuple[float, FlightEvent]],
) -> None:
    assert len(figure_of(backdrop_of(mission("F at(A)")), drawn(happened)).axes) == 1
