"""What happens when somebody or something interferes: pilot, operator, payload.

In lockstep, so that every case is the same each time. Frames are counted where they leave the
companion; modes, arming and positions are the simulator's truth.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from interference import Start, aborted, flown_modes, on_the_way_to_b
from lockstep import (
    Cut,
    Deaf,
    Lockstep,
    Said,
    World,
)
from synthetic import event, mission

from companion.acting.triggers.after_the_tree import LineViolated
from companion.app import Companion
from companion.errors import Aborted, NoPlanError
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    AutopilotSaid,
    Phase,
    PhaseEntered,
    ReturnBegun,
    RunFailed,
    SetpointRefused,
    StoppedAsAsked,
    StopRequested,
)
from companion.flight_events.word import ConjunctViolated
from companion.geometry import distance, is_in_polygon
from companion.mavlink.framing import dialect
from companion.mission.conditions import parse_condition
from companion.mission.model import Mission
from companion.mission.otherwise import Otherwise
from companion.planning.task_state import TaskState
from companion.run_sources.only_run import OnlyRun
from companion.vehicle.ports.setpoints import hold_at
from sitl.results import MavResult
from sitl.world.scenario import read_scenario

COM_OF_LOSS_T_S = 1.0  # of the simulated airframe


# -- the pilot -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "mode",
    ["AUTO.LOITER", *(pytest.param(m, marks=pytest.mark.long) for m in ("AUTO.RTL", "AUTO.LAND"))],
)
def test_the_pilot_wins(mode: str, start: Start) -> None:
    flight = on_the_way_to_b(start(has_station=True))
    flight.station_chooses(mode)
    switched_s = flight.now_s
    flight.until_the_end().run(5.0)
    assert flight.simulation.mode == mode
    assert flight.setpoints[-1].time_s <= switched_s + 0.1
    assert flight.commands[-1].time_s < switched_s
    assert flight.ending == aborted(f"the pilot has control, in {mode}")
    assert isinstance(flight.companion.failure, Aborted)


@pytest.mark.parametrize(
    "after_s",
    [
        *(0.1, 1.2, 4.0),
        *(pytest.param(s, marks=pytest.mark.long) for s in (0.3, 0.6, 0.9, 1.5, 2.0, 3.0, 5.0)),
    ],
)
def test_the_pilot_wins_from_the_first_command_on(after_s: float, start: Start) -> None:
    """While it arms, climbs, and enters OFFBOARD."""
    flight = (
        start(has_station=True).until_reported(PhaseEntered, phase=Phase.ARMING).run_for(after_s)
    )
    flight.station_chooses("AUTO.RTL")
    switched_s = flight.now_s
    flight.until_the_end().run(5.0)
    assert flight.ending == aborted("the pilot has control, in AUTO.RTL")
    assert all(said.time_s <= switched_s + 0.1 for said in flight.commands + flight.setpoints)


def test_a_pilot_who_holds_in_the_climb_keeps_the_vehicle(start: Start) -> None:
    """A take-off ends in hold by itself, too; but not so low."""
    flight = start(has_station=True).until_reported(PhaseEntered, phase=Phase.TAKE_OFF)
    while -flight.simulation.flight.position[2] < 0.05:
        flight.run_for(0.05)
    flight.station_chooses("AUTO.LOITER")
    flight.until_the_end().run(5.0)
    assert flight.ending == aborted("the pilot has control, in AUTO.LOITER")
    assert flight.setpoints == []
    assert flight.simulation.mode == "AUTO.LOITER"


@pytest.mark.parametrize(
    ("after_s", "silence_s"),
    [
        (0.8, 2.0),
        *(
            pytest.param(after_s, silence_s, marks=pytest.mark.long)
            for after_s in (0.0, 0.8)
            for silence_s in (1.2, 2.0, 3.0, 8.0)
            if (after_s, silence_s) != (0.8, 2.0)
        ),
    ],
)
def test_lost_heartbeats_at_the_take_off_fake_no_take_over(
    silence_s: float, after_s: float, start: Start, undisturbed: Lockstep
) -> None:
    up = Deaf(0)  # HEARTBEAT
    flight = start(up=up).until_reported(PhaseEntered, phase=Phase.TAKE_OFF).run_for(after_s)
    up.is_deaf = True
    flight.run(silence_s)
    up.is_deaf = False
    flight.until_reported(PlaceReached, place="A")
    begun = len(flight.story)
    assert flight.story == undisturbed.story[:begun]
    modes = flown_modes(flight)
    assert modes == flown_modes(undisturbed)[: len(modes)]  # the take-off had ended before OFFBOARD


def test_a_mode_that_the_autopilot_refuses_changes_nothing(
    start: Start, undisturbed: Lockstep
) -> None:
    """POSCTL without a pilot's sticks is refused in the air (seen on PX4)."""
    flight = on_the_way_to_b(start(has_station=True))
    flight.station_chooses("POSCTL")
    flight.until_the_end()
    said = flight.of(AutopilotSaid)  # to a station, and so to everybody
    assert "POSCTL refused: no manual control input" in [event.words for event in said]
    assert [event for event in flight.story if event not in said] == undisturbed.story
    assert flown_modes(flight) == flown_modes(undisturbed)


