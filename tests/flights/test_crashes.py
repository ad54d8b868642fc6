"""A crash is a crash: in flight, while landing, and after the companion has ended."""

from __future__ import annotations

from dataclasses import replace

import meadow
import pytest
from lockstep import Lockstep, World
from synthetic import command, mission

from companion.api.simulating import SimulationResult, simulate
from companion.flight_events.sortie import Phase, PhaseEntered, RunFailed, VehicleCrashed
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.otherwise import Otherwise
from sitl.world.scenario import Scenario, read_scenario

DISARMED, FELL = "the vehicle was disarmed", "the vehicle fell"
DISARMED_IN_THE_AIR = "the vehicle was disarmed in the air"
FORCED = 21196.0
"""Second parameter of a disarming that an autopilot does not refuse in the air."""
PILLAR = {
    "name": "pillar",
    "circle": {"east_m": 0.6, "north_m": 6.0, "radius_m": 0.6},
    "present": False,
}


def world(after_s: float) -> World:
    """A pillar stands beside the vehicle some time after it was told to land."""
    comes = {"name": "pillar", "present": True}
    event = {"command": "MAV_CMD_NAV_LAND", "after_s": after_s, "obstacle": comes}
    scenario = {"version": 1, "obstacles": [PILLAR], "happens": [event]}
    return read_scenario(scenario, default_map=mission("F at(A)").grid)


@pytest.mark.parametrize(
    "after_s", [1.0, *(pytest.param(s, marks=pytest.mark.long) for s in (0.2, 1.8))]
)
def test_a_collision_while_landing_ends_with_exit_code_5(after_s: float) -> None:
    """It ended with "task satisfied, landed" and exit code 0."""
    flight = Lockstep(mission("F at(A)"), world(after_s)).until_the_end()
    assert flight.simulation.collisions == 1
    assert PhaseEntered(Phase.LANDING) in flight.events
    crash = flight.one(VehicleCrashed)
    assert flight.events[-1] == RunFailed(crash.sign, 5)


def test_a_vehicle_killed_in_flight_is_a_crash() -> None:
    flight = Lockstep(mission("F at(A)"), (Scenario(), None))
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    flight.simulation._autopilot.terminate()
    flight.until_the_end()
    assert flight.one(VehicleCrashed).sign in (DISARMED_IN_THE_AIR, "the vehicle fell")
    assert flight.exit_code == 5


@pytest.mark.parametrize(
    ("after_s", "why", "tries"),
    [
        *((0.0, DISARMED, 2), (2.0, FELL, 1)),
        *(
            pytest.param(*each, marks=pytest.mark.long)
            for each in (
                *((0.0, DISARMED, 1), (1.0, DISARMED, 1), (1.0, DISARMED, 2)),
                *((2.0, FELL, 2), (4.0, FELL, 1), (4.0, FELL, 2)),
            )
        ),
    ],
)
def test_what_was_disarmed_in_a_take_off_of_the_plan_is_not_armed_again(
    after_s: float, why: str, tries: int
) -> None:
    """On the ground or in the air, by a ground station; the skill may have another try."""
    asked = meadow.stay("land()", "take_off()", tries=tries)
    flight = Lockstep(asked, world_of(asked, None), has_station=True)
    flight.until(lambda: flight.armings == 2).run(after_s)
    flight.station_commands(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0.0, FORCED)
    flight.until_the_end(5.0)
    arming = dialect.MAV_CMD_COMPONENT_ARM_DISARM
    assert len([s for s in flight.commands if s.message.command == arming]) == 2
    assert flight.ending == RunFailed(why, 5)


def left_on_hold(pillar_stands: bool) -> SimulationResult:
    """The payload refuses, so there is no plan, and the vehicle is left on hold at A."""
    flown = replace(
        mission("F done", skills=[command("do", "at(A)", "done")]), otherwise=Otherwise.HOLD
    )
    refuses = {"command": "MAV_CMD_USER_1", "otherwise": "DENIED"}
    comes = {"name": "pillar", "present": pillar_stands}
    second_mode = {"command": "MAV_CMD_DO_SET_MODE", "nth": 2, "after_s": 3, "obstacle": comes}
    return simulate(
        flown, {"version": 1, "payload": refuses, "obstacles": [PILLAR], "happens": [second_mode]}
    )


def test_what_is_hit_after_the_companion_has_ended_is_in_the_verdict() -> None:
    assert left_on_hold(pillar_stands=False).exit_code == 3
    result = left_on_hold(pillar_stands=True)
    assert isinstance(result.events[-1].event, RunFailed) and result.events[-1].event.exit_code == 3
    assert result.collisions == 1
    assert result.exit_code == 5 and "has hit" in str(result.failure)
