"""What clients ask of the autopilot besides flying: streams, parameters, requests, forwarding."""

import struct
from random import Random

import pytest
from wire import Wire, companion_heartbeat, gcs_heartbeat

from companion.mavlink.framing import MavlinkCodec, choose, dialect
from companion.mavlink.parameters import INT32, REAL32, decode, encode
from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.parameters import PARAMETERS, Parameters
from sitl.flight.estimate import Estimator
from sitl.flight.physics import Physics
from sitl.flight.sensors import Sensors
from sitl.link.messages import MESSAGE_CLASSES, MESSAGES, compose
from sitl.link.routing import LinkName
from sitl.link.streams import StreamReader, Streams
from sitl.link.vehicle import SimulatedVehicle
from sitl.simulation import Simulation
from sitl.world.scenario import Scenario

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4

# Hz of a real PX4, disarmed, over 20 s; HEARTBEAT less the forwarded ones.
MEASURED_HZ = {
    LinkName.OFFBOARD: {
        "HEARTBEAT": 1.0,
        "ALTITUDE": 9.95,
        "ATTITUDE": 99.35,
        "ATTITUDE_QUATERNION": 49.65,
        "ATTITUDE_TARGET": 9.9,
        "BATTERY_STATUS": 0.5,
        "DISTANCE_SENSOR": 9.95,
        "ESTIMATOR_STATUS": 0.95,
        "EXTENDED_SYS_STATE": 4.95,
        "GLOBAL_POSITION_INT": 49.65,
        "GPS_RAW_INT": 7.95,
        "HIGHRES_IMU": 49.65,
        "HOME_POSITION": 0.5,
        "LOCAL_POSITION_NED": 29.8,
        "MISSION_CURRENT": 0.95,
        "ODOMETRY": 29.8,
        "PING": 0.95,
        "POSITION_TARGET_LOCAL_NED": 9.9,
        "SERVO_OUTPUT_RAW": 9.95,
        "SYSTEM_TIME": 0.95,
        "SYS_STATUS": 4.95,
        "TIMESYNC": 9.95,
        "VFR_HUD": 9.9,
        "VIBRATION": 0.5,
    },
    LinkName.GCS: {
        "HEARTBEAT": 1.0,
        "ALTITUDE": 1.0,
        "ATTITUDE": 49.65,
        "ATTITUDE_QUATERNION": 49.65,
        "ATTITUDE_TARGET": 49.65,
        "BATTERY_STATUS": 0.5,
        "DISTANCE_SENSOR": 0.5,
        "ESTIMATOR_STATUS": 0.5,
        "EXTENDED_SYS_STATE": 1.0,
        "GLOBAL_POSITION_INT": 49.65,
        "GPS_RAW_INT": 5.0,
        "HOME_POSITION": 0.5,
        "LOCAL_POSITION_NED": 49.65,
        "MISSION_CURRENT": 0.95,
        "POSITION_TARGET_LOCAL_NED": 49.65,
        "SERVO_OUTPUT_RAW": 49.65,
        "PING": 0.1,
        "SYS_STATUS": 1.0,
        "VFR_HUD": 4.0,
        "VIBRATION": 0.1,
    },
}


@pytest.fixture(scope="module")
def idle() -> Wire:
    wire = Wire()
    wire.run(10.0)
    return wire


@pytest.mark.parametrize("link", list(LinkName))
def test_rates_are_those_of_px4(idle: Wire, link: LinkName) -> None:
    rates = {name: (len(idle.named(name, link)) - 1) / 10.0 for name in MEASURED_HZ[link]}
    assert rates == pytest.approx(MEASURED_HZ[link], rel=0.015, abs=0.06)


@pytest.mark.parametrize("name", MESSAGES)
def test_telemetry_has_the_bytes_of_pymavlinks_own_message(name: str) -> None:
    origin, parameters = Scenario().home, Parameters()
    physics = Physics(origin=origin)
    vehicle = SimulatedVehicle(
        Autopilot(parameters, physics.state),
        physics.state,
        origin,
        Sensors(origin, 1, physics.state),
        physics.battery,
        Estimator(Random(1)),
    )
    streamed = MavlinkCodec(1, 1).frame(MESSAGE_CLASSES[name], MESSAGES[name](vehicle))
    assert streamed == compose(name, vehicle).pack(dialect.MAVLink(None, 1, 1))