def test_a_pilot_who_took_over_during_an_outage_keeps_the_vehicle(start: Start) -> None:
    up, down = Cut(), Cut()
    flight = on_the_way_to_b(start(up=up, down=down, has_station=True))
    up.is_cut = down.is_cut = True
    flight.run(0.5)
    flight.station_chooses("AUTO.LOITER")
    flight.run(1.5)
    up.is_cut = down.is_cut = False
    back_s = flight.now_s
    flight.until_the_end()
    assert flight.ending == aborted("the pilot has control, in AUTO.LOITER")
    assert all(command.time_s < back_s for command in flight.commands)
    assert flight.simulation.mode == "AUTO.LOITER"


# -- the companion fails ---------------------------------------------------------------------------


def test_a_companion_that_dies_leaves_the_vehicle_on_hold(start: Start) -> None:
    flight = on_the_way_to_b(start())
    flight.is_companion_alive = False
    last_setpoint_s = flight.setpoints[-1].time_s
    flight.until(lambda: flight.simulation.mode != "OFFBOARD", limit_s=5.0)
    assert flight.simulation.mode == "AUTO.LOITER"
    assert COM_OF_LOSS_T_S <= flight.now_s - last_setpoint_s <= COM_OF_LOSS_T_S + 0.2
    flight.run(10.0)
    assert math.hypot(*flight.simulation.flight.velocity) < 0.2
    assert flight.simulation.collisions == 0


# -- the operator ----------------------------------------------------------------------------------


def test_a_stop_in_the_air_holds_lands_and_disarms(start: Start) -> None:
    flight = on_the_way_to_b(start())
    before = len(flight.reports)
    flight.companion.stop()
    flight.until_the_end()
    assert flight.events[before:] == [
        StopRequested(),
        PhaseEntered(Phase.HOLDING),
        PhaseEntered(Phase.LANDING),
        StoppedAsAsked(),
    ]
    assert flown_modes(flight)[-4:] == ["OFFBOARD", "AUTO.LOITER", "AUTO.LAND", "AUTO.LOITER"]
    assert not flight.simulation.is_armed
    assert -flight.simulation.flight.position[2] < 0.05
    assert flight.simulation.collisions == 0


def test_the_next_run_does_not_start_away_from_home(surveillance: Mission, start: Start) -> None:
    """Home is where the vehicle was armed; after a stop it stands elsewhere."""
    flight = on_the_way_to_b(start())
    flight.companion.stop()
    flight.until_the_end()
    flight.companion = Companion(OnlyRun(surveillance, flight))
    stopped_s = flight.now_s
    flight.until_the_end()
    assert flight.exit_code == Aborted.exit_code
    ended = flight.of(RunFailed)[-1]
    assert ended.reason.endswith("m from Home, where the mission begins; put it there")
    assert [s for s in (*flight.setpoints, *flight.commands) if s.time_s > stopped_s] == []


def test_a_stop_before_anything_is_heard_ends_at_once(start: Start) -> None:
    flight = start()
    flight.companion.stop()
    flight.tick()
    assert flight.events == [StopRequested(), StoppedAsAsked()]
    assert flight.said == []


