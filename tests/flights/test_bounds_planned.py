"""Flights of plans that keep bounds for ever: in wind, slower than planned, with an alarm, anew."""

from __future__ import annotations

from copy import deepcopy
from itertools import pairwise
from typing import Any

import pytest
from lockstep import COMPANION, Lockstep
from meadow import DATA

from companion.flight_events.event import FlightEvent
from companion.flight_events.plans import NoPlanFound, PlanReplaced
from companion.flight_events.skills import PlaceReached
from companion.flight_events.word import ConjunctViolated
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.record.audit import ConjunctOutcome, audit
from companion.record.events import record_of

PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
USER_1, USER_2 = dialect.MAV_CMD_USER_1, dialect.MAV_CMD_USER_2
PLACES = {"A": (10, 0), "B": (25, 10), "C": (25, -10), "X": (0, 12)}
TASK = {
    "patrol": "patrolling(A, B, C)",
    "often": "revisit(A) <= 20 s",
    "answer": "G (alarm -> F[<=30s] at(X))",
}
"""Each way over A takes 13 s, to B and to C together more than A can wait."""


def told(flight: Lockstep, kind: type[FlightEvent]) -> list[FlightEvent]:
    """What was recorded of some kind."""
    return [each.event for each in flight.recorded if isinstance(each.event, kind)]


def reached(flight: Lockstep, place: str) -> list[float]:
    """When a place was reached."""
    events = ((s.time_s, s.event) for s in flight.recorded)
    return [t for t, e in events if isinstance(e, PlaceReached) and e.place == place]


def watch(scenario: dict[str, Any] | None = None, **keys: Any) -> Lockstep:
    data = deepcopy(DATA) | {"task": TASK} | keys
    height = data["places"]["A"]["up_m"]
    for name, (east_m, north_m) in PLACES.items():
        data["places"][name] = {"east_m": east_m, "north_m": north_m, "up_m": height}
    data["sets"] = {"Place": ["Home", *PLACES]}
    data["events"] = {
        "alarm": {"when": "COMMAND.MAV_CMD_USER_1", "until": "COMMAND.MAV_CMD_USER_2"}
    }
    data["limits"] = {
        "speed_mps": 4,
        "up_m": [1, 10],
        "fence": [[-15, -25], [40, -25], [40, 25], [-15, 25]],
    }
    mission = load_mission(data)
    return Lockstep(mission, world_of(mission, scenario), has_station=True)


def gaps(times_s: list[float]) -> list[float]:
    return [after - before for before, after in pairwise(times_s)]


def test_an_alarm_is_answered_in_time_for_as_long_as_it_lasts_and_sites_are_visited_often() -> None:
    """The lap goes by A between B and C, and, while there is an alarm, by X as well."""
    gusts = {"version": 1, "wind": {"east_mps": -4, "turbulence_mps": 0.5}}
    flight = watch(gusts).until_reported(PlaceReached, place="B").run_for(1.0)
    flight.station_commands(USER_1, component=COMPANION)
    asked_s = flight.now_s
    flight.run_for(45.0).station_commands(USER_2, component=COMPANION)
    flight.run_for(25.0)
    assert not told(flight, ConjunctViolated) and not told(flight, NoPlanFound)
    assert len(told(flight, PlanReplaced)) >= 2
    assert max(gaps(reached(flight, "A"))) <= 20.0
    assert reached(flight, "X")[0] <= asked_s + 30.0
    assert max(gaps([*reached(flight, "X"), asked_s + 45.0])) <= 30.0
    assert reached(flight, "B")[1:] and reached(flight, "C")[1:]
    found = audit(record_of(flight.recorded))
    assert not found.differs
    assert all(each.outcome is not ConjunctOutcome.VIOLATED for each in found.findings)


@pytest.mark.long
def test_a_pause_uses_up_the_time_for_a_detour() -> None:
    """It has just left A for B. After the pause there is time for A alone, and for B after that."""
    flight = watch().until_reported(PlaceReached, place="A").run_for(1.0)
    flight.station_commands(PAUSE, 0.0, component=COMPANION)
    flight.run_for(7.0).station_commands(PAUSE, 1.0, component=COMPANION)
    flight.run_for(25.0)
    assert not told(flight, ConjunctViolated) and not told(flight, NoPlanFound)
    first, again, *_ = reached(flight, "A")
    assert again - first <= 20.0
    assert reached(flight, "B")[0] > again


@pytest.mark.long
def test_what_takes_longer_than_planned_leaves_the_rest_of_the_lap_for_later() -> None:
    """A look takes 8 s, and not the second that the mission says: with B and C the lap is late.

    The better plan begins with that look, too, so it does not interrupt it.
    """
    skills = deepcopy(DATA["skills"])
    skills["move"]["effect"] += " & !looked(from)"
    about = {"parameters": {"site": "Place"}, "precondition": "at(site)", "cost": 1}
    skills["look"] = about | {"effect": "looked(site)", "execute": "wait(8)"}
    often = {"often": "revisit(A) <= 28 s", "b": "G F looked(B)", "c": "G F looked(C)"}
    flight = watch(None, skills=skills, task=often).run_for(100.0)
    assert not told(flight, ConjunctViolated) and not told(flight, NoPlanFound)
    first = next(e for e in told(flight, PlanReplaced) if isinstance(e, PlanReplaced))
    assert first.reason.startswith("often: revisit(A) <= 28 s is late by ")
    assert first.reason.endswith((" after move(B, A)", " after move(C, A)"))  # laps of one length
    assert max(gaps(reached(flight, "A"))) <= 28.0
    visits = sorted(len(reached(flight, site)) for site in "BC")
    assert visits[0] >= 2 and visits[1] >= 3
