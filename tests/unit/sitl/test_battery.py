"""The battery against integrals and closed forms: gauge, charge steps, charging."""

from __future__ import annotations

import math

import numpy as np
import pytest
from physics_steps import DT, driven

from companion.geometry import GlobalOrigin
from sitl.flight.battery import CAPACITY_AH, BatterySpec
from sitl.flight.physics import FlightState, Physics

SEA = GlobalOrigin(47.4, 8.5, 0.0)
STOPPED = (0.0, 0.0, 0.0, 0.0)
AVIONICS_A, R0, R1, RC_S, FULL_V = 0.6, 0.016, 0.010, 20.0, 16.8


def run(physics: Physics, seconds: float, throttle: float = 0.0) -> list[FlightState]:
    return [driven(physics, (throttle,) * 4) for _ in range(round(seconds / DT))]


def test_the_gauge_integrates_current_and_power() -> None:
    physics = Physics(origin=SEA, battery=BatterySpec(0.8))
    physics.battery.is_draining = True
    states = run(physics, 30.0, 0.4)  # stands, the rotors turn
    amperes = np.array([state.current_a for state in states])
    volts = np.array([state.voltage_v for state in states])
    gauge = physics.battery.gauge()
    assert gauge.consumed_mah == pytest.approx(amperes.sum() * DT / 3.6, rel=1e-4)
    assert gauge.consumed_j == pytest.approx((amperes * volts).sum() * DT, rel=1e-4)
    assert gauge.consumed_mah == pytest.approx((0.8 - states[-1].charge) * CAPACITY_AH * 1e3)
    assert not gauge.is_charging


@pytest.mark.long
def test_the_remaining_time_is_the_time_that_remains() -> None:
    physics = Physics(origin=SEA, battery=BatterySpec(0.006))
    physics.battery.is_draining = True
    run(physics, 100.0)
    promised_s = physics.battery.gauge().remaining_s
    assert promised_s is not None
    waited_s = 0.0
    while driven(physics, STOPPED).charge > 0:
        waited_s += DT
    # The avionics draw a constant current; the filter of 20 s has settled to e^-5.
    assert promised_s == pytest.approx(waited_s, rel=0.01)


def test_without_a_drain_nothing_is_consumed_and_no_end_is_promised() -> None:
    physics = Physics(origin=SEA, battery=BatterySpec(0.5))
    run(physics, 5.0, 0.4)
    gauge = physics.battery.gauge()
    assert (gauge.consumed_mah, gauge.consumed_j, gauge.remaining_s) == (0.0, 0.0, None)


def test_a_step_of_charge_moves_the_voltage_and_is_no_consumption() -> None:
    physics = Physics(origin=SEA, battery=BatterySpec(0.9))
    physics.battery.is_draining = True
    before = run(physics, 60.0)[-1]
    consumed = physics.battery.gauge().consumed_mah
    physics.battery.set_charge(0.2)
    after = driven(physics, STOPPED)
    assert after.charge == pytest.approx(0.2, abs=1e-6)
    # Equal current, so only the open-circuit voltage differs: 4 (4.12 - 3.74) V.
    assert before.voltage_v - after.voltage_v == pytest.approx(4 * (4.12 - 3.74), abs=0.01)
    assert physics.battery.gauge().consumed_mah == pytest.approx(consumed, abs=1e-3)


@pytest.mark.parametrize("charging_a", [pytest.param(2.0, marks=pytest.mark.long), 10.0])
def test_a_charger_first_holds_the_current_then_the_voltage(charging_a: float) -> None:
    physics = Physics(origin=SEA, battery=BatterySpec(0.85))
    physics.battery.charging_a = charging_a
    states = run(physics, 3600.0 * 0.5 / (charging_a - AVIONICS_A))[250:]
    constant = [state for state in states if state.voltage_v < FULL_V - 1e-4]
    assert states[: len(constant)] == constant  # never again below
    for state in constant[::1000]:
        assert state.current_a == pytest.approx(AVIONICS_A - charging_a)
    # From 0.9 on the open-circuit voltage is 16.8 - 3.2 (1 - charge); with a settled RC pair the
    # current is constant until that is R0 + R1 times it below 16.8 V.
    turn = constant[-1].charge
    net_a = charging_a - AVIONICS_A
    assert 1 - turn == pytest.approx((R0 + R1) * net_a / 3.2, rel=0.05)
    # The charge counts the current, at constant current a straight line.
    seconds = constant[-1].time_s - constant[0].time_s
    gained = constant[-1].charge - constant[0].charge
    assert gained == pytest.approx(net_a * seconds / (3600 * CAPACITY_AH), rel=1e-4)
    rest = states[len(constant) :]
    assert all(abs(state.voltage_v - FULL_V) < 1e-3 for state in rest[::1000])
    assert physics.battery.gauge().is_charging or rest[-1].charge == 1.0


@pytest.mark.long
def test_at_constant_voltage_the_current_decays_to_a_full_battery() -> None:
    """Two resistances and a linear open-circuit voltage: exponentials of a 2 x 2 system."""
    physics = Physics(origin=SEA, battery=BatterySpec(0.97))
    physics.battery.charging_a = 100.0  # at constant voltage from the start
    run(physics, 120.0)
    start, end = physics.state, run(physics, 60.0)[-1]
    # R0 I + R1 i = 16.8 - E = 3.2 x for the charging current I; x' = -I / Q, i' = (I - i) / 20 s.
    q = 3600 * CAPACITY_AH
    matrix = np.array(
        ((-3.2 / (R0 * q), R1 / (R0 * q)), (3.2 / (R0 * RC_S), -(R1 / R0 + 1) / RC_S))
    )
    slowest = max(np.linalg.eigvals(matrix).real)
    ratio = (1 - end.charge) / (1 - start.charge)
    assert ratio == pytest.approx(math.exp(slowest * 60.0), rel=0.02)
    assert end.charge > 0.99


def test_a_charger_serves_the_avionics_and_takes_nothing_beyond_full() -> None:
    physics = Physics(origin=SEA, battery=BatterySpec(1.0))
    physics.battery.is_draining = True
    physics.battery.charging_a = 5.0
    states = run(physics, 60.0)
    assert states[-1].charge == pytest.approx(1.0, abs=1e-5)
    assert max(state.voltage_v for state in states) <= FULL_V + 1e-6
    assert states[-1].current_a == pytest.approx(0.0, abs=0.01)
    physics.battery.charging_a = 0.0
    assert run(physics, 1.0)[-1].current_a == pytest.approx(AVIONICS_A)
