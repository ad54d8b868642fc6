"""`at(X)` is held against the position: what takes the vehicle away interrupts, and no more."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes import FakeVehicle
from rig import Rig
from sortie_rig import SortieRig
from synthetic import POSITIONS, command, mission

from companion.acting.whereabouts import MARGIN_M, OUTSIDE_S
from companion.flight_events.facts import BeliefWithdrawn, PlaceLost
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import Phase
from companion.geometry import Ned, distance
from companion.mission.tree_nodes import Act, Fallback, Steps
from companion.outcomes import Progress
from companion.tick import TICK_S
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.state import Mode

AT_A = command("do", "at(A)", "done")
NORTH, EAST, DOWN = POSITIONS["A"]
RADIUS_M = 0.6


def blow(vehicle: FakeVehicle, away_m: float) -> None:
    """To the east of A, and there it stays."""
    vehicle.change(position=(NORTH, EAST + away_m, DOWN))
    vehicle.is_stuck = True


def busy_at_a() -> Rig:
    """The payload takes its time."""
    vehicle = FakeVehicle((0.0, 0.0, 0.0)).take_off(2.0)
    vehicle.payloads.answers = [(30.0, Progress.DONE)]
    rig = Rig(mission("F done", skills=[AT_A]), vehicle=vehicle).begin()
    rig.run(lambda: bool(vehicle.payloads.sent))
    return rig


def tick_for(rig: Rig, seconds: float) -> None:
    for _ in range(round(seconds / TICK_S)):
        rig.tick()


def test_blown_away_from_a_place_it_flies_back_before_it_goes_on() -> None:
    rig = busy_at_a()
    blow(rig.vehicle, 3.0)
    tick_for(rig, OUTSIDE_S)
    assert not rig.of(PlaceLost)
    rig.tick()
    assert rig.of(PlaceLost) == [PlaceLost("A", 3.0)]
    assert rig.one(PlanReplaced).reason == "no longer at A"
    assert str(rig.executive.lasso) == "move(here, A), do, (wait)^w"
    rig.vehicle.is_stuck = False
    rig.run_to_the_end()
    assert len(rig.vehicle.payloads.sent) == 2 and rig.of(SkillCompleted)
    assert distance(rig.vehicle.state.motion.position, POSITIONS["A"]) < RADIUS_M  # type: ignore[union-attr]
    assert not rig.of(BeliefWithdrawn), "the payload has not failed"


def test_the_loss_appends_no_position() -> None:
    rig = busy_at_a()
    blow(rig.vehicle, 3.0)
    tick_for(rig, OUTSIDE_S + TICK_S)
    rig.vehicle.is_stuck = False
    rig.run_to_the_end()
    places = [next(f for f in p.facts if f.startswith("at(")) for p in rig.positions]
    begun, again, done, rest = ["at(A)"] * 4
    assert places == ["at(H)", begun, again, done, rest]
    assert rig.positions[-1].for_ever


def test_a_position_that_nothing_has_left_is_left_by_the_loss() -> None:
    """It was reached in this very tick, so nobody has read it yet."""
    rig = busy_at_a()
    rig.task.interrupt()
    rig.task.complete(replace(rig.executive.lasso.prefix[0]), 0.0)  # type: ignore[union-attr]
    blow(rig.vehicle, 3.0)
    assert len(rig.positions) == 2
    tick_for(rig, OUTSIDE_S + TICK_S)
    assert rig.positions[2].facts == ("at(A)",)


def test_a_gust_passes() -> None:
    rig = busy_at_a()
    for _ in range(5):
        blow(rig.vehicle, 3.0)
        tick_for(rig, OUTSIDE_S - TICK_S)
        blow(rig.vehicle, 0.0)
        rig.tick()
    assert not rig.of(PlaceLost)


@pytest.mark.parametrize(
    ("accuracy_m", "limit_m"), [(0.0, RADIUS_M + MARGIN_M), (0.2, 1.1), (0.5, 1.6), (2.0, 4.6)]
)
def test_how_far_is_away_follows_the_accuracy_of_the_estimate(
    accuracy_m: float, limit_m: float
) -> None:
    for away_m, is_lost in ((limit_m - 0.01, False), (limit_m + 0.01, True)):
        rig = busy_at_a()
        rig.vehicle.change(accuracy_m=accuracy_m)
        blow(rig.vehicle, away_m)
        tick_for(rig, OUTSIDE_S + TICK_S)
        assert bool(rig.of(PlaceLost)) is is_lost


def test_height_counts() -> None:
    rig = busy_at_a()
    blow(rig.vehicle, 0.0)
    rig.vehicle.change(position=(NORTH, EAST, DOWN - 1.5))
    tick_for(rig, OUTSIDE_S + TICK_S)
    assert rig.of(PlaceLost)


@pytest.mark.parametrize("is_landed", [True, False])
def test_on_the_ground_and_while_landing_by_plan_nothing_is_lost(is_landed: bool) -> None:
    rig = busy_at_a()
    blow(rig.vehicle, 3.0)
    rig.vehicle.change(is_landed=is_landed)
    if not is_landed:
        rig.flight.progress.take_to_ground()
    tick_for(rig, 3 * OUTSIDE_S)
    assert not rig.of(PlaceLost)


def test_in_flight_nothing_is_lost() -> None:
    rig = Rig(mission("G F at(A) & G F at(B)")).begin()
    rig.run_until(PlaceReached, times=6)
    assert not rig.of(PlaceLost) and not rig.of(PlanReplaced)


# -- after somebody else has flown it --------------------------------------------------------------

ELSEWHERE: Ned = (3.0, 3.0, -2.0)


def interrupted_at_a(tree: bool = False) -> SortieRig:
    """A sortie whose command at A is under way."""
    asked = mission("F done", skills=[AT_A])
    if tree:
        back = Fallback((Act("do"), Steps((Act("move(*, A)"), Act("do")))))
        asked = replace(asked, task={}, tree=Steps((Act("move(H, A)"), back)))
    run = SortieRig(asked, may_yield=True)
    run.vehicle.payloads.answers = [(30.0, Progress.DONE)]
    while not run.vehicle.payloads.sent:
        run.step()
    return run


def pause(run: SortieRig) -> None:
    assert run.sortie.pause() is None
    run.run(0.5)


def take_over(run: SortieRig) -> None:
    run.vehicle.change(mode=Mode.POSCTL)
    run.vehicle.control.takeover = Takeover(Mode.POSCTL, is_failsafe=False)
    run.run(0.5)
    run.vehicle.change(mode=Mode.LOITER)


@pytest.mark.parametrize("absence", [pause, take_over])
@pytest.mark.parametrize("tree", [False, True], ids=["plan", "tree by hand"])
def test_what_was_begun_at_a_place_goes_on_there_and_nowhere_else(
    absence: object, tree: bool
) -> None:
    run = interrupted_at_a(tree)
    absence(run)  # type: ignore[operator]
    run.vehicle.change(position=ELSEWHERE)
    assert run.sortie.resume() is None
    run.vehicle.flown[:] = []
    run.until(Phase.TASK)
    while len(run.vehicle.payloads.sent) < 2:
        run.step()
    assert run.of(PlaceLost) == [PlaceLost("A", distance(ELSEWHERE, POSITIONS["A"]).__round__(1))]
    assert distance(run.position, POSITIONS["A"]) < RADIUS_M
    run.until(Phase.ENDED)
    assert run.sortie.failure is None


@pytest.mark.parametrize("absence", [pause, take_over])
def test_where_nobody_has_moved_it_the_place_is_kept(absence: object) -> None:
    run = interrupted_at_a()
    absence(run)  # type: ignore[operator]
    assert run.sortie.resume() is None
    run.until(Phase.ENDED)
    assert not run.of(PlaceLost)
    assert [e.place for e in run.of(PlaceReached)] == ["A"]