@pytest.mark.parametrize(
    ("phase", "climbs"),
    [(Phase.CHECKING, False), (Phase.TAKE_OFF, False), (Phase.OFFBOARD, True)],
)
def test_a_stop_before_the_task(phase: Phase, climbs: bool, start: Start) -> None:
    flight = start().until_reported(PhaseEntered, phase=phase)
    flight.companion.stop()
    flight.until_the_end()
    assert flight.ending == StoppedAsAsked()
    assert not flight.simulation.is_armed
    assert -flight.simulation.flight.position[2] < 0.05
    assert ("AUTO.TAKEOFF" in flown_modes(flight)) is climbs
    assert "OFFBOARD" not in flown_modes(flight)


# -- the vehicle before the flight -----------------------------------------------------------------


def test_a_vehicle_that_may_not_arm_says_why(surveillance: Mission, short_hall: World) -> None:
    """The battery is empty; STATUSTEXT and the report of the arming checks say so, once."""
    scenario, grid = short_hall
    empty = replace(scenario, battery=replace(scenario.battery, charge=0.05))
    when = parse_condition("BATTERY_STATUS.battery_remaining > 90")
    full = replace(event("full"), when=when)
    watches = replace(surveillance, events={**surveillance.events, "full": full})
    flight = Lockstep(watches, (empty, grid), has_station=True).until_the_end()
    assert flight.ending == aborted("not armed: temporarily rejected (autopilot: low battery)")
    assert flight.setpoints == []
    assert flight.armings == 0


def test_weak_failsafes_are_not_flown_with(start: Start, short_hall: World) -> None:
    scenario, grid = short_hall
    weak = replace(scenario, parameters={"COM_OBL_RC_ACT": 0, "COM_OF_LOSS_T": 5.0})
    flight = start((weak, grid)).until_the_end()
    ended = flight.one(RunFailed, exit_code=Aborted.exit_code)
    assert "COM_OF_LOSS_T is 5; set 1.0 or less" in ended.reason
    assert "COM_OBL_RC_ACT is 0; set 5 (hold)" in ended.reason
    assert flight.commands == [] and flight.setpoints == []


def test_a_return_above_the_missions_ceiling_is_not_flown_with(
    start: Start, short_hall: World
) -> None:
    """The hall's is 4 m; PX4's return climbs to 30 m unless RTL_RETURN_ALT is set."""
    scenario, grid = short_hall
    high = replace(scenario, parameters={"COM_OBL_RC_ACT": 3})
    flight = start((high, grid)).until_the_end()
    ended = flight.one(RunFailed, exit_code=Aborted.exit_code)
    assert "RTL_RETURN_ALT is 30; set 4 or less: COM_OBL_RC_ACT 3 returns" in ended.reason
    assert flight.commands == []
    low = replace(scenario, parameters={"COM_OBL_RC_ACT": 3, "RTL_RETURN_ALT": 3.5})
    assert start((low, grid)).until_reported(PhaseEntered, phase=Phase.TAKE_OFF).armings == 1


@pytest.mark.parametrize(
    ("parameter", "narrow", "wide"),
    [("GF_MAX_HOR_DIST", 20.0, 30.0), ("GF_MAX_VER_DIST", 4.0, 4.5)],
)
def test_an_own_fence_of_the_autopilot_that_is_narrower_than_the_mission_is_not_flown_with(
    parameter: str, narrow: float, wide: float, start: Start, short_hall: World
) -> None:
    """It would hold the vehicle in the middle of its task."""
    scenario, grid = short_hall
    flight = start((replace(scenario, parameters={parameter: narrow}), grid)).until_the_end()
    ended = flight.one(RunFailed, exit_code=Aborted.exit_code)
    assert f"{parameter} is {narrow:g}; set 0 (no limit) or" in ended.reason
    assert flight.commands == []
    roomy = replace(scenario, parameters={parameter: wide})
    assert start((roomy, grid)).until_reported(PhaseEntered, phase=Phase.TAKE_OFF).armings == 1


