"""A companion that hosts sorties, and what an operator is told."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from lockstep import COMPANION, VEHICLE
from operated import (
    ACCEPTED,
    DENIED,
    NOT_NOW,
    PAUSE,
    RETURN,
    START,
    UNSUPPORTED,
    Operated,
    on_the_way_to_b,
)

from companion.flight_events.event import Stamped
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import PlanMade, PlanReplaced
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    AutopilotSaid,
    Phase,
    PhaseEntered,
    ReturnedAsAsked,
    SetpointRefused,
    TaskSatisfied,
)
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.tick import TICK_S
from sitl.link.routing import LinkName

# -- hosting ---------------------------------------------------------------------------------------


def test_nothing_flies_before_the_operator_says_so(hosted: Operated) -> None:
    hosted.run(10.0)
    assert hosted.commands == [] and hosted.setpoints == []
    assert hosted.statuses == [dialect.MAV_STATE_STANDBY]
    assert hosted.ask(PAUSE, 0) == NOT_NOW
    assert hosted.ask(RETURN) == NOT_NOW


@pytest.mark.long
def test_each_start_is_a_run_of_its_own(hosted: Operated) -> None:
    """The second one is called home; the map's frame stays where it was."""
    hosted.run(2.0)
    hosted.start_by_operator()
    assert hosted.ask(START) == ACCEPTED  # the same one
    hosted.until(lambda: hosted.companion._run is None)
    hosted.run(2.0)
    hosted.start_by_operator()
    hosted.until_reported(PhaseEntered, phase=Phase.TASK).run(2.0)
    assert hosted.ask(START) == NOT_NOW
    assert hosted.ask(RETURN) == ACCEPTED
    hosted.until(lambda: hosted.companion._run is None).run(0.2)
    (begun, ended), (begun_again, ended_again) = (first_and_last(run) for run in hosted.runs)
    assert (ended.event, ended_again.event) == (TaskSatisfied(), ReturnedAsAsked())
    assert begun_again.time_s < 1.0  # since this run began
    assert isinstance(begun.event, PlanMade) and begun.event == begun_again.event
    assert hosted.armings == 2
    standby, active = dialect.MAV_STATE_STANDBY, dialect.MAV_STATE_ACTIVE
    assert hosted.statuses == [standby, active, standby, active, standby]
    hosted.companion.stop()
    hosted.until_the_end()


def first_and_last(run: list[Stamped]) -> tuple[Stamped, Stamped]:
    """But for events of the mission."""
    told = [stamped for stamped in run if not isinstance(stamped.event, MissionEventChanged)]
    return told[0], told[-1]


