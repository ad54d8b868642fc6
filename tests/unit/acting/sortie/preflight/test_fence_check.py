"""The autopilot's fence before arming: what is written, kept, replaced and refused, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from fake_devices import FakeFence
from sortie_rig import SortieRig
from synthetic import mission

from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.acting.sortie.preflight.fence_check import LISTEN_S, areas_of
from companion.acting.sortie.preflight.upload_check import TRANSITIONS, UploadStage
from companion.flight_events.fence import (
    FenceKept,
    FenceMissing,
    FenceNear,
    FenceReplaced,
    FenceWritten,
)
from companion.flight_events.sortie import Phase
from companion.geofence import FenceArea, FenceCircle, FencePolygon, StoredFence
from companion.geometry import NorthEast
from companion.outcomes import Failed, Progress

ASKED = mission("F at(A)")
OURS = areas_of(ASKED.limits)
THEIRS = (
    FenceArea(FenceCircle((0.0, 0.0), 500.0), True),
    FenceArea(FenceCircle((300.0, 0.0), 5.0), False),
)
OTHER = StoredFence(THEIRS, 12)


def rig(policy: UploadPolicy = UploadPolicy.UPLOAD, stored: StoredFence | None = None) -> SortieRig:
    run = SortieRig(ASKED, arming=ArmingTerms(fence=policy))
    run.vehicle.fence.nowhere = None
    run.vehicle.fence.stored = stored or StoredFence((), 0)
    return run


def refused(run: SortieRig) -> str:
    reason = run.until(Phase.ENDED).failure.reason
    assert run.vehicle.pursued == [], "it was to arm"
    return reason


def armed(run: SortieRig) -> FakeFence:
    run.until(Phase.TAKE_OFF)
    return run.vehicle.fence


def test_the_missions_fence_is_written_where_there_is_none() -> None:
    run = rig()
    run.until(Phase.CHECKING)
    start_s = run.rig.flight.now_s
    fence = armed(run)
    assert fence.written == [OURS]
    assert run.one(FenceWritten).fence == "4 points, 1 area"
    assert run.rig.flight.now_s - start_s == pytest.approx(LISTEN_S + 0.5, abs=0.3)


def test_one_that_is_there_already_is_written_once_in_each_program() -> None:
    """PX4 does not say whether a fence that it has is in force."""
    run = rig(stored=StoredFence(OURS, 4))
    fence = armed(run)
    assert fence.written == [OURS]
    again = SortieRig(ASKED)
    again.vehicle.fence = fence
    assert armed(again).written == [OURS]
    assert again.one(FenceKept) == FenceKept("4 points, 1 area"), "the mission's is drawn anyway"


def test_another_fence_is_not_overwritten() -> None:
    run = rig(stored=OTHER)
    assert refused(run) == (
        "the vehicle has another fence (12 points, 2 areas)\n"
        "    --autopilot-fence keep flies within it, beside the mission's own\n"
        "    --autopilot-fence replace puts the mission's in its place"
    )
    assert run.vehicle.fence.written == []


@pytest.mark.parametrize("moved_m", [0.15, 0.3])
def test_the_same_fence_is_the_same_within_twenty_centimetres(moved_m: float) -> None:
    corners: tuple[NorthEast, ...] = tuple(
        (n + moved_m, e) for n, e in (*ASKED.limits.fence[2:], *ASKED.limits.fence[:2])
    )
    run = rig(stored=StoredFence((FenceArea(FencePolygon(corners[::-1]), True),), 4))
    run.until(Phase.CHECKING).run(1.0)
    assert (run.sortie.phase is Phase.ENDED) is (moved_m > 0.2)


@pytest.mark.parametrize("how", ["replace", "own"])
def test_another_fence_gives_way_where_that_was_said_or_it_is_ours(how: str) -> None:
    run = rig(UploadPolicy.REPLACE if how == "replace" else UploadPolicy.UPLOAD, OTHER)
    run.vehicle.fence.is_mine = how == "own"
    assert armed(run).written == [OURS]
    told = run.one(FenceReplaced)
    assert (told.before, told.fence) == ("12 points, 2 areas", "4 points, 1 area")


def test_another_fence_is_kept_where_all_places_lie_in_it() -> None:
    run = rig(UploadPolicy.KEEP, OTHER)
    assert armed(run).written == []
    told = run.one(FenceKept)
    assert told.fence == "12 points, 2 areas"
    (field,), (bed,) = told.within, told.keep_out
    assert max(n for n, _ in field) == pytest.approx(500.0, abs=0.2)
    assert min(n for n, _ in bed) == pytest.approx(295.0, abs=0.2)


def test_where_it_is_to_be_kept_none_is_written() -> None:
    run = rig(UploadPolicy.KEEP)
    assert armed(run).written == []
    assert run.one(FenceMissing).reason == "it has none, and none is asked for"


def test_a_place_outside_is_named() -> None:
    north, east, _ = ASKED.places["A"].position
    island = FenceArea(FenceCircle((north, east), 0.5), False)
    run = rig(UploadPolicy.KEEP, StoredFence((THEIRS[0], island), 2))
    assert refused(run) == "A lies inside a zone of the vehicle's own fence (area 2 of 2)"


def test_so_it_is_in_a_mission_without_a_fence_of_its_own() -> None:
    limits = replace(ASKED.limits, is_fence_written=False)
    small = StoredFence((FenceArea(FenceCircle((0.0, 0.0), 1.0), True),), 1)
    run = SortieRig(replace(ASKED, limits=limits))
    run.vehicle.fence.nowhere, run.vehicle.fence.stored = None, small
    assert refused(run) == "A lies outside the vehicle's own fence (area 1 of 1)"


def test_the_autopilots_home_lies_in_it_or_nothing_is_written() -> None:
    run = rig()
    run.vehicle.fence.home = (500.0, 0.0)
    assert refused(run) == "the autopilot's home lies outside the mission's fence (area 1 of 1)"
    assert run.vehicle.fence.written == []


@pytest.mark.parametrize("policy", [UploadPolicy.KEEP, UploadPolicy.UPLOAD])
def test_a_fence_that_px4_misreads_is_refused(policy: UploadPolicy) -> None:
    run = rig(policy, replace(OTHER, flaw="a circle stands before a polygon"))
    assert "a circle stands before a polygon" in refused(run)


def test_what_the_autopilot_says_against_it_is_told() -> None:
    run = rig()
    run.vehicle.fence.said = ["Geofence invalid, doesn't contain Home position"]
    reason = refused(run)
    assert "leaves a part of it out: Geofence invalid, doesn't contain Home position" in reason


def test_what_is_read_back_is_compared() -> None:
    run = rig()
    run.vehicle.fence.write = lambda areas: setattr(run.vehicle.fence, "stored", OTHER)  # type: ignore[method-assign]
    assert "but reports another one (12 points, 2 areas)" in refused(run)


def test_a_frame_that_moves_meanwhile_makes_no_other_fence_of_it() -> None:
    """It settles while the vehicle stands, by more than what corners may differ by."""
    run = rig()

    def write(areas: Sequence[FenceArea]) -> None:
        run.vehicle.fence.stored = replace(OTHER, flaw=None)
        run.vehicle.fence.is_as_sent = True

    run.vehicle.fence.write = write  # type: ignore[method-assign]
    armed(run)
    assert run.one(FenceWritten)


def test_a_fence_that_is_not_taken_is_told_with_the_way_out() -> None:
    run = rig()
    run.vehicle.fence.taken = Failed("the autopilot does not take a fence of 80 points: no space")
    assert refused(run) == (
        "the autopilot does not take a fence of 80 points: no space\n"
        "    --autopilot-fence none leaves it alone"
    )


def test_an_autopilot_that_is_nowhere_is_told_and_flown() -> None:
    run = SortieRig(ASKED)
    assert armed(run).written == []
    assert run.one(FenceMissing).reason == "the autopilot reports no position on the earth"


def test_one_that_is_left_alone_is_not_even_asked() -> None:
    run = rig(UploadPolicy.NONE, OTHER)
    run.vehicle.fence.outcome = Progress.RUNNING
    assert armed(run).written == []


def test_nothing_is_asked_when_somebody_arms_it_meanwhile() -> None:
    run = rig()
    run.until(Phase.CHECKING).run(0.3)
    run.vehicle.change(is_armed=True)
    run.step()
    assert "armed or flying already" in run.failure.reason


def test_every_stage_is_reached() -> None:
    assert {row.then for row in TRANSITIONS} | {UploadStage.LOCATING} == set(UploadStage)


@pytest.mark.parametrize("policy", [UploadPolicy.UPLOAD, UploadPolicy.KEEP])
@pytest.mark.parametrize(("accuracy_m", "told_m"), [(0.05, []), (0.5, [1.5])])
def test_a_vehicle_near_the_fence_is_told_of_if_its_position_may_lie_across(
    policy: UploadPolicy, accuracy_m: float, told_m: list[float]
) -> None:
    """The mission's is 1.0 m away from where it stands, the kept one 1.3 m."""
    near = StoredFence((FenceArea(FenceCircle((28.0, 3.0), 30.0), True),), 1)
    run = rig(policy, near if policy is UploadPolicy.KEEP else None)
    run.vehicle.change(position=(-0.5, 0.0, 0.0), accuracy_m=accuracy_m)
    armed(run)
    assert [event.error_m for event in run.of(FenceNear)] == told_m
