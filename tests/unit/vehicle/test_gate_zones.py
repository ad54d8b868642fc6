"""Keep-out zones at the gate: no setpoint in one or behind one, but for the way out.

Numbers are exact in binary, as in test_gate.py, whose envelope and vehicle these are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from at_the_gate import AFTER, ENVELOPE, GOOD, heard, verdict
from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from polygons import Point, stars

from companion.geometry import is_in_polygon
from companion.motion.grid import distances_to_edge
from companion.motion.line_of_sight import LineOfSight
from companion.outcomes import Refusal
from companion.vehicle.gate import Verdict
from companion.vehicle.gate_polygons import Corner
from companion.vehicle.ports.setpoints import hold_at

SQUARE = ((4.0, 16.0), (4.0, 18.0), (6.0, 18.0), (6.0, 16.0))
"""East of the vehicle, which is at (5, 15)."""
MARGIN_M = ENVELOPE.fence_margin_m
IN, BEHIND = "in a keep-out zone", "behind a keep-out zone"


def refusal(
    here: Corner, there: Corner, *zones: tuple[Corner, ...], carrot_m: float = 1.5
) -> str | None:
    """Why a vehicle may not be sent from one point to another, if it may not."""
    envelope = replace(ENVELOPE, keep_out=zones, carrot_m=carrot_m)
    state = heard(position=(*here, -2.25))
    setpoint = replace(GOOD, position=(*there, -2.25))
    found = verdict(setpoint, state, envelope)
    if found.refusal is None:
        assert found == Verdict(setpoint)
        return None
    assert found == Verdict(
        hold_at(state.motion.position, state.attitude.yaw_rad), Refusal(found.refusal.reason)
    )
    return found.refusal.reason


def test_no_setpoint_comes_nearer_than_the_margin() -> None:
    at_margin = 16.0 - MARGIN_M
    assert refusal((5.0, 15.0), (5.0, at_margin), SQUARE) is None
    assert refusal((5.0, 15.0), (5.0, at_margin + AFTER), SQUARE) == IN
    assert refusal((5.0, 15.0), (5.0, 16.25), SQUARE) == IN
    assert refusal((5.0, 15.0), (5.0, 16.25)) is None
    assert refusal((5.0, 19.0), (5.0, 18.0 + MARGIN_M), SQUARE) is None
    assert refusal((5.0, 19.0), (5.0, 18.0 + MARGIN_M - AFTER), SQUARE) == IN
    assert refusal((7.0, 17.0), (6.0 + MARGIN_M, 17.0), SQUARE) is None
    assert refusal((7.0, 17.0), (6.0 + MARGIN_M - AFTER, 17.0), SQUARE) == IN


def test_each_zone_counts() -> None:
    far = tuple((north - 3.5, east) for north, east in SQUARE)
    for zones in ((SQUARE, far), (far, SQUARE)):
        assert refusal((5.0, 15.0), (5.0, 16.0), *zones) == IN
        assert refusal((1.5, 15.0), (1.5, 16.0), *zones) == IN


def test_a_vehicle_in_a_zone_may_be_sent_out_and_no_deeper() -> None:
    """Deeper is further from the nearest edge."""
    assert refusal((5.0, 16.5), (5.0, 16.5), SQUARE) is None
    assert refusal((5.0, 16.5), (5.0, 16.25), SQUARE) is None
    assert refusal((5.0, 16.5), (5.0, 15.5), SQUARE) is None
    assert refusal((5.0, 16.5), (5.0, 16.5 + AFTER), SQUARE) == IN
    assert refusal((5.5, 17.0), (5.5 - AFTER, 17.0), SQUARE) == IN
    assert refusal((5.5, 17.0), (5.5 + AFTER, 17.0), SQUARE) is None


def test_a_vehicle_within_the_margin_may_stay_and_come_no_nearer() -> None:
    assert refusal((5.0, 15.875), (5.0, 15.875), SQUARE) is None
    assert refusal((5.0, 15.875), (5.0, 15.5), SQUARE) is None
    assert refusal((5.0, 15.875), (5.0, 15.875 + AFTER), SQUARE) == IN


def test_the_way_out_of_a_zone_does_not_lead_into_another() -> None:
    beside = tuple((north, east - 2.0) for north, east in SQUARE)  # they share an edge
    assert refusal((5.0, 16.25), (5.0, 15.75), SQUARE, beside) == IN
    assert refusal((5.75, 17.0), (6.25, 17.0), SQUARE, beside) is None


def test_no_setpoint_lies_behind_a_zone() -> None:
    """The vehicle would fly through it."""
    thin = ((4.0, 15.5), (4.0, 15.625), (6.0, 15.625), (6.0, 15.5))
    assert refusal((5.0, 15.0), (5.0, 16.25), thin) == BEHIND
    assert refusal((5.0, 16.25), (5.0, 15.0), thin) == BEHIND
    assert refusal((5.0, 15.0), (5.0, 15.0), thin) is None
    assert refusal((5.0, 15.5), (5.0, 16.25), thin) == BEHIND  # from its very edge
    assert refusal((5.0, 15.5), (5.0, 15.0), thin) is None
    assert refusal((5.0, 15.25 - AFTER), (5.875, 15.25), thin) is None
    assert refusal((6.5, 15.0), (6.5, 16.25), thin) is None  # past its end
    assert refusal((5.0, 15.5625), (5.0, 16.25), thin) is None  # out of it


def test_to_touch_a_zone_or_to_be_in_line_with_its_edge_is_not_to_cross_it() -> None:
    wedge = ((5.0, 15.5), (3.0, 15.25), (3.0, 15.75))
    for here, there in (((5.0, 15.0), (5.0, 16.0)), ((5.0, 16.0), (5.0, 15.0))):
        assert refusal(here, there, wedge) is None
    thin = ((4.0, 15.5), (4.0, 15.625), (6.0, 15.625), (6.0, 15.5))
    assert refusal((6.5, 15.0), (6.5, 15.5), thin) is None
    assert refusal((6.5, 15.5), (6.5, 15.0), thin) is None


def test_a_corner_of_a_zone_may_be_cut_by_nobody() -> None:
    wedge = ((5.0, 15.5), (3.0, 15.25), (3.0, 15.75))
    assert refusal((4.875, 15.0), (4.875, 16.0), wedge) == BEHIND
    assert refusal((5.5, 15.0), (5.5, 16.0), wedge) is None


@drawn(40)
@given(zone=stars((5.0, 0.0), 0.5, 4.0), point=st.tuples(st.floats(0.3, 9.7), st.floats(-8, 8)))
def test_in_a_zone_is_what_others_call_inside_or_too_near(zone: list[Point], point: Point) -> None:
    north, east = (np.array([metres]) for metres in point)
    edges = zip(zone, [*zone[1:], zone[0]], strict=True)
    gap_m = min(float(distances_to_edge(north, east, edge)[0]) for edge in edges)
    assume(abs(gap_m - MARGIN_M) > 1e-9)
    is_in = is_in_polygon(point, zone) or gap_m < MARGIN_M
    found = refusal((5.0, 15.0), point, tuple(zone), carrot_m=99.0)
    assert (found == IN) is is_in


@drawn(40)
@given(
    here=st.tuples(st.integers(2, 38), st.integers(-30, 30)),
    there=st.tuples(st.integers(2, 38), st.integers(-30, 30)),
)
def test_behind_a_zone_is_what_is_out_of_sight(here: Corner, there: Corner) -> None:
    """On a map of cells as wide as the zone; the points are in the middle of smaller ones."""
    (n1, e1), (n2, e2) = ((north / 4 + 0.0625, east / 4 + 0.1) for north, east in (here, there))
    zone = ((4.0, 0.0), (4.0, 2.0), (6.0, 2.0), (6.0, 0.0))
    found = refusal((n1, e1), (n2, e2), zone, carrot_m=99.0)
    free = np.ones((10, 40), dtype=np.bool_)
    free[4:6, 20:22] = False
    is_clear = LineOfSight(free).is_clear(np.array((n1, e1 + 20)), np.array((n2, e2 + 20)))
    assume(not is_in_polygon((n1, e1), zone))
    assert (found is None) is bool(is_clear) or found == IN


@pytest.mark.parametrize("there", [(5.0, 15.5), (5.5, 15.0)])
def test_without_zones_there_is_nothing_to_keep_out_of(there: Corner) -> None:
    assert ENVELOPE.keep_out == ()
    assert refusal((5.0, 15.0), there) is None


OWN = "outside the autopilot's own fence"
AREAS = (
    ((4.0, 13.0), (4.0, 16.0), (6.0, 16.0), (6.0, 13.0)),
    ((3.0, 14.0), (3.0, 19.0), (5.5, 19.0), (5.5, 14.0)),
)
"""Of the autopilot's own fence: it stays in both."""