def test_an_armed_vehicle_is_not_started(hosted: Operated) -> None:
    hosted.run(2.0)
    hosted.station_commands(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
    hosted.run(0.5)
    assert hosted.ask(START) == NOT_NOW
    hosted.run(1.0)
    assert hosted.told[-1] == ("refused: the vehicle is armed or flying already; it is left alone")


# -- what is told ----------------------------------------------------------------------------------


def test_ground_stations_hear_what_the_console_says(operated: Operated) -> None:
    operated.until_the_end()
    operated.tick()
    operated.tick()
    marks = [text for text in operated.told if text.startswith("run ")]
    assert len(marks) == 1  # for the autopilot's log
    told = [text.removesuffix("...") for text in operated.told if text not in marks]
    texts = [e.text for e in operated.events if not isinstance(e, AutopilotSaid)]  # its own words
    reported = ["; ".join(map(str.strip, text.splitlines())) for text in texts]
    assert len(told) == len(reported)
    assert all(whole.startswith(text) for whole, text in zip(reported, told, strict=True))
    times = [s.time_s for s in operated.heard if s.message.get_type() == "STATUSTEXT"]
    burst = max(sum(t <= u < t + 1.0 for u in times) for t in times[:-5])
    assert burst <= 10


def test_five_ground_stations_each_get_their_own_answers(operated: Operated) -> None:
    """Four ask at once and one has stopped; nobody waits for another."""
    operated.run(3.0)
    numbers = [RETURN, PAUSE, 31014, dialect.MAV_CMD_DO_SET_MISSION_CURRENT]
    stations = [MavlinkCodec(250 - i, 190) for i in range(5)]
    for station, number in zip(stations, numbers, strict=False):
        message = dialect.MAVLink_command_long_message(VEHICLE, COMPANION, number, 0, *[0] * 7)
        operated._to_vehicle.append((LinkName.GCS, station.pack(message)))
    before = len(operated.heard)
    operated.run(0.3)
    answers = [
        (m.target_system, m.target_component, m.command, m.result)
        for _, m in operated.heard[before:]
        if m.get_type() == "COMMAND_ACK"
    ]
    results = [NOT_NOW, NOT_NOW, UNSUPPORTED, DENIED]
    expected = zip(range(250, 246, -1), [190] * 4, numbers, results, strict=True)
    assert sorted(answers) == sorted(expected)


@pytest.mark.long
def test_a_speed_limit_that_was_set_in_flight_is_kept(operated: Operated) -> None:
    operated.until_reported(PlaceReached, place="A").run(0.2)
    slow = dialect.MAVLink_param_set_message(VEHICLE, COMPANION, b"CMP_SPEED_MAX", 0.8, 9)
    operated.station_says(slow)
    operated.until_reported(PlaceReached, place="r1")
    since_s = operated.now_s
    operated.until_reported(PlaceReached, place="r2")
    speeds = [
        math.hypot(s.message.vx, s.message.vy) for s in operated.setpoints if s.time_s > since_s
    ]
    assert 0.75 < max(speeds) <= 0.8 * 1.001


def test_a_speed_limit_in_flight_slows_the_flight_under_way_and_nothing_is_refused(
    operated: Operated,
) -> None:
    """Costs of plans, trajectories and the gate follow one limit; the gate never stops a flight."""
    on_the_way_to_b(operated)
    run = operated.companion._run
    assert run is not None
    planner, vehicle = run.executive.planner, run.vehicle
    before = {action.name: action.cost_ms for action in planner.actions.model.actions}
    since_s = operated.now_s
    slow = dialect.MAVLink_param_set_message(VEHICLE, COMPANION, b"CMP_SPEED_MAX", 0.5, 9)
    operated.station_says(slow)
    operated.run(1.5)
    slowed = speeds_since(operated, since_s)
    assert slowed[0] > 1.89  # the flight under way was at full speed
    assert max(a - b for a, b in pairwise(slowed)) <= 4.0 * TICK_S + 1e-6
    assert max(speeds_since(operated, since_s + 1.0)) <= 0.5 * 1.001
    assert vehicle.setpoints._envelope.speed_mps == 0.5
    assert (
        math.hypot(*operated.simulation.flight.velocity) < 0.8
    )  # it overshoots, and there is wind
    operated.until_reported(PlanReplaced)
    after = {action.name: action.cost_ms for action in planner.actions.model.actions}
    flown = [name for name in before if name.startswith("move(")]
    assert flown and all(after[name] > 2.0 * before[name] for name in flown)
    fast = dialect.MAVLink_param_set_message(VEHICLE, COMPANION, b"CMP_SPEED_MAX", 50.0, 9)
    operated.station_says(fast)
    since_s = operated.now_s
    operated.until_the_end()
    assert 1.9 < max(speeds_since(operated, since_s)) <= 2.0 * 1.001
    assert operated.of(SetpointRefused) == []


def speeds_since(operated: Operated, since_s: float) -> list[float]:
    """Of the setpoints that have left."""
    sent = [s.message for s in operated.setpoints if s.time_s > since_s]
    return [math.hypot(m.vx, m.vy, m.vz) for m in sent]
