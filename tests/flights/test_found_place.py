"""lost_person: a place that a camera's program reports in flight is flown to, where it was seen."""

from __future__ import annotations

import json
import math
from collections import deque
from dataclasses import replace
from pathlib import Path

import pytest
from lockstep import Lockstep

from companion import simulate
from companion.acting.journal import PlaceFound
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.reports import ReportRefused
from companion.flight_events.skills import PlaceReached, SkillCompleted, SymbolMoved
from companion.flight_events.sortie import ControlTakenBack, TaskSatisfied
from companion.geometry import NorthEast, horizontal_distance
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
LATE_S = 0.8
"""What a camera's program needs for a picture."""


class Camera(Lockstep):
    """A flight with a camera that sees persons, and says so LATE_S later.

    Attributes:
        persons: (time from which on one is seen, north and east), in the order of their times.
    """

    def __init__(self, mission: Mission, persons: list[tuple[float, NorthEast]]) -> None:
        scenario, grid = read_scenario(MISSIONS / "lost_person.sim.yaml")
        super().__init__(mission, (replace(scenario, events=()), grid), resumes=True)
        self.persons = persons
        self._pictures: deque[tuple[float, bytes]] = deque()

    def reported(self, now_s: float) -> list[bytes]:
        """The picture is taken now, by where the vehicle truly is; the report is that of before."""
        there = [at for since_s, at in self.persons if now_s >= since_s]
        if there:
            flight = self.simulation.flight
            north, east = (there[-1][i] - flight.position[i] for i in (0, 1))
            yaw = flight.euler[2]
            seen = {
                "forward_m": north * math.cos(yaw) + east * math.sin(yaw),
                "right_m": east * math.cos(yaw) - north * math.sin(yaw),
                "monotonic_ns": round(now_s * 1e9),
            }
            self._pictures.append((now_s + LATE_S, json.dumps({"person": seen}).encode()))
        ready = []
        while self._pictures and self._pictures[0][0] <= now_s:
            ready.append(self._pictures.popleft()[1])
        return ready

    def gap_m(self, at: NorthEast) -> float:
        """How far from a point the vehicle truly is."""
        return horizontal_distance(self.simulation.flight.position, at)


@pytest.fixture(scope="module")
def mission() -> Mission:
    return load_mission(MISSIONS / "lost_person.yaml")


@pytest.mark.long
def test_the_shipped_mission_refuses_one_report_and_flies_to_the_other(mission: Mission) -> None:
    run = simulate(mission)
    events = [stamped.event for stamped in run.events]
    assert run.exit_code == 0 and run.collisions == 0
    assert [e.place for e in events if isinstance(e, PlaceReached)] == ["West", "Person", "Home"]
    assert len([e for e in events if isinstance(e, ReportRefused)]) == 1


def test_a_person_is_found_and_visited_where_the_picture_was_taken(mission: Mission) -> None:
    """Seen from a vehicle that flies at 3 m/s: without the picture's time it would be 2.4 m off."""
    person = (15.5, 30.0)
    flight = Camera(mission, [(12.0, person)])
    flight.until_reported(SymbolMoved)
    (found,) = flight.of(SymbolMoved)
    assert (found.place, found.source) == ("Person", "EVENT[person]")
    assert horizontal_distance(found.position, person) < 0.4
    assert found.position[2] == mission.places["Person"].position[2]
    assert 12.0 + LATE_S <= flight.now_s < 12.0 + LATE_S + 0.2
    assert flight.of(MissionEventChanged, event="personSeen", holds=True)
    flight.until_reported(PlaceReached, place="Person")
    assert flight.gap_m(person) < 0.7
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()
    assert not flight.of(ReportRefused)
    assert len(flight.of(PlanReplaced)) == 1


def test_what_is_seen_elsewhere_moves_the_place_but_no_flight_to_it(mission: Mission) -> None:
    """The person walks while the vehicle is under way, and again while it waits there."""
    first, second = (15.5, 30.0), (20.0, 30.0)
    flight = Camera(mission, [(8.0, first)])
    flight.until_reported(MissionEventChanged)
    flight.persons.append((flight.now_s, second))
    flight.until_reported(PlaceReached, place="Person")
    assert flight.gap_m(first) < 0.7
    assert len(flight.of(SymbolMoved)) == 1
    flight.run(1.0)
    assert len(flight.of(SymbolMoved)) == 2
    assert horizontal_distance(flight.of(SymbolMoved)[1].position, second) < 0.4
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()


@pytest.mark.parametrize(
    ("where", "why"),
    [
        ((15.0, 20.0), "too near to a wall, a zone or the fence"),
        ((15.0, 50.0), "outside the region of Person"),
    ],
    ids=["in the pond", "outside the fence"],
)
def test_where_the_vehicle_may_not_be_nobody_is_found(
    mission: Mission, where: NorthEast, why: str
) -> None:
    flight = Camera(mission, [(8.0, where)]).run_for(12.0)
    (first, *more) = flight.of(ReportRefused)
    assert why in first.text
    assert len(more) < 10
    assert not flight.of(SymbolMoved) and not flight.of(MissionEventChanged)


@pytest.mark.long
def test_a_companion_that_was_cut_off_knows_where_the_person_is(mission: Mission) -> None:
    """Killed on the way there, and the camera with it."""
    person = (15.5, 30.0)
    flight = Camera(mission, [(8.0, person)])
    flight.until_reported(MissionEventChanged)
    flight.run(1.0)
    flight.persons.clear()
    flight.kill()
    flight.run(3.0)
    flight.restart()
    flight.until_reported(ControlTakenBack)
    flight.until_reported(PlaceReached, place="Person")
    assert flight.gap_m(person) < 0.7
    assert [type(e) for _, e in flight.journal.entries].count(PlaceFound) == 1
    flight.until_reported(SkillCompleted, action="drop")