@pytest.mark.parametrize("areas", [AREAS, AREAS[::-1]])
@pytest.mark.parametrize(
    ("edge", "outwards"),
    [
        ((4.25, 15.0), (-1, 0)),
        ((5.25, 15.0), (1, 0)),
        ((5.0, 14.25), (0, -1)),
        ((5.0, 15.75), (0, 1)),
    ],
)
def test_each_area_of_the_autopilots_own_fence_holds(
    areas: tuple[tuple[Corner, ...], ...], edge: Corner, outwards: Corner
) -> None:
    """With the margin of the mission's own."""
    envelope = replace(ENVELOPE, within=areas)
    state = heard(position=(*edge, -2.25))
    at_the_margin = replace(GOOD, position=(*edge, -2.25))
    assert verdict(at_the_margin, state, envelope) == Verdict(at_the_margin)
    for beyond_m in (AFTER, 1.0):
        north, east = (e + beyond_m * o for e, o in zip(edge, outwards, strict=True))
        found = verdict(replace(GOOD, position=(north, east, -2.25)), state, envelope)
        assert found == Verdict(
            hold_at(state.motion.position, state.attitude.yaw_rad), Refusal(OWN)
        )


def test_the_missions_fence_holds_beside_it() -> None:
    wide = ((-50.0, -50.0), (-50.0, 50.0), (50.0, 50.0), (50.0, -50.0))
    state = heard(position=(9.5, 15.0, -2.25))
    beyond = replace(GOOD, position=(9.75 + AFTER, 15.0, -2.25))
    found = verdict(beyond, state, replace(ENVELOPE, within=(wide,)))
    assert found.refusal == Refusal("outside the fence")
