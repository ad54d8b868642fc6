"""The arithmetic of the modes against PX4's rules."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.px4_modes import MODES
from sitl.autopilot.basic_modes import descent_mps
from sitl.autopilot.modes import FLIGHT_MODES, missing_requirement
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.return_mode import return_height_m

HOME = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("away_m", "height_m", "expected_m"),
    [
        (100.0, 5.0, 30.0),  # RTL_RETURN_ALT
        (100.0, 45.0, 45.0),  # never down
        (8.0, 5.0, 8.0),  # inside RTL_MIN_DIST: the 45 degree cone
        (3.0, 1.0, 4.0),  # outside the acceptance radius: at least twice it
        (1.0, 0.5, 2.0),  # inside: twice the distance
        (1.0, 10.0, 10.0),
    ],
)
def test_return_height(away_m: float, height_m: float, expected_m: float) -> None:
    height = return_height_m((away_m, 0.0, -height_m), HOME, Parameters())
    assert height == pytest.approx(expected_m)


@pytest.mark.parametrize(
    ("height_m", "expected"), [(50, 1.5), (10, 1.5), (7.5, 1.1), (5, 0.7), (-3, 0.7)]
)
def test_descent_slows_down_between_ten_and_five_metres(height_m: float, expected: float) -> None:
    assert descent_mps(height_m, Parameters()) == pytest.approx(expected)


@given(a=st.floats(-100, 100), b=st.floats(-100, 100))
def test_descent_is_never_slower_higher_up(a: float, b: float) -> None:
    low, high = sorted((a, b))
    assert descent_mps(low, Parameters()) <= descent_mps(high, Parameters())


def test_every_mode_has_a_name_that_px4_knows() -> None:
    assert set(FLIGHT_MODES) - set(MODES) == {"DESCEND"}  # a failsafe's, shown as AUTO.LAND


@pytest.mark.parametrize(
    ("mode", "lacking", "expected"),
    [
        ("OFFBOARD", "has_setpoints", "no offboard signal"),
        ("AUTO.MISSION", "has_mission", "no valid mission available"),
        ("AUTO.LOITER", "has_position", "GPS fix too low"),
        ("AUTO.LOITER", "has_mission", None),
        ("POSCTL", "has_mission", "no manual control input"),
    ],
)
def test_what_a_mode_lacks(mode: str, lacking: str, expected: str | None) -> None:
    has = dict.fromkeys(("has_setpoints", "has_mission", "has_position"), True)
    assert missing_requirement(mode, **{**has, lacking: False}) == expected
