"""What a scenario does to the vehicle, as a client sees it: battery, GPS, arming, wind, damage."""

from pathlib import Path

import numpy as np
import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from wire import NAN, Wire, gcs_heartbeat

from companion.errors import MissionError
from companion.mavlink.framing import dialect
from companion.motion.grid import OccupancyGrid
from companion.vehicle_profile import VehicleProfile
from sitl.autopilot.parameters import PARAMETERS, vehicle_defaults
from sitl.results import MavResult
from sitl.world.obstacles import Obstacle, TrueMap
from sitl.world.scenario import parse_scenario
from sitl.world.schema import json_schema

CHARGING, CRITICAL = 7, 3  # MAV_BATTERY_CHARGE_STATE
PAD = "pads: [{east_m: 0, north_m: 0, radius_m: 1, current_a: 10}]\n"
ARMING = dialect.MAV_CMD_COMPONENT_ARM_DISARM


def fly(text: str, grid: OccupancyGrid | None = None) -> Wire:
    """A world, with a ground station that listens."""
    wire = Wire(parse_scenario("version: 1\n" + text, Path("missions/a.sim.yaml")), grid)
    wire.send(gcs_heartbeat())
    return wire


def take_off(wire: Wire, up_m: float) -> None:
    altitude_m = wire.simulation._vehicle.origin.altitude_m + up_m
    wire.command(dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, NAN, NAN, NAN, altitude_m)
    assert wire.arm() == [MavResult.ACCEPTED]
    wire.run_until(lambda: wire.simulation.flight.position[2] < 0.3 - up_m, 20.0)


# -- the vehicle ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("vehicle", "collisions"), [("quad_35cm", 0), ("{radius_m: 1.2}", 1)])
def test_a_wider_vehicle_touches_what_its_mission_passes(vehicle: str, collisions: int) -> None:
    occupied = np.zeros((200, 200), dtype=np.bool_)
    occupied[120:122, :] = True  # 2 m to the north
    grid = OccupancyGrid(occupied, 0.1, (-10.0, -10.0))
    wire = fly(f"vehicle: {vehicle}\n", grid)
    wire.fly_offboard(0.0, 0.0, -2.0)
    wire.run(5.0, send=lambda: wire.setpoint(1.0, 0.0, -2.0))
    assert wire.simulation.collisions == collisions


def test_the_vehicle_sets_defaults_of_the_autopilot() -> None:
    vehicle = "vehicle: {speed_mps: 1, climb_mps: 0.4, max_acceleration_mps2: 2}\n"
    wire = fly(f"{vehicle}parameters: {{MPC_Z_VEL_MAX_UP: 0.6}}\n")
    parameters = wire.simulation._autopilot.parameters
    names = ("MPC_XY_VEL_MAX", "MPC_Z_VEL_MAX_UP", "MPC_Z_VEL_MAX_DN", "MPC_ACC_HOR_MAX")
    assert [parameters[name] for name in names] == [1.0, 0.6, 1.5, 2.0]
    wire.fly_offboard(0.0, 0.0, -2.0)
    speeds, climbs = [], []
    for _ in range(100):
        wire.run(0.1, send=lambda: wire.setpoint(20.0, 0.0, -8.0))
        north_mps, _, down_mps = wire.simulation.flight.velocity
        speeds.append(north_mps)
        climbs.append(-down_mps)
    assert 0.95 < max(speeds) < 1.1
    assert 0.55 < max(climbs) < 0.7


def test_the_default_vehicle_has_the_defaults_of_px4() -> None:
    assert {name: PARAMETERS[name][1] for name in vehicle_defaults(VehicleProfile())} == (
        vehicle_defaults(VehicleProfile())
    )


# -- battery and pads ------------------------------------------------------------------------------


