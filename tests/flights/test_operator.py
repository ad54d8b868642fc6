"""What an operator at a ground station can do with the companion, in lockstep with the simulator.

The ground station is on the vehicle's other link; what it says and hears passes the simulated
autopilot's routing. Positions are the simulator's truth.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from operated import ACCEPTED, DENIED, NOT_NOW, PAUSE, RETURN, START, Operated, on_the_way_to_b

from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import PlanReplaced
from companion.flight_events.sortie import (
    ControlYielded,
    Phase,
    PhaseEntered,
    ReturnedAsAsked,
    RunFailed,
    TaskSatisfied,
)
from companion.geometry import distance, horizontal_distance
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
LAND = dialect.MAV_CMD_NAV_LAND


# -- pause and go on -------------------------------------------------------------------------------


def test_a_pause_holds_within_a_second_and_the_task_goes_on_to_its_end(operated: Operated) -> None:
    on_the_way_to_b(operated)
    assert operated.ask(PAUSE, 0) == ACCEPTED
    assert operated.events[-1] == PhaseEntered(Phase.PAUSED)
    operated.run(1.0)
    held = operated.simulation.flight.position
    before = len(operated.reports)
    for _ in range(200):
        operated.tick()
        assert distance(operated.simulation.flight.position, held) < 0.5
    assert operated.events[before:] == []
    assert operated.simulation.mode == "OFFBOARD"
    assert operated.ask(PAUSE, 1) == ACCEPTED
    operated.until_the_end()
    resumed, replaced = operated.events[before : before + 2]
    assert resumed == PhaseEntered(Phase.TASK)
    assert isinstance(replaced, PlanReplaced)
    assert (replaced.number, replaced.reason) == (1, "going on")
    assert replaced.plan.prefix[0].action.startswith("move(here, ")
    assert operated.ending == TaskSatisfied()
    assert operated.simulation.collisions == 0


@pytest.mark.long
def test_both_may_be_said_twice(operated: Operated) -> None:
    on_the_way_to_b(operated)
    assert [operated.ask(PAUSE, 0), operated.ask(PAUSE, 0)] == [ACCEPTED, ACCEPTED]
    assert len(operated.of(PhaseEntered, phase=Phase.PAUSED)) == 1
    assert [operated.ask(PAUSE, 1), operated.ask(PAUSE, 1)] == [ACCEPTED, ACCEPTED]
    assert len(operated.of(PlanReplaced)) == 1


@pytest.mark.long
def test_many_pauses_do_not_count_as_plans_that_lead_nowhere(operated: Operated) -> None:
    on_the_way_to_b(operated)
    for _ in range(8):
        assert operated.ask(PAUSE, 0) == ACCEPTED
        assert operated.ask(PAUSE, 1) == ACCEPTED
    operated.until_the_end()
    assert operated.exit_code == 0


def test_a_pause_is_refused_with_a_reason_while_it_takes_off(operated: Operated) -> None:
    operated.until_reported(PhaseEntered, phase=Phase.TAKE_OFF)
    assert operated.ask(PAUSE, 0) == NOT_NOW
    assert operated.ask(PAUSE, 0.5) == DENIED
    operated.run(1.0)
    assert "refused: no pause while taking off" in operated.told


@pytest.mark.long
def test_an_event_during_a_pause_is_not_lost(operated: Operated) -> None:
    """The target is seen on the way to B, where the vehicle is paused."""
    operated.until_reported(MissionEventChanged, event="targetFound")
    assert operated.ask(PAUSE, 0) == ACCEPTED
    operated.run(3.0)
    assert operated.ask(PAUSE, 1) == ACCEPTED
    operated.until_the_end()
    assert operated.ending == TaskSatisfied()


# -- home ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("is_paused", [False, pytest.param(True, marks=pytest.mark.long)])
def test_a_return_flies_home_and_lands(operated: Operated, is_paused: bool) -> None:
    on_the_way_to_b(operated)
    if is_paused:
        assert operated.ask(PAUSE, 0) == ACCEPTED
    assert operated.ask(RETURN) == ACCEPTED
    operated.until_the_end()
    assert operated.events[-3:] == [
        PhaseEntered(Phase.RETURNING),
        PhaseEntered(Phase.LANDING),
        ReturnedAsAsked(),
    ]
    assert not operated.simulation.is_armed
    assert horizontal_distance(operated.simulation.flight.position, (0.0, 0.0, 0.0)) < 0.5
    assert operated.simulation.collisions == 0


@pytest.mark.long
def test_a_return_may_be_paused(operated: Operated) -> None:
    on_the_way_to_b(operated)
    assert operated.ask(RETURN) == ACCEPTED
    operated.run(1.0)
    assert operated.ask(PAUSE, 0) == ACCEPTED
    operated.run(3.0)
    assert math.hypot(*operated.simulation.flight.velocity) < 0.2
    assert operated.ask(PAUSE, 1) == ACCEPTED
    operated.until_the_end()
    assert operated.ending == ReturnedAsAsked()


def test_a_mission_with_an_event_for_it_decides_itself() -> None:
    path = MISSIONS / "return_home.yaml"
    flight = Operated(load_mission(path), read_scenario(path.with_suffix(".sim.yaml")))
    flight.until(lambda: flight.places != [])
    assert flight.ask(PAUSE, 0) == ACCEPTED
    assert flight.ask(RETURN) == ACCEPTED
    flight.until_the_end()
    assert PhaseEntered(Phase.RETURNING) not in flight.events
    assert flight.ending == TaskSatisfied()


# -- the pilot -------------------------------------------------------------------------------------


def test_control_comes_back_only_when_both_say_so(hosted: Operated) -> None:
    on_the_way_to_b(hosted.start_by_operator())
    hosted.station_chooses("AUTO.RTL")
    hosted.run(1.0)
    taken = len(hosted.setpoints), len(hosted.commands)
    assert hosted.events[-1] == ControlYielded("the pilot has control, in AUTO.RTL")
    assert hosted.statuses[-1] == dialect.MAV_STATE_CRITICAL
    assert hosted.ask(START) == NOT_NOW
    assert hosted.ask(PAUSE, 1) == NOT_NOW  # the operator alone
    hosted.station_chooses("AUTO.LOITER")
    hosted.run(5.0)  # the pilot alone
    assert "refused: AUTO.RTL is flown; the pilot hands over by choosing hold" in hosted.told
    assert (len(hosted.setpoints), len(hosted.commands)) == taken
    assert hosted.ask(PAUSE, 1) == ACCEPTED
    hosted.until(lambda: hosted.simulation.mode == "OFFBOARD", 10.0)
    hosted.until(lambda: hosted.companion._run is None)
    hosted.run(0.2)
    assert hosted.ending == TaskSatisfied()
    assert hosted.statuses[-2:] == [dialect.MAV_STATE_ACTIVE, dialect.MAV_STATE_STANDBY]


def test_a_vehicle_that_the_pilot_lands_is_not_flown_on(hosted: Operated) -> None:
    on_the_way_to_b(hosted.start_by_operator())
    hosted.station_chooses("AUTO.LAND")
    hosted.until(lambda: hosted.companion._run is None)
    assert hosted.exit_code == 5
    assert hosted.statuses[-1] == dialect.MAV_STATE_CRITICAL
    assert hosted.ask(PAUSE, 1) == NOT_NOW
    assert not hosted.simulation.is_armed
    assert LAND not in {said.message.command for said in hosted.commands}


def test_a_stop_leaves_the_vehicle_to_the_pilot(hosted: Operated) -> None:
    on_the_way_to_b(hosted.start_by_operator())
    hosted.station_chooses("AUTO.RTL")
    hosted.run(1.0)
    commands = len(hosted.commands)
    hosted.companion.stop()
    hosted.until_the_end()
    assert len(hosted.commands) == commands
    assert hosted.simulation.mode == "AUTO.RTL"


def test_without_a_host_a_takeover_ends_the_run(operated: Operated) -> None:
    on_the_way_to_b(operated)
    operated.station_chooses("AUTO.RTL")
    operated.until_the_end()
    assert operated.ending == RunFailed("the pilot has control, in AUTO.RTL", 5)
