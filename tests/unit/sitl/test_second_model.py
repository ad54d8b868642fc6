"""JSBSim against a second model of the same equations: a mission, and every second of it.

Over a whole mission each model is flown by its own cascade and its own rate loop. Motor commands
alone keep no quadrotor in place: an angular impulse of 1e-6 rad/s is 44 mm after 30 s, g t^3 / 6 of
it, beyond any two integrators. So equal commands are flown for a second at a time, each time from
JSBSim's state. This is the sharper test: a cascade would correct a wrong coefficient.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
import second_model
from physics_steps import CONTROL_S, DT
from second_model import SecondModel
from second_rate_loop import SecondRateLoop

from companion.geometry import GlobalOrigin, Ned
from sitl.flight.controllers import CONTROL_STEPS, Cascade, TrajectorySetpoint
from sitl.flight.physics import FlightState, Physics, RateSetpoint
from sitl.flight.rotors import Motors

LATITUDE_DEG = 47.4
WIND: Ned = (2.0, -1.0, 0.0)
LEGS = (  # of 6 s each: climbs, turns, full speed, and into the ground effect
    ((0.0, 0.0, -3.0), 0.0),
    ((5.0, 0.0, -3.0), 0.5),
    ((5.0, 4.0, -4.0), -1.0),
    ((0.0, 4.0, -2.0), 2.0),
    ((0.0, 0.0, -0.05), 0.0),
)
STEPS = 7500
SECOND = 250


def setpoint(step: int) -> TrajectorySetpoint:
    position, yaw_rad = LEGS[int(step * DT / 6)]
    return TrajectorySetpoint(position, (0.0, 0.0, 0.0), yaw_rad=yaw_rad)


@dataclass
class Recording:
    """A mission flown in JSBSim; entry i of each list is what was before step i."""

    states: list[FlightState] = field(default_factory=list)
    rc_currents_a: list[float] = field(default_factory=list)
    motors: list[Motors] = field(default_factory=list)

    def model(self, step: int) -> SecondModel:
        return SecondModel(
            self.states[step],
            LATITUDE_DEG,
            wind=WIND,
            rc_current_a=self.rc_currents_a[step],
            motors=self.motors[step - 1] if step else (0.0, 0.0, 0.0, 0.0),
        )

    def apart_after_a_second(self, step: int) -> float:
        model = self.model(step)
        for motors in self.motors[step : step + SECOND]:
            model.step(motors, DT)
        return math.dist(model.state.position, self.states[step + SECOND].position)


@pytest.fixture(scope="module")
def mission() -> Recording:
    physics = Physics(origin=GlobalOrigin(LATITUDE_DEG, 8.5, 0.0), start=LEGS[0][0], wind=WIND)
    physics.battery.is_draining = True
    cascade = Cascade()
    recording = Recording()
    for i in range(STEPS):
        recording.states.append(physics.state)
        recording.rc_currents_a.append(physics.battery.gauge().mean_current_a)
        if i % CONTROL_STEPS == 0:
            physics.follow(cascade.step(physics.state, setpoint(i), CONTROL_S))
        physics.step()
        recording.motors.append(physics.state.motors)
    return recording


def test_the_mission_exercises_the_model(mission: Recording) -> None:
    speeds = [math.hypot(*state.velocity) for state in mission.states]
    heights = [-state.position[2] for state in mission.states]
    assert max(speeds) > 2.5
    assert (min(heights) < 0.1, max(heights) > 3.9) == (True, True)
    assert not any(state.is_on_ground for state in mission.states)


@pytest.mark.long  # each second of it is, which is sharper
def test_a_mission_is_the_same_in_both_models(mission: Recording) -> None:
    model, cascade, rate_loop = mission.model(0), Cascade(), SecondRateLoop()
    wanted, apart_m = RateSetpoint(0.0, (0.0, 0.0, 0.0)), 0.0
    for i in range(STEPS - 1):
        if i % CONTROL_STEPS == 0:
            wanted = cascade.step(model.state, setpoint(i), CONTROL_S)
        model.step(rate_loop.step(model.state.rates, model.state.voltage_v, wanted, DT), DT)
        apart_m = max(apart_m, math.dist(model.state.position, mission.states[i + 1].position))
    assert apart_m <= 0.010  # the second rate loop has each state a step later
    assert model.state.charge == pytest.approx(mission.states[-1].charge, abs=1e-5)
    assert model.state.voltage_v == pytest.approx(mission.states[-1].voltage_v, abs=1e-3)


def test_equal_commands_move_both_alike(mission: Recording) -> None:
    apart_m = [mission.apart_after_a_second(i) for i in range(SECOND, STEPS - SECOND, 3 * SECOND)]
    assert max(apart_m) <= 0.005
    assert float(np.median(apart_m)) <= 0.0003


@pytest.mark.parametrize(
    "name",
    [
        "ROTOR_DRAG",
        pytest.param("K_I", marks=pytest.mark.long),
        pytest.param("K_T", marks=pytest.mark.long),
        pytest.param("K_Q", marks=pytest.mark.long),
        "LAG_S",
        pytest.param("ROTOR_INERTIA", marks=pytest.mark.long),
        pytest.param("R0", marks=pytest.mark.long),
    ],
)
def test_a_coefficient_that_is_off_by_a_twentieth_shows(
    mission: Recording, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr(second_model, name, 1.05 * getattr(second_model, name))
    departures = (3000, 1750, 3250, 4750, 6000)
    assert any(mission.apart_after_a_second(i) > 0.005 for i in departures)