def test_everything_that_mavsdk_calls_healthy(idle: Wire) -> None:
    gyro_accel_mag_gps = 0x1 | 0x2 | 0x4 | 0x20
    health = idle.last("SYS_STATUS")
    assert health.onboard_control_sensors_present & gyro_accel_mag_gps == gyro_accel_mag_gps
    assert health.onboard_control_sensors_health & gyro_accel_mag_gps == gyro_accel_mag_gps
    assert health.onboard_control_sensors_health & 0x100000  # MAVProxy: else "fence breach"
    assert health.onboard_control_sensors_health & 0x10000000  # ready to arm
    assert idle.last("GPS_RAW_INT").fix_type == 3


def test_home_position_is_given_in_both_frames() -> None:
    wire = Wire(Scenario(start=(3.0, -2.0, 0.0)))
    wire.run(0.1)
    home = wire.last("HOME_POSITION")
    assert (home.x, home.y, home.z) == pytest.approx((3.0, -2.0, 0.0), abs=0.01)
    latitude_deg, longitude_deg, _ = Scenario().home.to_global((3.0, -2.0, 0.0))
    assert home.latitude == pytest.approx(latitude_deg * 1e7, abs=1)
    assert home.longitude == pytest.approx(longitude_deg * 1e7, abs=1)


@pytest.mark.parametrize(("interval_us", "hz"), [(50_000, 20), (-1, 0), (0, 100)])
def test_message_interval_changes_one_message_of_one_link(interval_us: float, hz: float) -> None:
    wire = Wire()
    assert wire.command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, 30, interval_us) == [ACCEPTED]
    start = {link: len(wire.named("ATTITUDE", link)) for link in LinkName}
    wire.run(2.0)
    heard = {link: len(wire.named("ATTITUDE", link)) - start[link] for link in LinkName}
    assert heard == {
        LinkName.OFFBOARD: pytest.approx(2 * hz, abs=1),
        LinkName.GCS: pytest.approx(100, abs=1),
    }


@pytest.mark.parametrize("interval_us", [1e-30, 1.0, 1e38])
def test_an_interval_of_any_size_costs_no_more_than_one_that_px4_has(interval_us: float) -> None:
    streams = Streams(LinkName.OFFBOARD, 0.0, Ear())
    streams.set_interval("ATTITUDE", interval_us, 0.0)
    streams.attend(0.0)
    streams.due(1000.0, 1000.05)
    assert streams.interval_us("ATTITUDE") >= 1_500


@pytest.mark.parametrize(("number", "result"), [(30, ACCEPTED), (60000, FAILED), (27, FAILED)])
def test_interval_of_what_is_not_streamed_fails(number: int, result: int) -> None:
    assert Wire().command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, number, 1e6) == [result]


@pytest.mark.parametrize(
    ("number", "result"), [(148, ACCEPTED), (242, ACCEPTED), (0, ACCEPTED), (65, DENIED)]
)
def test_request_message(number: int, result: int) -> None:
    wire = Wire()
    wire.run(0.5)
    before = len(wire.heard)
    assert wire.command(dialect.MAV_CMD_REQUEST_MESSAGE, number) == [result]
    sent = [h.message.get_msgId() for h in wire.heard[before:] if h.link is wire.link]
    assert (number in sent) is (result == ACCEPTED)


@pytest.mark.parametrize("number", [dialect.MAV_CMD_USER_1, 60000])
def test_unknown_commands_are_unsupported(number: int) -> None:
    assert Wire().command(number) == [UNSUPPORTED]


def test_a_command_for_another_component_is_not_answered() -> None:
    assert Wire().command(dialect.MAV_CMD_REQUEST_MESSAGE, 148, component=42) == []
    assert Wire().command(dialect.MAV_CMD_REQUEST_MESSAGE, 148, component=0) == [ACCEPTED]


def test_the_command_protocols_other_message_is_the_same_command() -> None:
    wire = Wire()
    wire.send(dialect.MAVLink_command_int_message(1, 1, 0, 512, 0, 0, 148, 0, 0, 0, 0, 0, 0))
    wire.run(0.02)
    assert wire.last("COMMAND_ACK").result == ACCEPTED
    assert wire.named("AUTOPILOT_VERSION")


def set_parameter(wire: Wire, name: str, value: float, param_type: int) -> list[float]:
    before = len(wire.named("PARAM_VALUE"))
    wire.send(
        dialect.MAVLink_param_set_message(
            1, 1, name.encode(), encode(value, param_type), param_type
        )
    )
    return [
        decode(h.message.param_value, h.message.param_type)
        for h in wire.named("PARAM_VALUE")[before:]
    ]


