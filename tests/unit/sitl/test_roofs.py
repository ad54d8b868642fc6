"""Low walls as roofs: standing on one, taking off from it, and its edge."""

from __future__ import annotations

import pytest
from wire import Wire

from companion.mavlink.framing import dialect
from sitl.world.scenario import read_scenario

ROOF_M = 3.0
WORLD = """\
version: 1
map: {cell_m: 0.1, walls: [{east_m: [2, 6], north_m: [-2, 2], up_m: 3}]}
"""


def over(east_m: float) -> Wire:
    """A vehicle that hovers at 5 m, and then lands there."""
    wire = Wire(*read_scenario(WORLD))
    wire.fly_offboard(0.0, 0.0, -5.0)
    wire.run(6.0, send=lambda: wire.setpoint(0.0, east_m, -5.0))
    assert wire.command(dialect.MAV_CMD_NAV_LAND, 0, 0, 0, 0, 0, 0, 0)[0] == 0
    return wire


@pytest.mark.long
def test_a_vehicle_lands_on_a_roof_and_takes_off_again() -> None:
    wire = over(4.0)
    wire.run_until(lambda: not wire.simulation.is_armed, 20.0)
    assert wire.simulation.flight.position == pytest.approx((0.0, 4.0, -ROOF_M), abs=0.1)
    assert not wire.simulation.is_damaged and wire.simulation.collisions == 0
    wire.run(2.0)
    assert wire.simulation.flight.position[2] == pytest.approx(-ROOF_M, abs=0.005)
    wire.fly_offboard(0.0, 4.0, -5.0)
    wire.run(6.0, send=lambda: wire.setpoint(0.0, 0.0, -5.0))
    wire.command(dialect.MAV_CMD_NAV_LAND)
    wire.run_until(lambda: not wire.simulation.is_armed, 20.0)
    assert wire.simulation.flight.position[2] == pytest.approx(0.0, abs=0.01)
    assert not wire.simulation.is_damaged


@pytest.mark.parametrize("east_m", [2.05, pytest.param(5.95, marks=pytest.mark.long)])
def test_a_foot_beyond_the_edge_is_a_crash(east_m: float) -> None:
    wire = over(east_m)
    wire.run_until(lambda: not wire.simulation.is_armed, 20.0)
    assert wire.simulation.is_damaged
    assert "Over the edge of a roof" in [text for _, text in wire.simulation.event_log]


def test_a_roof_is_a_wall_from_beside() -> None:
    wire = Wire(*read_scenario(WORLD))
    wire.fly_offboard(0.0, 0.0, -2.0)
    wire.run(4.0, send=lambda: wire.setpoint(0.0, 4.0, -2.0))
    assert wire.simulation.collisions == 1


def test_a_roof_that_carries_a_vehicle_is_no_wall_that_it_touches() -> None:
    """Its legs give way by a millimetre or two: then it is lower than the roof."""
    wire = over(4.0)
    lowest_m = ROOF_M

    def has_landed() -> bool:
        nonlocal lowest_m
        north_m, east_m, down_m = wire.simulation.flight.position
        lowest_m = min(lowest_m, -down_m)
        assert wire.simulation.walls_beside is not None
        assert not wire.simulation.walls_beside.is_within((north_m, east_m), 0.5)
        return not wire.simulation.is_armed

    wire.run_until(has_landed, 20.0)
    assert lowest_m < ROOF_M
