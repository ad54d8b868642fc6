"""Flights in a hall that is not as the mission's map says, in lockstep.

Crates stand where the map shows none, from the start or from the middle of a flight on. The lidar
sees them; the clearance is asked of the true map.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from lockstep import Lockstep

from companion.flight_events.facts import BeliefWithdrawn, PlacesConnected, PlacesCutOff
from companion.flight_events.skills import (
    PlaceReached,
    RouteBlocked,
    RouteResponse,
    SkillCompleted,
    SkillFailed,
)
from companion.flight_events.sortie import Phase, PhaseEntered, ReturnBegun, TaskSatisfied
from companion.geometry import horizontal_distance
from companion.mission.model import Mission
from companion.vehicle_profile import VehicleProfile
from sitl.world.scenario import read_scenario

QUAD = VehicleProfile()

MISSIONS = Path(__file__).parents[2] / "missions"
STRAIGHT_TO_B = "circle: {east_m: 15.3, north_m: 10.3, radius_m: 0.5}"
ACROSS = "box: {east_m: [15, 15.2], north_m: [-2, 14]}"
OTHER_CRATES = [(False, 0), (False, 1), (False, 2), (True, 0), (True, 2)]
"""Whether it comes late, and the seed of the gusts: flown with the sweeps."""
ON_B = "circle: {east_m: 17.5, north_m: 10.3, radius_m: 0.5}"
HALFWAY = "place: {east_m: 12.5, north_m: 10.2, radius_m: 0.6}"
"""On the way from A to B, 2.3 m before the crate that stands straight on the way."""


class Flown(Lockstep):
    """A flight among obstacles, until the companion has ended.

    Attributes:
        least_m: the least distance to anything on the true map, in OFFBOARD.
    """

    def __init__(
        self,
        mission: Mission,
        folder: Path,
        obstacles: str,
        happens: str = "",
        seed: int = 0,
        is_target_there: bool = True,
    ) -> None:
        text = (MISSIONS / "surveillance.sim.yaml").read_text(encoding="utf-8")
        if not is_target_there:
            text = text.replace("radius_m: 0.8, visit: 2", "radius_m: 0.8, visit: 99")
            assert "visit: 99" in text
        text = text.replace("map: maps/", f"map: {MISSIONS}/maps/")
        path = folder / "world.sim.yaml"
        path.write_text(f"{text}\nobstacles:\n{obstacles}\n{happens}", encoding="utf-8")
        super().__init__(mission, read_scenario(path), seed=seed)
        self.least_m = math.inf
        self.until(self._has_ended, limit_s=200.0)

    def _has_ended(self) -> bool:
        true_map = self.simulation.true_map
        if self.simulation.mode == "OFFBOARD" and true_map is not None:
            north, east, _ = self.simulation.flight.position
            self.least_m = min(self.least_m, true_map.clearance_m((north, east)))
        return self.companion.has_ended

    @property
    def is_unhurt(self) -> bool:
        """Nothing was touched, and nothing came as near as the vehicle is wide."""
        return self.simulation.collisions == 0 and self.least_m >= QUAD.radius_m


def a_crate(shape: str, is_late: bool = False) -> str:
    return f"  - {{name: crate, {shape}, present: {str(not is_late).lower()}}}"


def appears(trigger: str) -> str:
    return f"happens:\n  - {{{trigger}, obstacle: {{name: crate, present: true}}}}"


@pytest.fixture(scope="module")
def late_crate(surveillance: Mission, tmp_path_factory: pytest.TempPathFactory) -> Flown:
    """A flight that is over, round a crate that appears on its way; to be read only."""
    crate, folder = a_crate(STRAIGHT_TO_B, is_late=True), tmp_path_factory.mktemp("late")
    return Flown(surveillance, folder, crate, appears(HALFWAY), seed=1)


def test_a_crate_that_appears_on_the_way_is_flown_round(late_crate: Flown) -> None:
    is_flown_round(late_crate)


@pytest.mark.parametrize(
    ("is_late", "seed"),
    [pytest.param(late, seed, marks=pytest.mark.long) for late, seed in OTHER_CRATES],
)
def test_a_crate_on_the_way_is_flown_round(
    seed: int, is_late: bool, surveillance: Mission, tmp_path: Path
) -> None:
    happens = appears(HALFWAY) if is_late else ""
    is_flown_round(Flown(surveillance, tmp_path, a_crate(STRAIGHT_TO_B, is_late), happens, seed))


def is_flown_round(flown: Flown) -> None:
    assert flown.is_unhurt
    assert RouteBlocked("B", RouteResponse.ANOTHER_ROUTE) in flown.events
    assert flown.exit_code == 0
    assert flown.places == ["A", "B", "C", "A", "r1", "r2", "Home"]
    assert flown.of(BeliefWithdrawn) == [BeliefWithdrawn("canUpload(r1)")]
    assert flown.of(SkillCompleted) == [SkillCompleted("upload(r2)")]


@pytest.mark.parametrize("is_late", [pytest.param(False, marks=pytest.mark.long), True])
def test_without_a_way_it_stops_gives_up_the_belief_and_flies_home(
    is_late: bool, surveillance: Mission, tmp_path: Path
) -> None:
    """Fig. 6: trans_ok(A, B) is withdrawn; the map leaves no move to the eastern places."""
    happens = appears(HALFWAY) if is_late else ""
    flown = Flown(surveillance, tmp_path, a_crate(ACROSS, is_late), happens, is_target_there=False)
    assert flown.is_unhurt
    assert SkillFailed("move(A, B)", "no clear route to B") in flown.events
    assert BeliefWithdrawn("trans_ok(A, B)") in flown.events
    by_the_map = set(flown.one(PlacesCutOff).withdrawn)
    lost = {"trans_ok(A, C)", "trans_ok(B, Home)", "trans_ok(r1, B)"}
    assert lost <= by_the_map
    assert not {"trans_ok(A, B)", "trans_ok(A, r1)", "trans_ok(B, C)"} & by_the_map
    assert flown.exit_code == 3
    assert "B" not in flown.places and flown.places[-1] == "Home"
    assert horizontal_distance(flown.simulation.flight.position, (0.0, 0.0)) < 0.5


@pytest.mark.long
def test_a_way_that_opens_again_is_believed_in_and_the_task_goes_on(
    surveillance: Mission, tmp_path: Path
) -> None:
    """On the way home, without a plan, the vehicle sees that nothing stands there any more."""
    goes = "  - {at_s: 30, obstacle: {name: crate, present: false}}"
    hasty = replace(surveillance, patience_s=0.0)
    flown = Flown(hasty, tmp_path, a_crate(ACROSS, True), f"{appears(HALFWAY)}\n{goes}")
    assert flown.is_unhurt
    cut_off, connected = flown.one(PlacesCutOff), flown.one(PlacesConnected)
    assert set(connected.restored) == {*cut_off.withdrawn, "trans_ok(A, B)"}
    since = flown.events[flown.events.index(ReturnBegun("Home")) + 1 :]
    told = (PlaceReached, SkillCompleted, SkillFailed, PhaseEntered, TaskSatisfied)
    assert [event for event in since if isinstance(event, told)] == [
        PlaceReached("C", "move(here, C)"),
        PlaceReached("B", "move(C, B)"),
        PlaceReached("r1", "move(here, r1)"),
        SkillFailed("upload(r1)", "denied"),
        PlaceReached("r2", "move(r1, r2)"),
        SkillCompleted("upload(r2)"),
        PlaceReached("Home", "move(r2, Home)"),
        PhaseEntered(Phase.LANDING),
        TaskSatisfied(),
    ]


@pytest.mark.long
def test_a_crate_on_the_place_itself_fails_the_move(surveillance: Mission, tmp_path: Path) -> None:
    flown = Flown(surveillance, tmp_path, a_crate(ON_B))
    assert flown.is_unhurt
    assert SkillFailed("move(A, B)", "no clear route to B") in flown.events
    assert BeliefWithdrawn("trans_ok(A, B)") in flown.events
    assert flown.exit_code == 3


def test_a_vehicle_that_holds_stays_and_leaves_away_from_what_has_come_near(
    surveillance: Mission, tmp_path: Path
) -> None:
    """While it uploads at r1, a crate appears 0.45 m from it, straight on its way to r2."""
    shape = "circle: {east_m: 9.4, north_m: 4.75, radius_m: 0.2}"
    happens = appears("command: MAV_CMD_USER_1, nth: 1")
    flown = Flown(surveillance, tmp_path, a_crate(shape, is_late=True), happens)
    assert flown.is_unhurt
    (seen_s,) = [t_s for t_s, text in flown.simulation.event_log if "crate" in text]
    failed_s = flown.time_of(SkillFailed, action="upload(r1)", reason="denied")
    assert failed_s - seen_s > 1.0
    r1 = surveillance.places["r1"].position
    held = [s.message for s in flown.setpoints if seen_s < s.time_s < failed_s]
    assert all(math.dist((m.x, m.y, m.z), r1) < 0.1 for m in held)
    assert "r2" in flown.places
    assert SkillCompleted("upload(r2)") in flown.events
    assert flown.ending == TaskSatisfied()


@pytest.mark.long
def test_the_flight_is_the_same_each_time(
    late_crate: Flown, surveillance: Mission, tmp_path: Path
) -> None:
    again = Flown(surveillance, tmp_path, a_crate(STRAIGHT_TO_B, True), appears(HALFWAY), seed=1)
    assert late_crate.reports == again.reports
