"""The rate loop and the mixer inside JSBSim: the order of the mixer, and a second rate loop."""

from __future__ import annotations

import math
from importlib import resources
from typing import NamedTuple

import jsbsim
import pytest
from hypothesis import given
from hypothesis import strategies as st
from physics_steps import DT, driven, flown
from second_rate_loop import SecondRateLoop, mix

from companion.geometry import GlobalOrigin
from sitl.flight.controllers import Cascade, TrajectorySetpoint
from sitl.flight.physics import Physics, RateSetpoint
from sitl.flight.rotors import (
    IDLE_COMMAND,
    MASS_KG,
    MAX_THRUST_N,
    MIN_THRUST_N,
    SPEED_CONSTANT,
    THRUST_CONSTANT,
    Motors,
)

SEA = GlobalOrigin(47.4, 8.5, 0.0)
HIGH, STILL = (0.0, 0.0, -10.0), (0.0, 0.0, 0.0)
HUB_M = 0.225 / math.sqrt(2)
TORQUE_PER_THRUST_M = 2.3495e-7 / 1.2916e-5
VOLTAGE = "battery/voltage-v"


class Mixed(NamedTuple):
    """What one step has made of a setpoint: torques, N m, and commands."""

    torques: tuple[float, float, float]
    voltage_v: float
    motors: Motors


class Model:
    """JSBSim with the airframe, every step from rest."""

    def __init__(self) -> None:
        jsbsim.FGJSBBase().debug_lvl = 0  # type: ignore[no-untyped-call]
        with resources.as_file(resources.files("sitl.flight")) as folder:
            self.fdm = jsbsim.FGFDMExec(str(folder))
            self.fdm.set_dt(DT)
            self.fdm.set_aircraft_path(str(folder))
            assert self.fdm.load_model("quadrotor", False)
        self.fdm["ic/h-agl-ft"] = 100.0
        assert self.fdm.run_ic()

    def mix(self, setpoint: RateSetpoint, charge: float = 0.6) -> Mixed:
        fdm = self.fdm
        fdm.reset_to_initial_conditions(0)
        for axis in ("roll", "pitch", "yaw"):
            fdm[f"control/{axis}-integral-nm"] = 0.0
        fdm["control/is-closed"] = 1.0
        fdm["battery/charge"] = charge
        fdm["control/wanted-thrust-n"] = setpoint.thrust_n
        for name, rate in zip("pqr", setpoint.rates, strict=True):
            fdm[f"control/wanted-{name}-radps"] = rate
        voltage_v = fdm[VOLTAGE]
        fdm.run()
        roll, pitch, yaw = (fdm[f"control/{axis}-nm"] for axis in ("roll", "pitch", "yaw"))
        m_1, m_2, m_3, m_4 = (fdm[f"rotor/command-{i}"] for i in range(1, 5))
        return Mixed((roll, pitch, yaw), voltage_v, (m_1, m_2, m_3, m_4))


@pytest.fixture(scope="module")
def model() -> Model:
    return Model()


def delivered(motors: Motors, voltage_v: float) -> tuple[float, float, float, float]:
    """Thrust, roll, pitch and yaw torque of motor commands."""
    t = [THRUST_CONSTANT * (SPEED_CONSTANT * voltage_v * motor) ** 2 for motor in motors]
    return (
        sum(t),
        HUB_M * (t[1] + t[2] - t[0] - t[3]),
        HUB_M * (t[0] + t[2] - t[1] - t[3]),
        TORQUE_PER_THRUST_M * (t[0] + t[1] - t[2] - t[3]),
    )


thrusts = st.floats(0.0, 60.0)
rates = st.floats(-17.0, 17.0)  # torques up to 6 N m


