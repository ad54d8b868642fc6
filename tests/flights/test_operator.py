"""What an operator at a ground station can do with the companion, in lockstep with the simulator.

The ground station is on the vehicle's other link; what it says and hears passes the simulated
autopilot's routing. Positions are the simulator's truth.
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from lockstep import COMPANION, VEHICLE, Lockstep, World
from preparations import Polled

from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import PlanMade, PlanReplaced
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    AutopilotSaid,
    ControlYielded,
    Phase,
    PhaseEntered,
    ReturnedAsAsked,
    RunEnded,
    RunFailed,
    SetpointRefused,
    TaskSatisfied,
)
from companion.geometry import distance, horizontal_distance
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.hosted_runs import HostedRuns
from companion.tick import TICK_S
from sitl.link.routing import LinkName
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
START = dialect.MAV_CMD_MISSION_START
PAUSE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
RETURN = dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH
LAND = dialect.MAV_CMD_NAV_LAND
ACCEPTED, NOT_NOW = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_TEMPORARILY_REJECTED
DENIED, UNSUPPORTED = dialect.MAV_RESULT_DENIED, dialect.MAV_RESULT_UNSUPPORTED


class Operated(Lockstep):
    """A flight with an operator, who knows the companion alone.

    With `is_hosted` it is also the companion's host: every run records into it.
    """

    def __init__(self, mission: Mission, world: World, is_hosted: bool = False) -> None:
        super().__init__(mission, world, has_station=True)
        self.uploads = None
        self.runs: list[list[Stamped]] = []
        if is_hosted:
            self.companion = Companion(HostedRuns(self, mission))

    def load(self, path: Path) -> Mission:
        return load_mission(path)

    def prepare(
        self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None
    ) -> Polled:
        return Polled(mission, speed_max_mps)

    def begin_run(self, mission: Mission) -> Recorder:
        self.reports = []
        self.runs.append(self.reports)
        return self

    def end_run(self, recorder: Recorder) -> None:
        assert isinstance(self.reports[-1].event, RunEnded)

    def tell(self, stamped: Stamped) -> None:
        self.reports.append(stamped)

    def ask(self, command: int, *parameters: float) -> int:
        """Sends a command to the companion; its answer, which comes in time."""
        before, asked_s = len(self.heard), self.now_s
        self.station_commands(command, *parameters, component=COMPANION)

        def answers() -> list[Any]:
            return [
                said
                for said in self.heard[before:]
                if said.message.get_type() == "COMMAND_ACK" and said.message.command == command
            ]

        self.until(lambda: bool(answers()), limit_s=1.2)
        (answer,) = answers()
        assert (answer.message.target_system, answer.message.target_component) == (255, 190)
        assert answer.time_s - asked_s < 1.2
        return int(answer.message.result)

    @property
    def told(self) -> list[str]:
        """The companion's STATUSTEXTs as a ground station puts them together."""
        texts: dict[int, str] = {}
        for at, said in enumerate(s for s in self.heard if s.message.get_type() == "STATUSTEXT"):
            key = said.message.id or -1 - at
            texts[key] = texts.get(key, "") + said.message.text
        return list(texts.values())

    @property
    def statuses(self) -> list[int]:
        """What the companion's heartbeats said, each change once."""
        beats = [s.message for s in self.heard if s.message.get_type() == "HEARTBEAT"]
        told = [beat.system_status for beat in beats]
        return [now for i, now in enumerate(told) if i == 0 or told[i - 1] != now]

    def start_by_operator(self) -> Operated:
        """The vehicle is known, and the operator starts the mission."""
        self.until(lambda: self.companion.telemetry.state is not None, 10.0)
        assert self.ask(START) == ACCEPTED
        return self


@pytest.fixture
def flight(surveillance: Mission, short_hall: World) -> Operated:
    """The mission of today: it is flown at once, and the program ends with it."""
    return Operated(surveillance, short_hall)


@pytest.fixture
def hosted(surveillance: Mission, short_hall: World) -> Operated:
    return Operated(surveillance, short_hall, is_hosted=True)


def on_the_way_to_b(flight: Operated) -> Operated:
    """In the middle of the task, at full speed."""
    flight.until_reported(PlaceReached, place="A").run(2.0)
    assert math.hypot(*flight.simulation.flight.velocity) > 1.0
    return flight


# -- pause and go on -------------------------------------------------------------------------------


