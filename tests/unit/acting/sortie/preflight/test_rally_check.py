"""The autopilot's rally points before arming: what is written, kept, replaced, refused, told."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fake_devices import FakeRally
from sortie_rig import SortieRig
from synthetic import mission

from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.acting.sortie.preflight.rally_check import rally_places
from companion.flight_events.rally import (
    RallyKept,
    RallyMissing,
    RallyRemoved,
    RallyReplaced,
    RallyUnused,
    RallyWritten,
)
from companion.flight_events.sortie import Phase
from companion.mission.otherwise import LandAtSafePlace, Otherwise
from companion.outcomes import Failed, Progress
from companion.rally_points import RallyPoint, StoredRally

ASKED = mission("F at(A)", "HABC", otherwise=LandAtSafePlace(("H", "B", "C")))
NONE = replace(ASKED, otherwise=Otherwise.RETURN_HOME)
B, C = RallyPoint((6.0, 6.0)), RallyPoint((0.0, 6.0))
OTHER = StoredRally((RallyPoint((3.0, 3.0), 20.0),))
OUT = "    --rally-points none leaves them alone"


def rig(
    policy: UploadPolicy = UploadPolicy.UPLOAD,
    stored: StoredRally | None = None,
    asked: object = ASKED,
    return_type: float | None = 0.0,
) -> SortieRig:
    run = SortieRig(asked, arming=ArmingTerms(rally_points=policy))  # type: ignore[arg-type]
    run.vehicle.rally.stored = stored or StoredRally(())
    if return_type is not None:
        run.vehicle.parameters["RTL_TYPE"] = return_type
    return run


def refused(run: SortieRig) -> str:
    reason = run.until(Phase.ENDED).failure.reason
    assert run.vehicle.pursued == [], "it was to arm"
    return reason


def armed(run: SortieRig) -> FakeRally:
    run.until(Phase.TAKE_OFF)
    return run.vehicle.rally


def test_they_are_the_safe_places_other_than_home() -> None:
    assert [place.name for place in rally_places(ASKED)] == ["B", "C"]
    assert rally_places(NONE) == ()
    assert rally_places(replace(ASKED, otherwise=LandAtSafePlace(("H",)))) == ()


def test_they_are_written_where_there_are_none_on_the_ground_there() -> None:
    run = rig()
    assert armed(run).written == [(B, C)]
    assert run.one(RallyWritten).points == "B, C"


@pytest.mark.parametrize("order", [(B, C), (C, B)])
@pytest.mark.parametrize("is_mine", [False, True])
def test_those_that_are_there_already_are_not_written_again_if_they_are_ours(
    order: tuple[RallyPoint, ...], is_mine: bool
) -> None:
    """Of others' it is not known in which frame they were sent."""
    moved = tuple(replace(p, position=(p.position[0] + 0.1, p.position[1])) for p in order)
    run = rig(stored=StoredRally(moved))
    run.vehicle.rally.is_mine = is_mine
    assert armed(run).written == ([] if is_mine else [(B, C)])
    if is_mine:
        assert run.one(RallyKept).points == "its rally points at B, C"
    else:
        assert run.one(RallyWritten).points == "B, C"


@pytest.mark.parametrize("up_m", [0.3, None])
def test_another_altitude_is_another_point(up_m: float | None) -> None:
    run = rig(stored=StoredRally((replace(B, up_m=up_m), C)))
    assert refused(run).startswith("the vehicle has 2 rally points of somebody else")


def test_somebody_elses_are_refused_with_all_ways_out() -> None:
    run = rig(stored=OTHER)
    assert refused(run) == (
        "the vehicle has 1 rally point of somebody else\n"
        "    --rally-points keep flies with them; the companion lands at the mission's\n"
        "    --rally-points replace puts the mission's in their place"
    )
    assert run.vehicle.rally.written == []


@pytest.mark.parametrize("how", ["replace", "own"])
def test_others_give_way_where_that_was_said_or_they_are_ours(how: str) -> None:
    run = rig(UploadPolicy.REPLACE if how == "replace" else UploadPolicy.UPLOAD, OTHER)
    run.vehicle.rally.is_mine = how == "own"
    assert armed(run).written == [(B, C)]
    told = run.one(RallyReplaced)
    assert (told.points, told.before) == ("B, C", "1 rally point")


def test_others_are_kept_where_that_was_said() -> None:
    run = rig(UploadPolicy.KEEP, OTHER)
    assert armed(run).written == []
    assert run.one(RallyKept).points == "1 rally point"


