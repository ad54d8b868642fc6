"""The autopilot counts from an origin of its own; what it tells agrees with where it truly is."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from wire import NAN, Wire

from companion.geometry import GlobalOrigin, Ned
from companion.mavlink.framing import dialect
from sitl.results import MavResult
from sitl.world.scenario import PX4_HOME, parse_scenario

AWAY = GlobalOrigin(*PX4_HOME.to_global((1500.0, -1300.0, 0.0))[:2], 455.0)
OTHER = GlobalOrigin(*PX4_HOME.to_global((-600.0, 200.0, 0.0))[:2], 500.0)
ORIGIN_ID = dialect.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN


def written(origin: GlobalOrigin) -> str:
    latitude, longitude = origin.latitude_deg, origin.longitude_deg
    values = f"latitude_deg: {latitude}, longitude_deg: {longitude}"
    return f"{{{values}, altitude_m: {origin.altitude_m}}}"


def fly(text: str) -> Wire:
    wire = Wire(parse_scenario(f"version: 1\n{text}\n", Path("missions/a.sim.yaml")))
    wire.run(1.1)
    return wire


def told_origin(wire: Wire) -> GlobalOrigin:
    heard = wire.last("GPS_GLOBAL_ORIGIN")
    return GlobalOrigin(heard.latitude / 1e7, heard.longitude / 1e7, heard.altitude / 1e3)


def local(wire: Wire) -> Ned:
    heard = wire.last("LOCAL_POSITION_NED")
    return (heard.x, heard.y, heard.z)


def gap_m(wire: Wire) -> float:
    """Between where both positions say that it is, by the origin that was told."""
    heard = wire.last("GLOBAL_POSITION_INT")
    there = told_origin(wire).to_local(heard.lat / 1e7, heard.lon / 1e7, heard.alt / 1e3)
    return math.dist(there, local(wire))


def test_an_origin_away_from_home_is_told_once_and_both_positions_agree_in_it() -> None:
    wire = fly(f"origin: {written(AWAY)}\nstart: {{east_m: 30, north_m: 40}}")
    wire.run(5.0)
    assert len(wire.named("GPS_GLOBAL_ORIGIN")) == 1
    assert gap_m(wire) < 0.03  # 1e-7 degrees are 11 mm
    true = PX4_HOME.to_global(wire.simulation.flight.position)
    assert local(wire) == pytest.approx(AWAY.to_local(*true), abs=0.01)
    home = wire.last("HOME_POSITION")
    assert (home.x, home.y, home.z) == pytest.approx(local(wire), abs=0.01)
    assert home.altitude / 1e3 == pytest.approx(PX4_HOME.altitude_m, abs=0.02)


def test_the_origin_is_told_when_it_is_asked_for() -> None:
    wire = fly("")
    assert wire.command(dialect.MAV_CMD_REQUEST_MESSAGE, ORIGIN_ID) == [MavResult.ACCEPTED]
    wire.run(0.1)
    assert len(wire.named("GPS_GLOBAL_ORIGIN")) == 2
    assert told_origin(wire).latitude_deg == pytest.approx(PX4_HOME.latitude_deg, abs=1e-7)


def test_an_origin_laid_in_flight_moves_what_is_told_and_not_the_vehicle() -> None:
    wire = fly(f"happens: [{{at_s: 15, origin: {written(OTHER)}}}]")
    wire.command(dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, NAN, NAN, NAN, PX4_HOME.altitude_m + 5)
    wire.arm()
    wire.run(13.7)
    before, truth = local(wire), wire.simulation.flight.position
    resets = wire.last("ODOMETRY").reset_counter
    wire.run(0.3)
    assert math.dist(before, local(wire)) > 600.0
    assert wire.last("ODOMETRY").reset_counter == resets + 1
    wire.run(5.0)
    assert gap_m(wire) < 0.05
    assert told_origin(wire).altitude_m == 500.0
    assert wire.simulation.flight.position == pytest.approx(truth, abs=0.3)
    assert wire.simulation.is_armed and wire.simulation.mode == "AUTO.LOITER"
    home = wire.last("HOME_POSITION")
    assert home.altitude / 1e3 == pytest.approx(PX4_HOME.altitude_m, abs=0.02)
    assert OTHER.to_local(home.latitude / 1e7, home.longitude / 1e7, 0.0)[:2] == pytest.approx(
        (home.x, home.y), abs=0.03
    )
