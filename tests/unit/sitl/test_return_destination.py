"""Where a return leads, by PX4's rules: home, or the nearest of the rally points."""

from __future__ import annotations

import pytest

from sitl.autopilot.return_destination import SafePoint, return_destination

HOME = (0.0, 0.0, -1.0)
NORTH, EAST = SafePoint((50.0, 0.0), 0.0, True), SafePoint((0.0, 60.0), 4.0, False)
NEAR = SafePoint((9.0, 0.0), 0.0, True)
POINTS = (NEAR, NORTH, EAST)


@pytest.mark.parametrize(
    ("north_m", "east_m", "return_type", "destination"),
    [
        (40.0, 0.0, 0, (50.0, 0.0, -1.0)),  # its altitude is above home
        (0.0, 50.0, 3, (0.0, 60.0, -4.0)),  # or above the origin
        (10.0, 10.0, 0, HOME),
        (9.0, 0.0, 0, HOME),  # what is near home is passed over
        (25.9, 0.0, 0, HOME),  # nearer by less than 2 m
        (26.1, 0.0, 0, (50.0, 0.0, -1.0)),
        (1.0, 0.0, 1, (50.0, 0.0, -1.0)),
        (40.0, 0.0, 2, HOME),
        (40.0, 0.0, 4, HOME),
    ],
)
def test_the_destination(
    north_m: float, east_m: float, return_type: int, destination: tuple[float, float, float]
) -> None:
    assert return_destination((north_m, east_m, -5.0), HOME, POINTS, return_type) == destination


def test_without_any_it_is_home() -> None:
    for return_type in range(5):
        assert return_destination((40.0, 0.0, -5.0), HOME, (), return_type) == HOME