def test_where_they_are_to_be_kept_none_are_written() -> None:
    run = rig(UploadPolicy.KEEP)
    assert armed(run).written == []
    assert run.one(RallyMissing).reason == "it has none, and none are asked for"


def test_one_that_is_kept_lies_in_the_missions_fence() -> None:
    run = rig(UploadPolicy.KEEP, StoredRally((B, RallyPoint((30.0, 0.0)))))
    assert refused(run) == (
        "rally point 2 of 2 of the vehicle lies outside the mission's fence, or in a zone\n"
        f"    --rally-points replace puts the mission's in their place\n{OUT}"
    )


def test_what_is_read_back_is_compared() -> None:
    run = rig()
    run.vehicle.rally.write = lambda points: setattr(run.vehicle.rally, "stored", OTHER)  # type: ignore[method-assign]
    assert "mission's rally points, but reports others (1 rally point)" in refused(run)


def test_an_autopilot_that_takes_none_is_told_with_the_way_out() -> None:
    run = rig()
    run.vehicle.rally.taken = Failed("it does not take 2 rally points: the answer is unsupported")
    told = "it does not take 2 rally points: the answer is unsupported"
    assert refused(run) == f"{told}\n{OUT}"


def test_an_autopilot_that_is_nowhere_is_told_and_flown() -> None:
    run = rig()
    run.vehicle.rally.nowhere = "the autopilot reports no position on the earth"
    assert armed(run).written == []
    assert run.one(RallyMissing).reason == "the autopilot reports no position on the earth"


def test_one_that_is_left_alone_is_not_even_asked() -> None:
    assert armed(rig(UploadPolicy.NONE, OTHER)).reads == 0


def test_nothing_is_asked_when_somebody_arms_it_meanwhile() -> None:
    run = rig()
    run.vehicle.rally.outcome = Progress.RUNNING
    run.until(Phase.CHECKING).run(0.3)
    run.vehicle.change(is_armed=True)
    run.step()
    assert "armed or flying already" in run.failure.reason


# -- missions without safe places ------------------------------------------------------------------


def test_without_safe_places_an_autopilot_is_not_asked() -> None:
    assert armed(rig(asked=NONE, stored=OTHER)).reads == 0


@pytest.mark.parametrize("is_mine", [False, True])
def test_those_of_another_mission_are_taken_away_if_they_are_ours(is_mine: bool) -> None:
    run = rig(asked=NONE, stored=OTHER)
    run.vehicle.rally.has_written, run.vehicle.rally.is_mine = True, is_mine
    assert armed(run).written == ([()] if is_mine else [])
    assert [each.before for each in run.of(RallyRemoved)] == ["1 rally point"] * is_mine


def test_they_are_taken_away_as_well_where_that_was_said() -> None:
    run = rig(UploadPolicy.REPLACE, OTHER, NONE)
    assert armed(run).written == [()]
    assert run.one(RallyRemoved).before == "1 rally point"


def test_one_that_does_not_speak_of_them_is_flown_then() -> None:
    run = rig(asked=NONE)
    run.vehicle.rally.has_written = True
    run.vehicle.rally.outcome = Failed("the autopilot does not report its rally points: no answer")
    assert armed(run).written == []
    assert "no answer" in run.one(RallyMissing).reason


# -- what the autopilot's Return does not use ------------------------------------------------------


@pytest.mark.parametrize("return_type", [2.0, 4.0])
def test_a_return_that_goes_to_none_of_them_is_told(return_type: float) -> None:
    run = rig(return_type=return_type)
    assert armed(run).written == [(B, C)]
    (unused,) = run.of(RallyUnused)
    assert unused.points == "B, C"
    assert unused.reason == f"RTL_TYPE is {return_type:g}; set 0 for home and rally points"


def test_a_return_that_does_not_go_home_is_told() -> None:
    run = rig(return_type=1.0)
    armed(run)
    assert [each.points for each in run.of(RallyUnused)] == ["H", "B, C"]


def test_what_is_near_home_is_told() -> None:
    run = rig()
    armed(run)
    assert run.one(RallyUnused).points == "B, C"
    assert run.one(RallyUnused).reason == "PX4 ignores what lies within 10 m of home"


def test_an_autopilot_that_does_not_say_is_waited_for_for_a_while() -> None:
    run = rig(return_type=None)
    run.until(Phase.CHECKING)
    start_s = run.rig.flight.now_s
    armed(run)
    assert 3.0 < run.rig.flight.now_s - start_s < 5.0