@pytest.mark.long
def test_on_a_pad_the_battery_charges_while_the_vehicle_is_disarmed() -> None:
    wire = fly(PAD + "battery: {charge: 0.5}\n")
    wire.run(10.0)
    charged = wire.last("BATTERY_STATUS")
    assert charged.charge_state == CHARGING
    assert charged.current_battery < -500  # 10 A less what the avionics take
    assert charged.current_consumed < 0
    begun = wire.simulation.flight.charge
    take_off(wire, 2.0)
    wire.run(5.0)
    flying = wire.last("BATTERY_STATUS")
    assert (flying.charge_state, flying.current_battery > 500) == (1, True)
    assert wire.simulation.flight.charge < begun
    wire.command(dialect.MAV_CMD_NAV_LAND, 0, 0, 0, NAN, NAN, NAN, 0)
    wire.run_until(lambda: not wire.simulation.is_armed, 30.0)
    landed = wire.simulation.flight.charge
    wire.run(5.0)
    assert wire.simulation.flight.charge > landed


def test_beside_the_pad_it_does_not_charge() -> None:
    wire = fly(PAD + "battery: {charge: 0.5}\nstart: {east_m: 3}\n")
    wire.run(5.0)
    assert wire.last("BATTERY_STATUS").charge_state == 1
    assert wire.simulation.flight.charge == 0.5


def test_a_pad_that_fails_gives_nothing_until_it_works_again() -> None:
    pad = PAD.replace("current_a", "name: Dock, current_a")
    events = "  - {at_s: 3, pad: {name: Dock, works: false}}\n"
    events += "  - {at_s: 6, pad: {name: Dock, works: true, current_a: 2}}\n"
    wire = fly(f"{pad}battery: {{charge: 0.5}}\nhappens:\n{events}")
    currents = []
    for _ in range(3):
        wire.run(2.9)
        currents.append(wire.simulation.flight.current_a)
        wire.run(0.1)
    assert currents == pytest.approx([0.6 - 10.0, 0.6, 0.6 - 2.0])


def test_a_pad_that_changes_batteries_gives_a_full_one_each_time_the_vehicle_has_come() -> None:
    pad = "pads: [{east_m: 0, north_m: 0, radius_m: 1, swap_s: 8}]\n"
    wire = fly(pad + "battery: {charge: 0.3}\n")
    wire.run(7.9)
    assert wire.simulation.flight.charge == 0.3
    wire.run(0.2)
    assert wire.simulation.flight.charge == 1.0
    assert wire.simulation.event_log[-1][1] == "battery: changed"
    take_off(wire, 2.0)
    wire.run(5.0)
    wire.command(dialect.MAV_CMD_NAV_LAND, 0, 0, 0, NAN, NAN, NAN, 0)
    wire.run_until(lambda: not wire.simulation.is_armed, 30.0)
    assert wire.simulation.flight.charge < 1.0
    wire.run(8.2)
    assert wire.simulation.flight.charge == 1.0


@pytest.mark.long
def test_an_old_battery_is_empty_sooner_and_sags_more() -> None:
    """Of the same charge: half the capacity takes twice the share, the sag is that of the cells."""

    def after_a_hover(battery: str) -> tuple[float, float]:
        wire = fly(f"battery: {battery}\n")
        take_off(wire, 3.0)
        begun = wire.simulation.flight.charge
        wire.run(20.0)
        state = wire.simulation.flight
        return begun - state.charge, state.voltage_v

    new, old = after_a_hover("{charge: 0.8}"), after_a_hover("{charge: 0.8, capacity: 0.5}")
    assert old[0] == pytest.approx(2 * new[0], rel=0.02)
    worn = after_a_hover("{charge: 0.8, resistance: 2}")
    ampere = 3600 * 5 * new[0] / 20.0
    assert new[1] - worn[1] == pytest.approx((0.016 + 0.010) * ampere, rel=0.15)


