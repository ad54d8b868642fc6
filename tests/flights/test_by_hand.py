"""A mission whose tree was written by hand flies as the planned one does."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import meadow
import pytest
from lockstep import COMPANION, Lockstep

from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import NoPlanFound
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    Phase,
    PhaseEntered,
    ReturnBegun,
    ReturnedAsAsked,
    RunFailed,
    SetpointRefused,
)
from companion.flight_events.word import PositionLeft
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"


SCENARIO = (
    (MISSIONS / "by_hand.sim.yaml")
    .read_text(encoding="utf-8")
    .replace("maps/", f"{MISSIONS}/maps/")
)
SEEN = "seen: {east_m: 10.4, north_m: 9.9, radius_m: 0.8, visit: 2}"
SOON = SCENARIO.replace(SEEN, SEEN.replace("visit: 2", "visit: 1"))
"""As in the short hall: a lap sooner."""


def fly(scenario: str = SOON, **options: Any) -> Lockstep:
    world = read_scenario(scenario)
    return Lockstep(load_mission(MISSIONS / "by_hand.yaml"), world, seed=1, **options)


@pytest.fixture(scope="module")
def by_tree() -> Lockstep:
    """A flight that is over; to be read only."""
    return fly().until_the_end()


def word(flight: Lockstep) -> list[tuple[str, ...]]:
    """The facts at each position."""
    return [s.event.facts for s in flight.recorded if isinstance(s.event, PositionLeft)]


@pytest.mark.long
def test_it_visits_the_places_of_the_planned_mission_in_the_same_order(
    by_tree: Lockstep, undisturbed: Lockstep
) -> None:
    assert by_tree.exit_code == 0
    assert by_tree.simulation.collisions == 0
    assert by_tree.places == undisturbed.places


@pytest.mark.long
def test_and_so_it_does_in_the_shipped_world(surveillance_run: Path) -> None:
    """In which the target is found a lap later."""
    lines = (surveillance_run / "events.jsonl").read_text(encoding="utf-8").splitlines()
    planned = [e.place for e in (read_line(x).event for x in lines) if isinstance(e, PlaceReached)]
    assert fly(SCENARIO).until_the_end().places == planned


def test_a_target_that_is_seen_before_the_first_flight_is_reported_from_home() -> None:
    at_home = SCENARIO.replace(f"  {SEEN}\n", "") + "happens: [{at_s: 2, target: seen}]\n"
    flight = fly(at_home).until_the_end()
    assert flight.exit_code == 0
    assert flight.places == ["r1", "r2", "Home"]
    assert flight.of(PlaceReached)[0].action == "move(Home, r1)"


@pytest.mark.long
def test_after_a_pause_it_goes_on_with_what_was_under_way(by_tree: Lockstep) -> None:
    flight = fly(has_station=True).until_reported(PlaceReached, place="A").run_for(2.0)
    pause = dialect.MAV_CMD_DO_PAUSE_CONTINUE
    flight.station_commands(pause, 0.0, component=COMPANION)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(10.0)
    flight.station_commands(pause, 1.0, component=COMPANION)
    flight.until_the_end()
    assert flight.exit_code == 0
    assert flight.places == by_tree.places
    assert word(flight) == word(by_tree) != []


OF_ITS_OWN = meadow.DATA | {
    "limits": {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [29, -9], [29, 9], [-9, 9]]},
    "events": {"alarm": {"when": "COMMAND.MAV_CMD_USER_3"}},
    "task": {"visit": "F at(A)", "answer": "G (alarm -> F at(Home))"},
}


def fly_own(*nodes: str, **world: Any) -> Lockstep:
    mission = load_mission(OF_ITS_OWN | {"tree": list(nodes)})
    return Lockstep(mission, world_of(mission, {"version": 1, **world}), seed=1).until_the_end()


def test_a_wait_is_held_by_the_tree_and_not_by_the_gate() -> None:
    flight = fly_own("move(Home, A)", "wait(5)", "move(A, Home)")
    assert flight.exit_code == 0 and not flight.of(SetpointRefused)
    times_s = [setpoint.time_s for setpoint in flight.setpoints]
    assert max(later - sooner for sooner, later in pairwise(times_s)) < 0.2


def test_what_comes_on_the_way_home_after_a_tree_has_failed_changes_nothing() -> None:
    alarm = {"at_s": 19, "operator": "MAV_CMD_USER_3"}
    flight = fly_own("move(Home, A)", "at(Home)", happens=[alarm])
    assert flight.time_of(ReturnBegun) < flight.time_of(MissionEventChanged, event="alarm")
    assert flight.one(ReturnBegun) and not flight.of(NoPlanFound)
    ending = flight.ending
    assert isinstance(ending, RunFailed)
    assert ending.reason == "the tree has failed: not at(Home)"


def test_called_home_in_a_pause_it_flies_home() -> None:
    flight = fly(has_station=True).until_reported(PlaceReached, place="A").run_for(2.0)
    flight.station_commands(dialect.MAV_CMD_DO_PAUSE_CONTINUE, 0.0, component=COMPANION)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(2.0)
    flight.station_commands(dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH, component=COMPANION)
    flight.until_the_end()
    assert isinstance(flight.ending, ReturnedAsAsked)