def test_parameters_are_set_echoed_and_read_back() -> None:
    wire = Wire()
    assert set_parameter(wire, "MIS_TAKEOFF_ALT", 6.0, REAL32) == [6.0]
    assert set_parameter(wire, "COM_OBL_RC_ACT", 3, INT32) == [3]
    assert set_parameter(wire, "MPC_XY_VEL_MAX", 500.0, REAL32) == [500.0]  # out of range: stored
    wire.send(dialect.MAVLink_param_request_read_message(1, 1, b"COM_OBL_RC_ACT", -1))
    answer = wire.last("PARAM_VALUE")
    assert decode(answer.param_value, answer.param_type) == 3
    assert answer.param_value == pytest.approx(4.2e-45)  # the integer's bytes, not 3.0


def test_unknown_parameters_are_met_with_silence() -> None:
    wire = Wire()
    assert set_parameter(wire, "NO_SUCH_PARAM", 1.0, REAL32) == []
    wire.send(dialect.MAVLink_param_request_read_message(1, 1, b"NO_SUCH_PARAM", -1))
    wire.send(dialect.MAVLink_param_request_read_message(1, 1, b"", 30000))
    assert wire.named("PARAM_VALUE") == []


def test_a_wrong_type_or_nan_leaves_the_value() -> None:
    wire = Wire()
    assert set_parameter(wire, "COM_OBL_RC_ACT", 3.0, REAL32) == [5]
    assert set_parameter(wire, "MIS_TAKEOFF_ALT", float("nan"), REAL32) == [2.5]


def test_the_list_is_complete_and_indexed() -> None:
    wire = Wire()
    wire.send(dialect.MAVLink_param_request_list_message(1, 0))
    wire.run(0.2)
    first, *listed = (h.message for h in wire.named("PARAM_VALUE"))
    assert (first.param_id, first.param_index, first.param_type) == ("_HASH_CHECK", 65535, 5)
    assert [m.param_id for m in listed] == sorted(PARAMETERS)
    assert [m.param_index for m in listed] == list(range(len(PARAMETERS)))
    assert {m.param_count for m in listed} == {len(PARAMETERS)}


def test_the_checksum_is_that_of_what_was_listed_and_follows_every_change() -> None:
    """As a ground station computes it from the list: CRC-32 without inversions."""
    wire = Wire()
    wire.send(dialect.MAVLink_param_request_list_message(1, 1))
    wire.run(0.2)
    checksum = 0
    for told in [h.message for h in wire.named("PARAM_VALUE")][1:]:
        if told.param_id not in ("COM_FLIGHT_UUID", "LND_FLIGHT_T_HI", "LND_FLIGHT_T_LO"):
            for byte in told.param_id.encode() + struct.pack("<f", told.param_value):
                checksum ^= byte
                for _ in range(8):
                    checksum = checksum >> 1 ^ (0xEDB88320 if checksum & 1 else 0)
    read = dialect.MAVLink_param_request_read_message(1, 1, b"_HASH_CHECK", -1)
    wire.send(read)
    before = wire.last("PARAM_VALUE").param_value
    assert struct.pack("<f", before) == struct.pack("<I", checksum)
    set_parameter(wire, "MIS_TAKEOFF_ALT", 6.0, REAL32)
    wire.send(read)
    assert wire.last("PARAM_VALUE").param_value != before


def test_ping_timesync_and_the_empty_mission() -> None:
    wire = Wire()
    wire.run(1.0)
    wire.send(dialect.MAVLink_ping_message(7, 3, 0, 0))
    wire.send(dialect.MAVLink_timesync_message(0, 12345))
    wire.send(dialect.MAVLink_mission_request_list_message(1, 1, 0))
    ping, sync = wire.last("PING"), wire.last("TIMESYNC")
    assert (ping.seq, ping.target_system, ping.target_component) == (3, 1, 191)
    assert (sync.ts1, sync.tc1) == (12345, 1_000_000_000)
    assert wire.last("MISSION_COUNT").count == 0


def test_texts_go_only_where_a_ground_station_was_heard() -> None:
    wire = Wire()
    wire.send(companion_heartbeat())
    wire.set_mode("POSCTL")
    wire.arm()
    assert wire.texts() == wire.texts(LinkName.GCS) == []
    wire.link = LinkName.GCS
    wire.send(gcs_heartbeat())
    wire.arm()
    assert len(wire.texts(LinkName.GCS)) == len(wire.texts(LinkName.OFFBOARD)) == 1


def test_frames_are_forwarded_unchanged_to_the_other_link_alone() -> None:
    wire = Wire()
    frame = wire.codec.pack(companion_heartbeat())
    out = wire.simulation.step(0.0, [(LinkName.OFFBOARD, frame)])
    assert out == [(LinkName.GCS, frame)]