def test_a_pause_holds_within_a_second_and_the_task_goes_on_to_its_end(flight: Operated) -> None:
    on_the_way_to_b(flight)
    assert flight.ask(PAUSE, 0) == ACCEPTED
    assert flight.events[-1] == PhaseEntered(Phase.PAUSED)
    flight.run(1.0)
    held = flight.simulation.flight.position
    before = len(flight.reports)
    for _ in range(200):
        flight.tick()
        assert distance(flight.simulation.flight.position, held) < 0.5
    assert flight.events[before:] == []
    assert flight.simulation.mode == "OFFBOARD"
    assert flight.ask(PAUSE, 1) == ACCEPTED
    flight.until_the_end()
    resumed, replaced = flight.events[before : before + 2]
    assert resumed == PhaseEntered(Phase.TASK)
    assert isinstance(replaced, PlanReplaced)
    assert (replaced.number, replaced.reason) == (1, "going on")
    assert replaced.plan.prefix[0].action.startswith("move(here, ")
    assert flight.ending == TaskSatisfied()
    assert flight.simulation.collisions == 0


def test_both_may_be_said_twice(flight: Operated) -> None:
    on_the_way_to_b(flight)
    assert [flight.ask(PAUSE, 0), flight.ask(PAUSE, 0)] == [ACCEPTED, ACCEPTED]
    assert len(flight.of(PhaseEntered, phase=Phase.PAUSED)) == 1
    assert [flight.ask(PAUSE, 1), flight.ask(PAUSE, 1)] == [ACCEPTED, ACCEPTED]
    assert len(flight.of(PlanReplaced)) == 1


def test_many_pauses_do_not_count_as_plans_that_lead_nowhere(flight: Operated) -> None:
    on_the_way_to_b(flight)
    for _ in range(8):
        assert flight.ask(PAUSE, 0) == ACCEPTED
        assert flight.ask(PAUSE, 1) == ACCEPTED
    flight.until_the_end()
    assert flight.exit_code == 0


def test_a_pause_is_refused_with_a_reason_while_it_takes_off(flight: Operated) -> None:
    flight.until_reported(PhaseEntered, phase=Phase.TAKE_OFF)
    assert flight.ask(PAUSE, 0) == NOT_NOW
    assert flight.ask(PAUSE, 0.5) == DENIED
    flight.run(1.0)
    assert "refused: no pause while taking off" in flight.told


def test_an_event_during_a_pause_is_not_lost(flight: Operated) -> None:
    """The target is seen on the way to B, where the vehicle is paused."""
    flight.until_reported(MissionEventChanged, event="targetFound")
    assert flight.ask(PAUSE, 0) == ACCEPTED
    flight.run(3.0)
    assert flight.ask(PAUSE, 1) == ACCEPTED
    flight.until_the_end()
    assert flight.ending == TaskSatisfied()


# -- home ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("is_paused", [False, True])
def test_a_return_flies_home_and_lands(flight: Operated, is_paused: bool) -> None:
    on_the_way_to_b(flight)
    if is_paused:
        assert flight.ask(PAUSE, 0) == ACCEPTED
    assert flight.ask(RETURN) == ACCEPTED
    flight.until_the_end()
    assert flight.events[-3:] == [
        PhaseEntered(Phase.RETURNING),
        PhaseEntered(Phase.LANDING),
        ReturnedAsAsked(),
    ]
    assert not flight.simulation.is_armed
    assert horizontal_distance(flight.simulation.flight.position, (0.0, 0.0, 0.0)) < 0.5
    assert flight.simulation.collisions == 0


def test_a_return_may_be_paused(flight: Operated) -> None:
    on_the_way_to_b(flight)
    assert flight.ask(RETURN) == ACCEPTED
    flight.run(1.0)
    assert flight.ask(PAUSE, 0) == ACCEPTED
    flight.run(3.0)
    assert math.hypot(*flight.simulation.flight.velocity) < 0.2
    assert flight.ask(PAUSE, 1) == ACCEPTED
    flight.until_the_end()
    assert flight.ending == ReturnedAsAsked()


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


def test_without_a_host_a_takeover_ends_the_run(flight: Operated) -> None:
    on_the_way_to_b(flight)
    flight.station_chooses("AUTO.RTL")
    flight.until_the_end()
    assert flight.ending == RunFailed("the pilot has control, in AUTO.RTL", 5)


# -- hosting ---------------------------------------------------------------------------------------


def test_nothing_flies_before_the_operator_says_so(hosted: Operated) -> None:
    hosted.run(10.0)
    assert hosted.commands == [] and hosted.setpoints == []
    assert hosted.statuses == [dialect.MAV_STATE_STANDBY]
    assert hosted.ask(PAUSE, 0) == NOT_NOW
    assert hosted.ask(RETURN) == NOT_NOW


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


