"""Which failsafes of the autopilot are strong enough to fly with."""

from __future__ import annotations

import math

import pytest

from companion.vehicle.failsafes import FlownWithin, weaknesses

STRONG: dict[str, float | None] = {
    "COM_OF_LOSS_T": 1.0,
    "COM_OBL_RC_ACT": 5.0,
    "COM_LOW_BAT_ACT": 3.0,
    "GF_ACTION": 2.0,
    "COM_RCL_EXCEPT": 0.0,
    "RTL_RETURN_ALT": 4.0,
    "GF_MAX_HOR_DIST": 0.0,
    "GF_MAX_VER_DIST": 0.0,
    "MIS_TAKEOFF_ALT": 2.5,
}
FLOWN = FlownWithin(ceiling_m=4.0, away_m=25.3)


def test_strong_failsafes_have_no_weakness() -> None:
    assert weaknesses(STRONG, FLOWN) == []


@pytest.mark.parametrize(
    ("parameter", "strong"),
    [
        ("COM_OF_LOSS_T", {0.1, 0.5, 1.0}),
        ("COM_OBL_RC_ACT", {3.0, 4.0, 5.0}),
        ("COM_LOW_BAT_ACT", {2.0, 3.0}),
        ("GF_ACTION", {2.0, 3.0, 5.0}),
        ("COM_RCL_EXCEPT", {0.0, 1.0, 2.0, 3.0}),
    ],
)
def test_each_parameter_is_judged(parameter: str, strong: set[float]) -> None:
    values = {-1.0, 0.0, 0.1, 0.5, 1.0, 1.1, 2.0, 3.0, 4.0, 5.0, 6.0, 60.0, math.inf, math.nan}
    assert {v for v in values if weaknesses({**STRONG, parameter: v}, FLOWN) == []} == strong


@pytest.mark.parametrize(
    ("parameter", "too_near", "line"),
    [
        (
            "GF_MAX_HOR_DIST",
            {0.1, 4.0, 4.5, 20.0, math.nan},
            "GF_MAX_HOR_DIST is 20; set 0 (no limit) or 25.5 or more: so far from home the "
            "autopilot ends a flight, and the mission is flown up to 25.3 m away (limits.fence)",
        ),
        (
            "GF_MAX_VER_DIST",
            {0.1, 4.0, math.nan},
            "GF_MAX_VER_DIST is 4; set 0 (no limit) or 4.5 or more: so far from home the "
            "autopilot ends a flight, and the mission may climb to 4 m (limits.up_m)",
        ),
    ],
)
def test_the_autopilots_own_cylinder_is_no_narrower_than_the_mission(
    parameter: str, too_near: set[float], line: str
) -> None:
    values = {-1.0, 0.0, 0.1, 4.0, 4.5, 20.0, 25.3, 30.0, math.inf, math.nan}
    found = {v: weaknesses({**STRONG, parameter: v}, FLOWN) for v in values}
    assert {v for v, lines in found.items() if lines} == too_near
    assert [line] in found.values()
    (unknown,) = weaknesses({**STRONG, parameter: None}, FLOWN)
    assert unknown.startswith(f"{parameter} was not answered; set 0 (no limit) or ")


@pytest.mark.parametrize(("height_m", "is_weak"), [(1.5, False), (4.0, False), (4.1, True)])
def test_a_take_off_stays_below_the_ceiling(height_m: float, is_weak: bool) -> None:
    lines = weaknesses({**STRONG, "MIS_TAKEOFF_ALT": height_m}, FLOWN)
    told = (
        "MIS_TAKEOFF_ALT is 4.1; set 4 or less: a take-off climbs so high at least, and the "
        "mission stays below 4 m (limits.up_m)"
    )
    assert lines == [told] * is_weak
    (unknown,) = weaknesses({**STRONG, "MIS_TAKEOFF_ALT": None}, FLOWN)
    assert unknown.startswith("MIS_TAKEOFF_ALT was not answered; set 4 or less")


def test_a_weakness_says_what_to_do() -> None:
    (line,) = weaknesses({**STRONG, "COM_OBL_RC_ACT": 0.0}, FLOWN)
    assert line == (
        "COM_OBL_RC_ACT is 0; set 5 (hold), 4 (land) or 3 (return, at RTL_RETURN_ALT): "
        "what it does then"
    )


def test_no_answer_is_a_weakness() -> None:
    (line,) = weaknesses({**STRONG, "COM_OF_LOSS_T": None}, FLOWN)
    assert line.startswith("COM_OF_LOSS_T was not answered; set 1.0 or less")


def test_px4_as_it_comes_is_weak_in_two() -> None:
    """Defaults of PX4 v1.16: 1.0 s, Position, warning alone, Hold, none."""
    found = weaknesses({**STRONG, "COM_OBL_RC_ACT": 0.0, "COM_LOW_BAT_ACT": 0.0}, FLOWN)
    assert [line.split()[0] for line in found] == ["COM_OBL_RC_ACT", "COM_LOW_BAT_ACT"]


@pytest.mark.parametrize("parameter", ["COM_OBL_RC_ACT", "GF_ACTION"])
def test_a_return_stays_below_the_missions_ceiling(parameter: str) -> None:
    """PX4 climbs to RTL_RETURN_ALT above home before it flies there; 30 m by default."""
    returning = {**STRONG, parameter: 3.0}
    assert weaknesses(returning, FLOWN) == []
    assert weaknesses({**returning, "RTL_RETURN_ALT": 30.0}, FlownWithin(30.0, 25.3)) == []
    (high,) = weaknesses({**returning, "RTL_RETURN_ALT": 30.0}, FLOWN)
    assert high == (
        f"RTL_RETURN_ALT is 30; set 4 or less: {parameter} 3 returns, and climbs so high first, "
        "where the mission stays below 4 m"
    )
    (unknown,) = weaknesses({**returning, "RTL_RETURN_ALT": None}, FLOWN)
    assert unknown.startswith("RTL_RETURN_ALT was not answered; set 4 or less")


def test_without_a_return_its_height_is_of_no_account() -> None:
    assert weaknesses({**STRONG, "RTL_RETURN_ALT": 30.0}, FLOWN) == []
    assert weaknesses({**STRONG, "RTL_RETURN_ALT": None}, FLOWN) == []


@pytest.mark.parametrize(
    ("critical", "is_refused"),
    [(0.07, False), (0.17, False), (0.18, False), (0.19, True), (None, True)],
)
def test_the_reserve_of_plans_lies_above_the_charge_at_which_the_autopilot_acts(
    critical: float | None, is_refused: bool
) -> None:
    values = {**STRONG, "BAT_CRIT_THR": critical}
    found = weaknesses(values, FLOWN, reserve=0.2)
    assert bool(found) is is_refused
    assert all("BAT_CRIT_THR" in line and "reserve is 20 %" in line for line in found)
    assert weaknesses(values, FLOWN) == []