@pytest.mark.long
def test_a_battery_that_ages_in_flight_keeps_its_share_and_its_count() -> None:
    wire = fly("battery: {charge: 0.8}\nhappens:\n  - {at_s: 5, battery: {capacity: 0.7}}\n")
    wire.run(6.0)
    assert wire.simulation.flight.charge == pytest.approx(0.8)
    assert wire.last("BATTERY_STATUS").current_consumed == 0
    take_off(wire, 2.0)
    begun = wire.simulation.flight.charge
    counted = wire.last("BATTERY_STATUS").current_consumed
    wire.run(10.0)
    drained_mah = (begun - wire.simulation.flight.charge) * 0.7 * 5000
    assert wire.last("BATTERY_STATUS").current_consumed - counted == pytest.approx(
        drained_mah, abs=8
    )
    assert wire.last("BATTERY_STATUS").energy_consumed == -1


@pytest.mark.parametrize(("drains", "is_less"), [("armed", False), ("always", True)])
def test_a_disarmed_vehicle_drains_only_if_the_scenario_says_so(drains: str, is_less: bool) -> None:
    wire = fly(f"battery: {{charge: 0.5, drains: {drains}}}\n")
    wire.run(5.0)
    assert (wire.simulation.flight.charge < 0.5) is is_less


def test_a_step_of_charge_calls_the_failsafe_and_a_full_battery_gives_the_vehicle_back() -> None:
    """As in PX4 the action stays until somebody chooses a mode."""
    events = "  - {at_s: 20, battery: {charge: 0.06}}\n  - {at_s: 28, battery: {charge: 0.9}}\n"
    wire = fly("parameters: {COM_LOW_BAT_ACT: 2}\nhappens:\n" + events)
    take_off(wire, 3.0)
    wire.run(27.0 - wire.now_s)
    assert wire.last("BATTERY_STATUS").charge_state == CRITICAL
    assert wire.simulation.mode == "AUTO.LAND"
    wire.run(1.5)
    assert wire.simulation.mode == "AUTO.LAND"
    assert wire.set_mode("AUTO.LOITER") == [MavResult.ACCEPTED] * 2
    wire.run(8.0)
    assert wire.simulation.mode == "AUTO.LOITER"
    assert wire.simulation.is_armed


def test_no_current_is_sent_as_unknown() -> None:
    """-1 cA means "not known" in BATTERY_STATUS and SYS_STATUS."""
    wire = fly("")
    for current_a in (-0.014, -0.01, -0.006):
        wire.simulation._vehicle.state = wire.simulation.flight._replace(current_a=current_a)
        link = wire.simulation._autopilot_component._links[wire.link]
        for number in (dialect.MAVLINK_MSG_ID_BATTERY_STATUS, dialect.MAVLINK_MSG_ID_SYS_STATUS):
            assert link.request_message(number)
        assert [message.current_battery for message in link.next_step[-2:]] == [0, 0]


# -- GPS, arming, wind -----------------------------------------------------------------------------


def test_a_lost_gps_has_no_fix_and_comes_back() -> None:
    wire = fly("happens:\n  - {at_s: 2, gps: {lost: true}}\n  - {at_s: 4, gps: {lost: false}}\n")
    fixes = []
    for _ in range(3):
        wire.run(1.9)
        fixes.append(wire.last("GPS_RAW_INT").fix_type)
    assert fixes[0] >= 3 and fixes[1] <= 1 and fixes[2] >= 3


@pytest.mark.long
def test_a_noisy_gps_moves_what_is_believed() -> None:
    wire = fly("happens:\n  - {at_s: 1, gps: {noise_m: 2}}\n")
    wire.run(0.9)
    assert wire.last("LOCAL_POSITION_NED").x == pytest.approx(0.0, abs=0.01)
    wire.run(30.0)
    seen = [heard.message.x for heard in wire.named("LOCAL_POSITION_NED")]
    assert 0.3 < np.std(seen) < 4.0
    assert wire.simulation.flight.position[0] == pytest.approx(0.0, abs=0.01)


def test_arming_is_refused_with_its_reason_until_it_is_allowed() -> None:
    events = "  - {at_s: 1, arming: {refused: no blades}}\n  - {at_s: 3, arming: {allowed: true}}\n"
    wire = fly("happens:\n" + events)
    wire.run(2.0)
    assert wire.arm() == [MavResult.TEMPORARILY_REJECTED]
    assert wire.texts()[-1] == "Arming denied: no blades"
    wire.run(2.0)
    assert wire.arm() == [MavResult.ACCEPTED]


