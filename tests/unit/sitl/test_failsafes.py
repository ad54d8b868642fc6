"""The failsafe table and its rules, without a vehicle."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.autopilot.failsafe_state import FailsafeStage, FailsafeState
from sitl.autopilot.failsafes import (
    FAILSAFES,
    BatteryLevel,
    FailsafeAction,
    FailsafeCause,
    FailsafeInputs,
    battery_level,
)
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.status_texts import failsafe_texts

OK, LOW, CRITICAL, EMERGENCY = BatteryLevel
HOLD, LAND, RETURN = "AUTO.LOITER", "AUTO.LAND", "AUTO.RTL"


def conditions(
    *,
    mode: str = HOLD,
    age_s: float = math.inf,
    battery: BatteryLevel = OK,
    link_age_s: float = 0.0,
    position_age_s: float = 0.0,
    breached: bool = False,
    **parameters: float,
) -> FailsafeInputs:
    return FailsafeInputs(
        mode, age_s, battery, Parameters(parameters), link_age_s, position_age_s, breached
    )


def mode_after(state: FailsafeState, now: FailsafeInputs, now_s: float) -> str | None:
    state.update(now, now_s)
    return state.mode


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
        (1, EMERGENCY, None),
        (2, LOW, None),
        (2, CRITICAL, LAND),
        (3, CRITICAL, RETURN),
        (3, EMERGENCY, LAND),
    ],
)
def test_battery_actions(action: int, level: BatteryLevel, mode: str | None) -> None:
    state, now = FailsafeState(), conditions(battery=level, COM_LOW_BAT_ACT=action)
    assert mode_after(state, now, 10.0) == (mode and HOLD)
    assert mode_after(state, now, 14.9) == (mode and HOLD)
    assert mode_after(state, now, 15.0) == mode


@pytest.mark.parametrize(
    ("action", "first", "then"),
    [
        (0, None, None),
        (1, None, None),
        (2, HOLD, HOLD),
        (3, HOLD, RETURN),
        (4, HOLD, LAND),  # terminate: its circuit breaker is set by default
        (5, HOLD, LAND),
    ],
)
def test_geofence_actions(action: int, first: str | None, then: str | None) -> None:
    state, outside = FailsafeState(), conditions(breached=True, GF_ACTION=action)
    assert mode_after(state, outside, 0.0) == first
    assert mode_after(state, outside, 5.0) == then
    assert mode_after(FailsafeState(), conditions(GF_ACTION=action), 0.0) is None


@pytest.mark.parametrize(
    ("action", "first", "then"),
    [(0, None, None), (1, HOLD, HOLD), (2, HOLD, RETURN), (3, HOLD, LAND), (5, HOLD, LAND)],
)
def test_data_link_actions(action: int, first: str | None, then: str | None) -> None:
    """Seen on PX4 with NAV_DLL_ACT 1: LOITER 12.85 s after the last heartbeat."""
    state = FailsafeState()
    assert mode_after(state, conditions(link_age_s=12.5, NAV_DLL_ACT=action), 0.0) is None
    silent = conditions(link_age_s=12.6, NAV_DLL_ACT=action)
    assert mode_after(state, silent, 0.1) == first
    assert mode_after(state, silent, 5.1) == then
    assert mode_after(state, conditions(link_age_s=0.1, NAV_DLL_ACT=action), 6.0) is None


@pytest.mark.parametrize(("mode", "bit"), [("AUTO.MISSION", 1), (HOLD, 2), ("OFFBOARD", 4)])
def test_modes_that_need_no_ground_station(mode: str, bit: int) -> None:
    for excepted in range(8):
        silent = conditions(
            mode=mode, age_s=0.0, link_age_s=99.0, NAV_DLL_ACT=1, COM_DLL_EXCEPT=excepted
        )
        assert mode_after(FailsafeState(), silent, 0.0) == (None if excepted & bit else HOLD)


@pytest.mark.parametrize(
    ("mode", "landing", "flown"),
    [
        ("OFFBOARD", 0, "ALTCTL"),
        ("POSCTL", 0, "ALTCTL"),
        ("OFFBOARD", 1, "DESCEND"),
        ("AUTO.MISSION", 0, "DESCEND"),
        ("ALTCTL", 0, None),
    ],
)
def test_position_loss_acts_after_five_seconds_and_ends_with_it(
    mode: str, landing: int, flown: str | None
) -> None:
    state = FailsafeState()

    def lost(age_s: float) -> FailsafeInputs:
        return conditions(mode=mode, age_s=0.0, position_age_s=age_s, COM_POSCTL_NAVL=landing)

    assert mode_after(state, lost(4.9), 0.0) is None
    assert mode_after(state, lost(5.1), 0.2) == flown
    assert mode_after(state, lost(0.0), 0.4) is None


def test_without_a_position_nothing_returns_or_holds() -> None:
    state = FailsafeState()
    both = conditions(
        mode="ALTCTL", battery=CRITICAL, position_age_s=9.0, COM_LOW_BAT_ACT=3, COM_FAIL_ACT_T=0
    )
    assert mode_after(state, both, 0.0) == "DESCEND"


def test_a_rise_to_emergency_does_not_start_the_hold_again() -> None:
    state = FailsafeState()  # seen: critical at 85.64, emergency at 87.67, land at 90.64
    assert mode_after(state, conditions(battery=CRITICAL), 85.64) == HOLD
    assert mode_after(state, conditions(battery=EMERGENCY), 87.67) == HOLD
    assert mode_after(state, conditions(battery=EMERGENCY), 90.64) == LAND


SITUATIONS = st.builds(
    conditions,
    mode=st.sampled_from(["OFFBOARD", HOLD, "AUTO.MISSION", "POSCTL", "ALTCTL"]),
    age_s=st.sampled_from([0.0, 2.0]),
    battery=st.sampled_from(BatteryLevel),
    link_age_s=st.sampled_from([0.0, 20.0]),
    position_age_s=st.sampled_from([0.0, 6.0]),
    breached=st.booleans(),
    COM_OBL_RC_ACT=st.sampled_from([0, 3, 4, 5, 6, 7]),
    NAV_DLL_ACT=st.sampled_from([0, 1, 2, 3, 5, 6]),
    GF_ACTION=st.sampled_from([0, 1, 2, 3, 4, 5]),
    COM_LOW_BAT_ACT=st.sampled_from([0, 1, 2, 3]),
    CBRK_FLIGHTTERM=st.sampled_from([0, 121212]),
)


@given(SITUATIONS)
def test_the_most_severe_action_wins(now: FailsafeInputs) -> None:
    state = FailsafeState()
    state.update(now, 0.0)
    demanded = [action for f in FAILSAFES if (action := f.action(now)) is not None]
    assert (state.selected.action if state.selected else None) == max(demanded, default=None)
    assert state.stops_motors == any(action >= FailsafeAction.DISARM for action in demanded)


@given(SITUATIONS)
def test_after_a_take_over_the_intended_mode_is_flown_in_the_same_situation(
    now: FailsafeInputs,
) -> None:
    state = FailsafeState()
    for _ in FAILSAFES:
        state.update(now, 0.0)
        state.take_over()
    state.update(now, 0.1)
    assert state.selected is None or state.selected.cause in (
        FailsafeCause.OFFBOARD_LOST,
        FailsafeCause.POSITION_LOST,
    )


@pytest.mark.parametrize(
    ("parameters", "stages", "text"),
    [
        ({"GF_ACTION": 0}, ["INACTIVE", "INACTIVE"], None),
        ({"GF_ACTION": 1}, ["WARNING", "WARNING"], "Failsafe warning: geofence violated"),
        ({"GF_ACTION": 2}, ["ACTING", "ACTING"], "Failsafe activated: geofence violated"),
        (
            {"GF_ACTION": 3},
            ["DELAYED", "ACTING"],
            "Failsafe activated: entering Hold for 5 seconds",
        ),
        (
            {"GF_ACTION": 4, "CBRK_FLIGHTTERM": 0},
            ["STOPPING", "STOPPING"],
            "Failsafe activated: geofence violated",
        ),
    ],
)
def test_stages_and_their_texts(
    parameters: dict[str, Any], stages: list[str], text: str | None
) -> None:
    state, outside = FailsafeState(), conditions(breached=True, **parameters)
    state.update(outside, 0.0)
    texts = failsafe_texts(state, outside.parameters)
    assert [told.text for told in texts] == ([text] if text else [])
    seen = [state.stage.name]
    state.update(outside, 5.0)
    assert [*seen, state.stage.name] == stages


def test_a_taken_over_failsafe_stays_quiet_but_a_worse_one_acts() -> None:
    state = FailsafeState()
    state.update(conditions(battery=CRITICAL), 0.0)
    state.take_over()
    assert mode_after(state, conditions(battery=CRITICAL), 1.0) is None
    assert mode_after(state, conditions(battery=EMERGENCY), 2.0) == HOLD
    assert mode_after(state, conditions(battery=EMERGENCY), 7.0) == LAND


def test_a_fence_acts_on_after_the_vehicle_is_back_until_the_mode_is_changed() -> None:
    state = FailsafeState()
    assert mode_after(state, conditions(breached=True, GF_ACTION=3), 0.0) == HOLD
    assert mode_after(state, conditions(GF_ACTION=3), 6.0) == RETURN
    state.take_over()
    assert mode_after(state, conditions(GF_ACTION=3), 7.0) is None
    assert mode_after(state, conditions(breached=True, GF_ACTION=3), 8.0) == HOLD


@pytest.mark.parametrize(
    ("action", "mode"),
    [(0, "POSCTL"), (1, "ALTCTL"), (2, "ALTCTL"), (3, RETURN), (4, LAND), (5, HOLD), (6, LAND)],
)
def test_offboard_loss_acts_at_once_and_only_in_offboard(action: int, mode: str) -> None:
    state, lost = FailsafeState(), conditions(mode="OFFBOARD", age_s=1.1, COM_OBL_RC_ACT=action)
    assert mode_after(state, lost, 0.0) == mode
    fresh = conditions(mode="OFFBOARD", age_s=0.9, COM_OBL_RC_ACT=action)
    assert mode_after(state, fresh, 0.1) is None
    assert mode_after(FailsafeState(), conditions(age_s=1.1, COM_OBL_RC_ACT=action), 0.0) is None


@pytest.mark.parametrize(("action", "breaker"), [(7, 121212), (6, 0)])
def test_disarming_and_termination_stop_the_motors(action: int, breaker: int) -> None:
    state = FailsafeState()
    state.update(
        conditions(mode="OFFBOARD", age_s=1.1, COM_OBL_RC_ACT=action, CBRK_FLIGHTTERM=breaker), 0.0
    )
    assert state.stops_motors
    assert state.mode is None
    assert state.stage is FailsafeStage.STOPPING
