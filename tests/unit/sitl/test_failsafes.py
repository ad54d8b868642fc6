"""The failsafe table and its rules, without a vehicle."""

import math

import pytest

from sitl.autopilot.failsafes import (
    BatteryLevel,
    Cause,
    Conditions,
    FailsafeState,
    battery_level,
)
from sitl.autopilot.parameters import Parameters

OK, LOW, CRITICAL, EMERGENCY = BatteryLevel
HOLD_S = 5.0


def conditions(
    *,
    mode: str = "AUTO.LOITER",
    age_s: float = math.inf,
    battery: BatteryLevel = OK,
    **parameters: float,
) -> Conditions:
    return Conditions(mode, age_s, battery, Parameters(parameters))


def mode_after(state: FailsafeState, now: Conditions, now_s: float) -> str | None:
    state.update(now, now_s)
    return state.mode(now_s, HOLD_S)


@pytest.mark.parametrize(
    ("charge", "level"), [(0.5, OK), (0.15, OK), (0.149, LOW), (0.06, CRITICAL), (0.049, EMERGENCY)]
)
def test_battery_levels_at_px4s_thresholds(charge: float, level: BatteryLevel) -> None:
    assert battery_level(charge, Parameters()) is level


@pytest.mark.parametrize(
    ("action", "level", "mode"),
    [
        (0, CRITICAL, None),
        (0, EMERGENCY, None),
        (2, LOW, None),
        (2, CRITICAL, "AUTO.LAND"),
        (3, CRITICAL, "AUTO.RTL"),
        (3, EMERGENCY, "AUTO.LAND"),
    ],
)
def test_battery_actions(action: int, level: BatteryLevel, mode: str | None) -> None:
    state, now = FailsafeState(), conditions(battery=level, COM_LOW_BAT_ACT=action)
    assert mode_after(state, now, 10.0) == (mode and "AUTO.LOITER")
    assert mode_after(state, now, 14.9) == (mode and "AUTO.LOITER")
    assert mode_after(state, now, 15.0) == mode


def test_a_rise_to_emergency_does_not_start_the_hold_again() -> None:
    state = FailsafeState()  # seen: critical at 85.64, emergency at 87.67, land at 90.64
    assert mode_after(state, conditions(battery=CRITICAL), 85.64) == "AUTO.LOITER"
    assert mode_after(state, conditions(battery=EMERGENCY), 87.67) == "AUTO.LOITER"
    assert mode_after(state, conditions(battery=EMERGENCY), 90.64) == "AUTO.LAND"


def test_the_battery_comes_before_the_lost_stream() -> None:
    state = FailsafeState()
    state.update(conditions(mode="OFFBOARD", battery=CRITICAL), 0.0)
    assert state.active and state.active.cause is Cause.BATTERY_CRITICAL


def test_a_taken_over_failsafe_stays_quiet_but_a_worse_one_acts() -> None:
    state = FailsafeState()
    state.update(conditions(battery=CRITICAL), 0.0)
    state.take_over()
    assert mode_after(state, conditions(battery=CRITICAL), 1.0) is None
    assert mode_after(state, conditions(battery=EMERGENCY), 2.0) == "AUTO.LOITER"
    assert mode_after(state, conditions(battery=EMERGENCY), 7.0) == "AUTO.LAND"


@pytest.mark.parametrize(
    ("action", "mode"),
    [(0, "POSCTL"), (3, "AUTO.RTL"), (4, "AUTO.LAND"), (5, "AUTO.LOITER"), (7, "AUTO.LAND")],
)
def test_offboard_loss_acts_at_once_and_only_in_offboard(action: int, mode: str) -> None:
    lost = conditions(mode="OFFBOARD", age_s=1.1, COM_OBL_RC_ACT=action)
    assert mode_after(FailsafeState(), lost, 0.0) == mode
    fresh = conditions(mode="OFFBOARD", age_s=0.9, COM_OBL_RC_ACT=action)
    assert mode_after(FailsafeState(), fresh, 0.0) is None
    assert mode_after(FailsafeState(), conditions(age_s=1.1, COM_OBL_RC_ACT=action), 0.0) is None
