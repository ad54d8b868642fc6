"""What the acting side relies on in a vehicle, asked of the fake and of MAVLink with the simulator.

A behaviour that passes with the fake may be believed as far as this class goes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

import pytest
from fakes import FakeVehicle

from companion.geometry import distance
from companion.outcomes import Progress
from companion.tick import TICK_S
from companion.vehicle.gate import Envelope
from companion.vehicle.offboard import MavlinkVehicle
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.setpoints import hold_at
from companion.vehicle.ports.state import Mode, VehicleState
from companion.vehicle.ports.vehicle import Vehicle
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire
from sitl.link.routing import LinkName
from sitl.simulation import Simulation
from sitl.world.scenario import parse_scenario

FENCE = ((-10.0, -10.0), (-10.0, 10.0), (10.0, 10.0), (10.0, -10.0))
PAYLOAD, USER_1 = 25, 31010
WORLD = """
version: 1
payload: {component: 25, command: MAV_CMD_USER_1, answers: [], otherwise: ACCEPTED}
"""


class World(Protocol):
    """A vehicle, and time that passes for it."""

    vehicle: Vehicle

    def step(self) -> None: ...


class FakeWorld:
    def __init__(self) -> None:
        self.vehicle = FakeVehicle()
        self._ticks = 0

    def step(self) -> None:
        self._ticks += 1
        self.vehicle.step(self._ticks * TICK_S)


class SimulatedWorld:
    def __init__(self) -> None:
        self._wire = Wire()
        envelope = Envelope(FENCE, (0.2, 5.0), 2.0, climb_mps=2.0, descent_mps=1.5, carrot_m=1.5)
        self.vehicle = MavlinkVehicle(self._wire, Telemetry(), envelope, frozenset(), 2.5)
        self._wire.listen(self.vehicle.wanted, self.vehicle.continual)
        scenario = parse_scenario(WORLD, Path("contract.sim.yaml"))
        self._simulation = Simulation(scenario, None, seed=1, links=frozenset({LinkName.OFFBOARD}))
        self._to_vehicle: list[tuple[LinkName, bytes]] = []
        self._ticks = 0

    def step(self) -> None:
        self._ticks += 1
        now_s = self._ticks * TICK_S
        heard = self._simulation.step(now_s, self._to_vehicle)
        self.vehicle.receive(now_s, self._wire.parse([datagram for _, datagram in heard]))
        leaving = self._wire.pack(self.vehicle.transmit(now_s))
        self._to_vehicle = [(LinkName.OFFBOARD, d) for d in leaving]


@pytest.fixture(params=[FakeWorld, SimulatedWorld])
def world(request: pytest.FixtureRequest) -> Iterator[World]:
    world: World = request.param()
    until(world, lambda: world.vehicle.state is not None, 5.0)
    yield world
    assert world.vehicle.control.takeover is None
    assert world.vehicle.setpoints.refusal is None


def until(world: World, condition: Callable[[], bool], limit_s: float) -> None:
    for _ in range(round(limit_s / TICK_S)):
        if condition():
            return
        world.step()
    pytest.fail(f"not reached in {limit_s:.0f} s; the state is {world.vehicle.state}")


def reach(world: World, goal: Goal) -> None:
    def is_reached() -> bool:
        state = world.vehicle.state
        if goal is Goal.OFFBOARD and state is not None:
            world.vehicle.setpoints.fly(hold_at(state.motion.position, state.attitude.yaw_rad))
        return world.vehicle.goals.pursue(goal) is Progress.DONE

    until(world, is_reached, 60.0)


class TestVehicle:
    def test_it_stands_on_the_ground_disarmed(self, world: World) -> None:
        state = world.vehicle.state
        assert state is not None
        assert state.is_standing and not state.heartbeat.is_failsafe
        assert distance(state.motion.position, (0.0, 0.0, 0.0)) < 0.05

    def test_goals_are_reached_when_they_are_observed(self, world: World) -> None:
        goals: tuple[tuple[Goal, Callable[[VehicleState], bool]], ...] = (
            (Goal.ARMED, lambda s: s.heartbeat.is_armed),
            (Goal.AIRBORNE, lambda s: not s.is_landed and s.heartbeat.mode is Mode.LOITER),
            (Goal.OFFBOARD, lambda s: s.heartbeat.mode is Mode.OFFBOARD),
            (Goal.HOLDING, lambda s: s.heartbeat.mode is Mode.LOITER),
            (Goal.LANDED, lambda s: s.is_standing),
        )
        for goal, is_observed in goals:
            reach(world, goal)
            assert world.vehicle.state is not None
            assert is_observed(world.vehicle.state), goal

    def test_it_goes_where_its_setpoint_is(self, world: World) -> None:
        for goal in (Goal.ARMED, Goal.AIRBORNE, Goal.OFFBOARD):
            reach(world, goal)
        state = world.vehicle.state
        assert state is not None
        north, east, down = state.motion.position
        goal_position = (north + 1.0, east - 0.5, down)

        def has_arrived() -> bool:
            world.vehicle.setpoints.fly(hold_at(goal_position, 0.0))  # renewed, or its lease ends
            now = world.vehicle.state
            return now is not None and distance(now.motion.position, goal_position) < 0.1

        until(world, has_arrived, 15.0)

    def test_the_payload_answers(self, world: World) -> None:
        ticket = world.vehicle.payloads.send(PAYLOAD, USER_1, (1.0,), None)
        until(
            world,
            lambda: world.vehicle.payloads.outcome(ticket) is Progress.DONE,
            10.0,
        )
        world.vehicle.payloads.forget(ticket)

    def test_parameters_are_answered(self, world: World) -> None:
        until(world, lambda: world.vehicle.parameters.read("COM_OBL_RC_ACT") == 5.0, 5.0)