def test_equal_inputs_give_equal_bytes() -> None:
    def flight() -> list[bytes]:
        wire = Wire(Scenario(wind=(2.0, 1.0, 0.0), turbulence_mps=0.5))
        wire.fly_offboard(1.0, 2.0, -2.0)
        return wire.frames

    assert flight() == flight()


def test_links_without_a_peer_get_nothing() -> None:
    simulation = Simulation(Scenario(), None, seed=0, links=frozenset({LinkName.OFFBOARD}))
    assert {link for link, _ in simulation.step(1.0, [])} == {LinkName.OFFBOARD}


class Ear:
    """Reads two messages, and of one of them only the newest."""

    wanted = frozenset({dialect.MAVLINK_MSG_ID_SYS_STATUS, dialect.MAVLINK_MSG_ID_ATTITUDE})
    continual = frozenset({dialect.MAVLINK_MSG_ID_ATTITUDE})


def test_of_streams_that_one_reads_alone_what_it_does_not_read_is_not_packed() -> None:
    def leaving(reader: StreamReader | None) -> list[list[bytes]]:
        offboard = frozenset({LinkName.OFFBOARD})
        simulation = Simulation(Scenario(), None, seed=0, links=offboard, reader=reader)
        return [[f for _, f in simulation.step(0.05 * i, [])] for i in range(1, 40)]

    everything = [choose(frames, Ear.wanted, Ear.continual) for frames in leaving(None)]
    packed = [choose(frames, Ear.wanted, frozenset()) for frames in leaving(Ear())]
    assert payloads(packed) == payloads(everything)
    codec = MavlinkCodec(1, 1)
    leaves = [frame for frames in leaving(Ear()) for frame in frames]
    streamed = {message.get_type() for frame in leaves for message in codec.parse(frame)}
    news = {"CURRENT_EVENT_SEQUENCE", "GPS_GLOBAL_ORIGIN"}
    assert streamed - news == {"SYS_STATUS", "ATTITUDE"}


def test_a_stream_that_is_read_again_goes_on_in_step() -> None:
    """Of 10 Hz, from half a second on."""
    ear, name = Ear(), "ATTITUDE_TARGET"
    streams, all_of_them = Streams(LinkName.OFFBOARD, 0.0, ear), Streams(LinkName.OFFBOARD)
    times_s = [0.004 * i for i in range(400)]
    sent = [all_of_them.due(time_s, time_s) for time_s in times_s]
    read = []
    for time_s in times_s:
        if time_s == 0.5:
            ear.wanted = Ear.wanted | {dialect.MAVLINK_MSG_ID_ATTITUDE_TARGET}
        streams.attend(time_s - 0.004)
        read.append(streams.due(time_s, time_s))
    assert not any(name in due for due in read[:125])
    assert [name in due for due in read[125:]] == [name in due for due in sent[125:]]
    assert sum(name in due for due in read) == 11


def test_of_a_continual_stream_only_the_last_before_a_tick_is_due() -> None:
    """ATTITUDE at 100 Hz, looked at where something is due."""
    streams = Streams(LinkName.OFFBOARD, 0.0, Ear())
    streams.attend(0.0)
    assert "ATTITUDE" not in streams.due(0.004, 0.048)
    assert streams.due_s == pytest.approx(0.04, abs=1e-5)
    assert streams.due(0.036, 0.048) == []
    assert streams.due(0.04, 0.048) == ["ATTITUDE"]
    assert streams.due_s == pytest.approx(0.05, abs=1e-5)


def payloads(steps: list[list[bytes]]) -> list[list[bytes]]:
    """Of frames without signature: what follows the sequence number, up to the checksum."""
    return [[frame[5:-2] for frame in frames] for frames in steps]


def test_a_file_that_is_not_there_is_refused_at_once_and_to_whom_asked() -> None:
    wire = Wire(address=(255, 190))
    payload = struct.pack("<HBBBBBxI", 41, 7, 4, 3, 0, 0, 99) + b"abc"
    wire.send(
        dialect.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload.ljust(251, b"\0")))
    )
    answer = wire.last("FILE_TRANSFER_PROTOCOL")
    assert (answer.target_system, answer.target_component) == (255, 190)
    told = struct.unpack_from("<HBBBBBxIB", bytes(answer.payload))
    assert told == (42, 7, 129, 1, 4, 0, 99, 10)  # sequence + 1, NAK, FileNotFound