def test_ground_stations_hear_what_the_console_says(flight: Operated) -> None:
    flight.until_the_end()
    flight.tick()
    flight.tick()
    marks = [text for text in flight.told if text.startswith("run ")]
    assert len(marks) == 1  # for the autopilot's log
    told = [text.removesuffix("...") for text in flight.told if text not in marks]
    texts = [e.text for e in flight.events if not isinstance(e, AutopilotSaid)]  # its own words
    reported = ["; ".join(map(str.strip, text.splitlines())) for text in texts]
    assert len(told) == len(reported)
    assert all(whole.startswith(text) for whole, text in zip(reported, told, strict=True))
    times = [s.time_s for s in flight.heard if s.message.get_type() == "STATUSTEXT"]
    burst = max(sum(t <= u < t + 1.0 for u in times) for t in times[:-5])
    assert burst <= 10


def test_five_ground_stations_each_get_their_own_answers(flight: Operated) -> None:
    """Four ask at once and one has stopped; nobody waits for another."""
    flight.run(3.0)
    numbers = [RETURN, PAUSE, 31014, dialect.MAV_CMD_DO_SET_MISSION_CURRENT]
    stations = [MavlinkCodec(250 - i, 190) for i in range(5)]
    for station, number in zip(stations, numbers, strict=False):
        message = dialect.MAVLink_command_long_message(VEHICLE, COMPANION, number, 0, *[0] * 7)
        flight._to_vehicle.append((LinkName.GCS, station.pack(message)))
    before = len(flight.heard)
    flight.run(0.3)
    answers = [
        (m.target_system, m.target_component, m.command, m.result)
        for _, m in flight.heard[before:]
        if m.get_type() == "COMMAND_ACK"
    ]
    results = [NOT_NOW, NOT_NOW, UNSUPPORTED, DENIED]
    expected = zip(range(250, 246, -1), [190] * 4, numbers, results, strict=True)
    assert sorted(answers) == sorted(expected)


def test_a_speed_limit_that_was_set_in_flight_is_kept(flight: Operated) -> None:
    flight.until_reported(PlaceReached, place="A").run(0.2)
    slow = dialect.MAVLink_param_set_message(VEHICLE, COMPANION, b"CMP_SPEED_MAX", 0.8, 9)
    flight.station_says(slow)
    flight.until_reported(PlaceReached, place="r1")
    since_s = flight.now_s
    flight.until_reported(PlaceReached, place="r2")
    speeds = [
        math.hypot(s.message.vx, s.message.vy) for s in flight.setpoints if s.time_s > since_s
    ]
    assert 0.75 < max(speeds) <= 0.8 * 1.001


def test_a_speed_limit_in_flight_slows_the_flight_under_way_and_nothing_is_refused(
    flight: Operated,
) -> None:
    """Costs of plans, trajectories and the gate follow one limit; the gate never stops a flight."""
    on_the_way_to_b(flight)
    run = flight.companion._run
    assert run is not None
    planner, vehicle = run.sortie._executive.planner, run.vehicle
    before = {action.name: action.cost_ms for action in planner.model.actions}
    since_s = flight.now_s
    slow = dialect.MAVLink_param_set_message(VEHICLE, COMPANION, b"CMP_SPEED_MAX", 0.5, 9)
    flight.station_says(slow)
    flight.run(1.5)
    slowed = speeds_since(flight, since_s)
    assert slowed[0] > 1.89  # the flight under way was at full speed
    assert max(a - b for a, b in pairwise(slowed)) <= 4.0 * TICK_S + 1e-6
    assert max(speeds_since(flight, since_s + 1.0)) <= 0.5 * 1.001
    assert vehicle._stream._envelope.speed_mps == 0.5
    assert math.hypot(*flight.simulation.flight.velocity) < 0.8  # it overshoots, and there is wind
    flight.until_reported(PlanReplaced)
    after = {action.name: action.cost_ms for action in planner.model.actions}
    flown = [name for name in before if name.startswith("move(")]
    assert flown and all(after[name] > 2.0 * before[name] for name in flown)
    fast = dialect.MAVLink_param_set_message(VEHICLE, COMPANION, b"CMP_SPEED_MAX", 50.0, 9)
    flight.station_says(fast)
    since_s = flight.now_s
    flight.until_the_end()
    assert 1.9 < max(speeds_since(flight, since_s)) <= 2.0 * 1.001
    assert flight.of(SetpointRefused) == []


def speeds_since(flight: Operated, since_s: float) -> list[float]:
    """Of the setpoints that have left."""
    sent = [s.message for s in flight.setpoints if s.time_s > since_s]
    return [math.hypot(m.vx, m.vy, m.vz) for m in sent]