@given(thrusts, rates, rates, st.floats(-2.0, 2.0))
def test_the_mixer_delivers_what_it_can_in_order(
    model: Model, thrust_n: float, p: float, q: float, r: float
) -> None:
    (roll, pitch, yaw), voltage_v, motors = model.mix(RateSetpoint(thrust_n, (p, q, r)))
    expected = mix(thrust_n, roll, pitch, yaw, voltage_v)
    assert motors == pytest.approx(expected.motors, rel=1e-4)
    got = delivered(motors, voltage_v)
    assert all(0.0 < motor <= 1.0 for motor in motors)
    if max(motors) == 1.0:  # the battery cannot give that any more
        return
    if not expected.is_tilt_limited:
        assert got[1:3] == pytest.approx((roll, pitch), rel=1e-4, abs=1e-6)
    else:  # less, but about the same axis
        assert got[1] * pitch == pytest.approx(got[2] * roll, rel=1e-4, abs=1e-5)
        assert math.hypot(*got[1:3]) <= 1.0001 * math.hypot(roll, pitch) + 1e-6
    if not expected.is_yaw_limited:
        assert got[3] == pytest.approx(yaw, rel=1e-4, abs=1e-6)
    else:
        assert abs(got[3]) <= 1.0001 * abs(yaw) + 1e-6
        assert got[3] * yaw >= -1e-6
    # Thrust gets what roll and pitch leave, whatever yaw wants.
    without_yaw = delivered(mix(thrust_n, roll, pitch, 0.0, voltage_v).motors, voltage_v)
    assert got[0] == pytest.approx(without_yaw[0], rel=1e-4)


@given(st.floats(0.0, 1.0), st.floats(4 * MIN_THRUST_N, 4 * MAX_THRUST_N))
def test_the_mixer_corrects_for_the_voltage(model: Model, charge: float, thrust_n: float) -> None:
    _, voltage_v, motors = model.mix(RateSetpoint(thrust_n, STILL), charge)
    if max(motors) < 1.0:
        assert delivered(motors, voltage_v)[0] == pytest.approx(thrust_n, rel=1e-4)
    else:
        assert delivered(motors, voltage_v)[0] <= 1.0001 * thrust_n


def test_a_limited_axis_does_not_integrate(model: Model) -> None:
    def integrals(setpoint: RateSetpoint) -> list[float]:
        model.mix(setpoint)
        return [model.fdm[f"control/{axis}-integral-nm"] for axis in ("roll", "pitch", "yaw")]

    hover_n = 1.5 * 9.81
    roll, pitch, yaw = integrals(RateSetpoint(hover_n, (0.1, -0.1, 0.05)))
    assert roll > 0 > pitch
    assert yaw > 0
    assert integrals(RateSetpoint(hover_n, (17.0, -17.0, 17.0))) == [0.0, 0.0, 0.0]


def test_the_rate_loop_knows_the_airframe() -> None:
    physics = Physics(origin=SEA, start=HIGH)
    state = flown(physics, Cascade(), TrajectorySetpoint(HIGH, STILL), 8.0)[-1]
    thrust_n = sum(THRUST_CONSTANT * speed**2 for speed in state.motor_speed_radps)
    assert delivered(state.motors, state.voltage_v)[0] == pytest.approx(thrust_n, rel=1e-3)
    assert thrust_n == pytest.approx(-MASS_KG * state.specific_force[2], rel=1e-3)
    assert mix(0.0, 0.0, 0.0, 0.0, 16.8).motors == pytest.approx((IDLE_COMMAND,) * 4, rel=1e-4)


def test_it_turns_the_vehicle_as_a_second_rate_loop_does() -> None:
    """Doublets on all axes, which leave no motor at its limit."""
    wanted = [
        RateSetpoint(15.0, (sign * 0.6, sign * -0.5, sign * 0.3)) for sign in (1, -1, -1, 1, 0)
    ]
    ours, second = (Physics(origin=SEA, start=(0.0, 0.0, -50.0)) for _ in range(2))
    rate_loop, apart = SecondRateLoop(), 0.0
    for setpoint in wanted:
        ours.follow(setpoint)
        for _ in range(50):
            ours.step()
            state = second.state
            driven(second, rate_loop.step(state.rates, state.voltage_v, setpoint, DT))
            apart = max(apart, math.dist(ours.state.rates, second.state.rates))
    assert apart < 0.3  # rad/s: the second has each rate a step of 4 ms later
    assert math.dist(ours.state.euler, second.state.euler) < 0.01


def test_commands_clear_the_integrals() -> None:
    physics = Physics(origin=SEA, start=HIGH, wind=(6.0, 0.0, 0.0))
    flown(physics, Cascade(), TrajectorySetpoint(HIGH, STILL), 4.0)
    driven(physics, (0.5,) * 4)
    integrals = [physics._node(f"control/{axis}-integral-nm") for axis in ("roll", "pitch", "yaw")]
    assert [each.get_double_value() for each in integrals] == [0.0, 0.0, 0.0]