def test_a_vehicle_that_is_armed_already_is_left_alone(start: Start) -> None:
    flight = start(has_station=True)
    flight.is_companion_alive = False
    flight.run(1.0)
    flight.station_commands(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
    flight.run(0.5)
    assert flight.simulation.is_armed
    flight.is_companion_alive = True
    flight.until_the_end()
    assert flight.events == [
        aborted("the vehicle is armed or flying already; it is left alone"),
    ]
    assert flight.commands == [] and flight.setpoints == []


# -- the task cannot be done -----------------------------------------------------------------------


def test_without_any_upload_site_it_returns_home_and_says_why(
    start: Start, short_hall: World
) -> None:
    scenario, grid = short_hall
    assert scenario.payload is not None
    payload = replace(scenario.payload, sites=(), otherwise=MavResult.DENIED)
    flight = start((replace(scenario, payload=payload), grid)).until_the_end()
    withdrawn = [event.belief for event in flight.of(BeliefWithdrawn)]
    assert withdrawn == ["canUpload(r1)", "canUpload(r2)", "canUpload(r3)"]
    begun, reached, landing, _ = flight.events[-4:]
    assert (begun, landing) == (ReturnBegun("Home"), PhaseEntered(Phase.LANDING))
    assert isinstance(reached, PlaceReached) and reached.place == "Home"
    ended = flight.one(RunFailed, exit_code=NoPlanError.exit_code)
    assert "no plan: upload cannot hold from here" in ended.reason
    assert "withdrawn: canUpload(r1), canUpload(r2), canUpload(r3)" in ended.reason
    assert isinstance(flight.companion.failure, NoPlanError)
    north, east, _ = flight.simulation.flight.position
    assert math.hypot(north, east) < 0.5
    assert not flight.simulation.is_armed


# -- the gate --------------------------------------------------------------------------------------


def test_a_setpoint_outside_the_fence_never_leaves(
    start: Start, surveillance: Mission, undisturbed: Lockstep
) -> None:
    """Behind the back of everything that acts, for a second: the vehicle is told to leave."""
    down = Cut()
    flight = on_the_way_to_b(start(down=down))
    run, wire = flight.companion._run, flight.companion.wire
    assert run is not None
    vehicle = run.vehicle
    outside = hold_at((30.0, 30.0, -2.0), 0.0)
    fed: list[Said] = []
    for _ in range(20):
        down.is_cut = True  # what the companion itself sends is lost
        flight.tick()
        down.is_cut = False
        vehicle.setpoints.fly(outside)
        flight.transmit(flight.now_s, wire.pack(vehicle.transmit(flight.now_s)))
        fed.append(flight.setpoints[-1])
        sent = (fed[-1].message.x, fed[-1].message.y, fed[-1].message.z)
        assert distance(sent, flight.simulation.flight.position) < 0.2
        assert is_in_polygon(sent, surveillance.limits.fence)
    assert {(s.message.vx, s.message.vy, s.message.vz) for s in fed} == {(0.0, 0.0, 0.0)}
    assert math.hypot(*flight.simulation.flight.velocity) < 0.5
    flight.until_the_end()
    refused = flight.one(SetpointRefused)
    assert refused.reason == "outside the fence"
    assert [event for event in flight.story if event != refused] == undisturbed.story


# -- a task that is violated -----------------------------------------------------------------------

WATCH = mission(
    {"watch": "G F at(A) & G F at(B)", "unseen": "G !target"},
    events=[event("target")],
    otherwise=Otherwise.RETURN_HOME,
)
SEEN = {
    "version": 1,
    "target": {"component": 26},
    "happens": [{"at_s": 15, "target": "seen"}],
}


def test_after_a_violation_the_flight_home_passes_the_gate() -> None:
    flight = Lockstep(WATCH, read_scenario(SEEN)).until_the_end()
    assert flight.exit_code == NoPlanError.exit_code
    assert flight.of(ConjunctViolated) != [] and flight.places[-1] == "H"
    assert flight.of(SetpointRefused) == []


def test_a_plan_that_goes_on_after_a_violation_is_held(
    start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The gate asks the monitor itself: whoever acts has not noticed."""
    flight = on_the_way_to_b(start())
    monkeypatch.setattr(LineViolated, "guard", lambda trigger, plan: False)
    monkeypatch.setattr(TaskState, "violated", ("safe",))
    violated_s = flight.now_s
    flight.run(5.0)
    assert flight.of(SetpointRefused) == [SetpointRefused("the task is violated")]
    held = [s.message for s in flight.setpoints if s.time_s > violated_s + 0.1]
    assert len(held) > 90 and {(m.vx, m.vy, m.vz) for m in held} == {(0.0, 0.0, 0.0)}
    assert math.hypot(*flight.simulation.flight.velocity) < 0.2