def test_wind_from_a_command_on_leans_the_vehicle() -> None:
    event = "  - {command: MAV_CMD_USER_1, component: 1, after_s: 0.5, wind: {east_mps: 8}}\n"
    wire = fly("happens:\n" + event)
    take_off(wire, 3.0)
    wire.run(3.0)
    assert wire.last("ATTITUDE").roll == pytest.approx(0.0, abs=0.01)
    wire.command(dialect.MAV_CMD_USER_1)
    wire.run(5.0)
    assert wire.last("ATTITUDE").roll < -0.05  # looking north, the left side to the wind


def test_an_obstacle_that_appears_around_the_vehicle_breaks_it_and_is_told() -> None:
    grid = OccupancyGrid(np.zeros((200, 200), dtype=np.bool_), 0.1, (-10.0, -10.0))
    crate = "map: hall.yaml\nobstacles: [{name: crate, present: false, circle: "
    crate += "{east_m: 0, north_m: 0, radius_m: 1}}]\n"
    wire = fly(crate + "happens:\n  - {at_s: 9, obstacle: {name: crate, present: true}}\n", grid)
    take_off(wire, 2.0)
    wire.run(10.0 - wire.now_s)
    assert [text for _, text in wire.simulation.event_log] == [
        "obstacle: name crate, present True",
        "Collision with a wall",
    ]
    assert not wire.simulation.is_armed
    assert wire.arm() == [MavResult.TEMPORARILY_REJECTED]


# -- obstacles and files ---------------------------------------------------------------------------

places = st.floats(-2.5, 2.5)
sizes = st.floats(0.05, 2.0)


@drawn(30)
@given(places, places, sizes, sizes, st.booleans())
def test_an_obstacle_occupies_exactly_the_cells_that_it_touches(
    north: float, east: float, height: float, width: float, is_round: bool
) -> None:
    """Against a sampling of each cell, corners and edges included."""
    grid = OccupancyGrid(np.zeros((12, 12), dtype=np.bool_), 0.5, (-3.0, -3.0))
    if is_round:
        obstacle = Obstacle("o", (north, east), (north, east), width, True)
    else:
        obstacle = Obstacle("o", (north, east), (north + height, east + width), 0.0, True)
    drawn = TrueMap(grid, [obstacle]).grid
    assert drawn is not None
    steps = np.linspace(0.0, 0.5, 51)
    for row in range(12):
        for column in range(12):
            n = (-3.0 + 0.5 * row + steps)[:, None]
            e = (-3.0 + 0.5 * column + steps)[None, :]
            if is_round:
                depth = width - np.hypot(n - north, e - east)
            else:
                depth = np.minimum(
                    np.minimum(n - north, north + height - n),
                    np.minimum(e - east, east + width - e),
                )
            if depth.max() >= 0.0:
                assert drawn.occupied[row, column]
            elif depth.max() < -0.01 * 2**0.5:  # farther than any point of the cell is sampled
                assert not drawn.occupied[row, column]


@pytest.mark.parametrize(
    "key", ["target: {component: 196", "payload: {command: MAV_CMD_USER_1, component: 196"]
)
def test_the_lidar_that_is_there_by_default_keeps_its_id(key: str) -> None:
    text = f"version: 1\nmap: hall.yaml\n{key}}}\n"
    with pytest.raises(MissionError, match="same component id 196") as caught:
        parse_scenario(text, Path("missions/a.sim.yaml"))
    assert "missions/a.sim.yaml:3:" in str(caught.value)


def test_every_key_of_a_scenario_is_described() -> None:
    schema = json_schema()
    for name, model in {"": schema, **schema["$defs"]}.items():
        for key, value in model.get("properties", {}).items():
            assert value.get("description"), f"{name}.{key}"
