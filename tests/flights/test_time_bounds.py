"""Flights in which a bound in time is kept, or passes: what is told, when, and by whom."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import pytest
from lockstep import COMPANION, Lockstep
from meadow import DATA

from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import LineTakenUp, NoPlanFound
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.record.audit import Audit, ConjunctOutcome, audit
from companion.record.events import record_of

PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
USER = dialect.MAV_CMD_USER_1
ROUND = [{"repeat": ["move(*, A)", "move(A, Home)"], "times": 3}]
"""Back and forth, 7.4 s each way."""


def by_hand(task: dict[str, Any], **keys: Any) -> Lockstep:
    """A meadow with A 20 m east of Home, and a tree that flies there and back three times."""
    data = deepcopy(DATA) | {"task": task, "tree": ROUND} | keys
    return begun(data)


def planned(task: dict[str, Any], **keys: Any) -> Lockstep:
    """The same meadow, with a plan."""
    return begun(deepcopy(DATA) | {"task": task} | keys)


def begun(data: dict[str, Any]) -> Lockstep:
    fence = [[-15, -15], [35, -15], [35, 15], [-15, 15]]
    data["limits"] = {"speed_mps": 4, "up_m": [1, 10], "fence": fence}
    asked = load_mission(data)
    return Lockstep(asked, world_of(asked, None), has_station=True, resumes=True)


def command(flight: Lockstep, number: int, *parameters: float) -> None:
    flight.station_commands(number, *parameters, component=COMPANION)


def audited(flight: Lockstep) -> Audit:
    found = audit(record_of(flight.recorded))
    assert not found.differs
    return found


def outcome(flight: Lockstep, line: str) -> tuple[ConjunctOutcome, int | None]:
    (finding,) = (f for f in audited(flight).findings if f.name == line)
    return finding.outcome, finding.position


def told(flight: Lockstep) -> list[tuple[str, float, int]]:
    """Violations: the line, when, and the position."""
    stamped = ((s.time_s, s.event) for s in flight.recorded)
    return [(e.conjunct, t, e.position) for t, e in stamped if isinstance(e, ConjunctViolated)]


def begun_s(flight: Lockstep) -> float:
    """When the first position counts as reached."""
    positions = (s.event for s in flight.recorded if isinstance(s.event, PositionLeft))
    return next(positions).reached_s


def test_bounds_that_are_kept_are_told_as_kept() -> None:
    task = {
        "first": "F[<=30s] at(A)",
        "often": "revisit(Home) <= 40 s",
        "answer": "G (at(A) -> F[<=20s] at(Home))",
    }
    flight = by_hand(task).until_the_end()
    assert flight.exit_code == 0 and not told(flight)
    entered = [s.time_s for s in flight.recorded if s.event == PhaseEntered(Phase.TASK)]
    assert begun_s(flight) == pytest.approx(entered[0], abs=0.06)
    assert outcome(flight, "first") == (ConjunctOutcome.FULFILLED, 1)
    assert outcome(flight, "answer")[0] is ConjunctOutcome.SATISFIED


def test_a_bound_that_is_too_tight_is_violated_when_it_passes() -> None:
    flight = by_hand({"first": "F[<=5s] at(A)"}).until_the_end()
    assert flight.exit_code == 3  # the tree is done, and has violated it
    ((line, time_s, position),) = told(flight)
    assert (line, position) == ("first", 0)
    assert begun_s(flight) + 5.0 < time_s <= begun_s(flight) + 5.1
    assert outcome(flight, "first") == (ConjunctOutcome.VIOLATED, 0)
    assert "at A" not in [s.event.text for s in flight.recorded if s.time_s <= time_s]


@pytest.mark.long
def test_clocks_go_on_in_a_pause() -> None:
    flight = by_hand({"often": "revisit(A) <= 40 s"}).until_reported(PlaceReached, place="A")
    reached_s = flight.now_s
    flight.run(3.0)
    command(flight, PAUSE, 0.0)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(45.0)
    ((line, time_s, position),) = told(flight)
    assert (line, position) == ("often", 1)
    assert reached_s + 40.0 < time_s < reached_s + 40.2
    command(flight, PAUSE, 1.0)
    flight.until_the_end()
    assert flight.exit_code == 3
    assert outcome(flight, "often") == (ConjunctOutcome.VIOLATED, 1)


@pytest.mark.long
def test_an_answer_is_due_from_the_alarm_on_and_not_from_where_it_is_read() -> None:
    alarm = {"alarm": {"when": "COMMAND.MAV_CMD_USER_1"}}
    for limit, position in (("9s", 1), ("14s", None)):
        task = {"answer": f"G (alarm -> F[<={limit}] at(A))"}
        flight = by_hand(task, events=alarm).until_reported(PlaceReached, place="A").run_for(4.0)
        command(flight, USER)
        flight.until_reported(MissionEventChanged)
        asked_s = flight.now_s
        flight.until_the_end()
        late = told(flight)
        if position is None:
            assert not late and flight.exit_code == 0
            assert outcome(flight, "answer")[0] is not ConjunctOutcome.VIOLATED
        else:
            ((_, time_s, number),) = late  # Home was reached 7 s before A
            assert asked_s + 9.0 < time_s < asked_s + 9.2
            assert outcome(flight, "answer") == (ConjunctOutcome.VIOLATED, number)


def test_who_is_called_home_breaks_no_bound() -> None:
    flight = by_hand({"often": "revisit(A) <= 20 s"}).until_reported(PlaceReached, place="A")
    flight.run(1.0)
    command(flight, dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    flight.until_the_end()
    assert flight.exit_code == 0 and not told(flight)
    assert outcome(flight, "often")[0] is ConjunctOutcome.OPEN


def test_a_restart_costs_time() -> None:
    task = {"often": "revisit(A) <= 35 s", "home": "G F at(Home)"}
    flight = planned(task).until_reported(PlaceReached, place="A")
    reached_s = flight.now_s
    flight.run(3.0)
    flight.kill()
    flight.run(30.0)
    flight.restart()
    flight.until_reported(ConjunctViolated)
    ((line, time_s, position),) = told(flight)
    assert (line, position) == ("often", 1)
    assert reached_s + 35.0 < time_s < reached_s + 35.2
    flight.until_the_end()
    assert flight.exit_code == 3  # before that there was no plan any more
    assert flight.time_of(NoPlanFound) < time_s


LAP = {"patrol": "patrolling(A, B)", "answer": "G (alarm -> F[<=17s] at(Home))"}
ALARM = {"alarm": {"when": "COMMAND.MAV_CMD_USER_1"}}


def patrol(**keys: Any) -> Lockstep:
    """A and B 20 m from home, 17 m from each other."""
    data = deepcopy(DATA) | {"task": LAP, "events": ALARM} | keys
    data["places"]["B"] = {"east_m": 11, "north_m": 13, "up_m": 3}
    data["sets"] = {"Place": ["Home", "A", "B"]}
    return begun(data)


SECONDS = [k / 2 for k in range(1, 61)]
"""Of two laps."""
TRIED = (9.5,)


@pytest.mark.parametrize(
    "after_s",
    [*TRIED, *(pytest.param(s, marks=pytest.mark.long) for s in SECONDS if s not in TRIED)],
)
def test_an_alarm_at_any_time_is_answered_in_time_where_the_line_is_ready(after_s: float) -> None:
    flight = patrol(ready=["answer"]).until_reported(PhaseEntered, phase=Phase.TASK)
    flight.run_for(after_s)
    command(flight, USER)
    flight.until_reported(MissionEventChanged)
    asked_s = flight.now_s
    flight.until_reported(PlaceReached, place="Home")
    assert flight.now_s - asked_s <= 17.0
    flight.run(12.0)
    assert not told(flight) and not flight.of(NoPlanFound)
    assert outcome(flight, "answer")[0] is ConjunctOutcome.OPEN


def test_a_line_that_may_be_dropped_begins_anew_after_a_pause_that_was_too_long() -> None:
    often = {"formula": "revisit(A) <= 20 s", "priority": 1}
    flight = planned({"patrol": "patrolling(A, Home)", "often": often})
    flight.until_reported(PlaceReached, place="A").run(3.0)
    command(flight, PAUSE, 0.0)
    flight.until_reported(PhaseEntered, phase=Phase.PAUSED).run(25.0)
    command(flight, PAUSE, 1.0)
    flight.run(20.0)
    command(flight, dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    flight.until_the_end()
    assert flight.exit_code == 0 and len(told(flight)) == 1
    assert flight.one(LineTakenUp) == LineTakenUp("often", anew=True)
    (often_found,) = (f for f in audited(flight).findings if f.name == "often")
    assert often_found.outcome is ConjunctOutcome.OPEN and often_found.since == 2
    assert often_found.whole is ConjunctOutcome.VIOLATED
