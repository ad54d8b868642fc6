"""A fence of somebody else that is kept leaves routes and gate no more room than it has."""

from __future__ import annotations

from dataclasses import replace

import pytest
from kept_journal import KeptJournal
from sortie_rig import SortieRig
from synthetic import mission

from companion.acting.journal import FlightBegun, put_together
from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.acting.sortie.preflight.kept_fence import keep_to
from companion.flight_events.fence import FenceKept
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.sortie import Phase
from companion.geofence import FenceArea, FenceCircle, FencePolygon, KeptFence, StoredFence
from companion.geometry import NorthEast
from companion.mission.model import Mission
from companion.mission.tree_nodes import Act

ASKED = mission("G F at(A) & G F at(B)")
WIDE = FenceArea(FenceCircle((3.0, 3.0), 50.0), True)

HORSESHOE = ((-9, -20), (-9, 9), (2, 9), (2, -15), (4, -15), (4, 9), (9, 9), (9, -20))
"""H in its southern arm, A and B in the northern one; they meet outside the mission's fence."""


def zone(south: float, west: float, north: float, east: float, inside: bool = False) -> FenceArea:
    corners = ((south, west), (south, east), (north, east), (north, west))
    return FenceArea(FencePolygon(corners), inside)


def rig(*areas: FenceArea, asked: Mission = ASKED) -> SortieRig:
    run = SortieRig(asked, arming=ArmingTerms(fence=UploadPolicy.KEEP))
    run.vehicle.fence.nowhere = None
    run.vehicle.fence.stored = StoredFence(areas, 4 * len(areas))
    run.rig.flight.journal = run.journal = KeptJournal()  # type: ignore[attr-defined]
    return run


def refused(run: SortieRig) -> str:
    reason = run.until(Phase.ENDED).failure.reason
    assert run.vehicle.pursued == [], "it was to arm"
    return reason


def ways(run: SortieRig) -> list[NorthEast]:
    """The waypoints of the way from A to B."""
    route = run.rig.flight.routes.route(ASKED.places["A"].position, "B")
    assert route is not None
    return [(north, east) for north, east, _ in route.waypoints.tolist()]


def test_a_fence_that_holds_all_of_the_missions_own_changes_no_plan() -> None:
    run = rig(WIDE)
    run.until(Phase.TAKE_OFF)
    run.one(FenceKept)
    assert run.of(PlanReplaced) == [] and ways(run) == [(6.0, 0.0), (6.0, 6.0)]
    assert run.vehicle.setpoints.kept_fence == KeptFence.of([WIDE])


def test_routes_lead_around_its_zones_and_keep_away_from_them() -> None:
    run = rig(WIDE, zone(5.0, 2.5, 9.0, 3.5))
    run.until(Phase.TAKE_OFF)
    south = min(north for north, _ in ways(run))
    assert south < 5.0 - ASKED.vehicle.clearance_m + 0.1
    kept = run.vehicle.setpoints.kept_fence
    assert kept is not None
    assert kept.keep_out == (((5.0, 2.5), (5.0, 3.5), (9.0, 3.5), (9.0, 2.5)),)


def test_another_plan_is_made_where_the_first_one_leads_out() -> None:
    """A flower bed between H and A: it begins with B now, to which the way is free."""
    run = rig(WIDE, zone(2.5, -9.0, 3.5, 4.0))
    before = run.until(Phase.CHECKING).rig.executive.lasso
    after = run.until(Phase.TAKE_OFF).rig.executive.lasso
    assert before is not None and after is not None
    assert before.prefix[0].name == "move(H, A)"
    assert after.prefix[0].name == "move(H, B)"
    assert run.one(PlanReplaced).reason == "the vehicle's own fence leaves less room"


@pytest.mark.parametrize(
    ("area", "does"),
    [
        (zone(2.5, -9.0, 3.5, 9.0), "crosses area 2 of 2"),
        (FenceArea(FencePolygon(HORSESHOE), True), "leaves area 2 of 2"),
    ],
)
def test_without_a_plan_it_is_refused_by_the_leg_and_the_area(area: FenceArea, does: str) -> None:
    reason = refused(rig(WIDE, area))
    first, *more = reason.splitlines()
    assert first.startswith("no plan within the vehicle's own fence (8 points, 2 areas): ")
    assert "the way from " in first and does in first
    assert more[0].startswith("no plan: ")


def test_a_place_too_near_to_its_edge_is_told() -> None:
    """It lies inside, and no nearer to the edge than the gate would let the vehicle come."""
    reason = refused(rig(zone(-9.0, -9.0, 6.05, 9.0, inside=True)))
    assert "the way from H to A comes too near to its edge" in reason


def test_a_tree_that_flies_where_no_way_leads_is_refused() -> None:
    asked = replace(ASKED, tree=Act("move(*, A)"))
    assert "the tree flies to A, and no way leads there" in refused(
        rig(WIDE, zone(2.5, -9.0, 3.5, 9.0), asked=asked)
    )
    rig(WIDE, zone(2.5, -9.0, 3.5, 4.0), asked=asked).until(Phase.TAKE_OFF)


def test_whoever_goes_on_with_the_flight_has_it_from_the_journal() -> None:
    run = rig(WIDE, zone(5.0, 2.5, 9.0, 3.5))
    run.until(Phase.TAKE_OFF)
    begun = (0.0, FlightBegun("m", "m.yaml", "0a", 0.0))
    flight = put_together([begun, *run.journal.entries])  # type: ignore[attr-defined]
    assert flight is not None and flight.fence is not None
    assert flight.fence == run.vehicle.setpoints.kept_fence
    again = rig()
    assert keep_to(again.rig.flight, flight.fence)
    assert ways(again) == ways(run)
