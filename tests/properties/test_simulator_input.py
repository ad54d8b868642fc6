"""Whatever arrives, the simulator goes on and its telemetry stays finite."""

import math
from typing import Any

from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.framing import MavlinkCodec, dialect
from sitl.link.commands import COMMANDS
from sitl.link.routing import LinkName
from sitl.simulation import Simulation
from sitl.world.scenario import Scenario

SENDER = MavlinkCodec(1, 191)
number = st.one_of(
    st.sampled_from([0.0, 1.0, -1.0, 3.0, 6.0, 21196.0, math.nan, math.inf, -math.inf, 1e30]),
    st.floats(width=32),
)
int32 = st.integers(-(2**31), 2**31 - 1)
byte = st.integers(0, 255)
commands = st.builds(
    dialect.MAVLink_command_long_message,
    st.sampled_from([0, 1]),
    st.sampled_from([0, 1]),
    st.sampled_from([*COMMANDS, 31010]),
    byte,
    *[number] * 7,
)
command_ints = st.builds(
    dialect.MAVLink_command_int_message,
    st.just(1),
    st.just(1),
    byte,
    st.sampled_from(list(COMMANDS)),
    byte,
    byte,
    *[number] * 4,
    int32,
    int32,
    number,
)
setpoints = st.builds(
    dialect.MAVLink_set_position_target_local_ned_message,
    st.just(0),
    st.just(1),
    st.just(1),
    st.sampled_from([1, 8]),
    st.integers(0, 4095),
    *[number] * 11,
)
parameters = st.builds(
    dialect.MAVLink_param_set_message,
    st.just(1),
    st.just(1),
    st.sampled_from([b"MPC_ACC_HOR", b"MPC_XY_VEL_MAX", b"RTL_CONE_ANG", b"NAV_ACC_RAD", b"\xff"]),
    number,
    st.sampled_from([0, 6, 9, 10]),
)
datagrams = st.one_of(
    st.binary(max_size=300),
    st.one_of(commands, command_ints, setpoints, parameters).map(lambda m: SENDER.pack(m)),
)


@drawn(40)
@given(st.lists(datagrams, max_size=8))
def test_any_datagrams_leave_a_flying_simulator(received: list[bytes]) -> None:
    simulation = Simulation(Scenario(), None, seed=0)
    arm = dialect.MAVLink_command_long_message(1, 1, 400, 0, 1, 21196, 0, 0, 0, 0, 0)
    takeoff = dialect.MAVLink_command_long_message(1, 1, 22, 0, *[math.nan] * 7)
    simulation.step(0.0, [(LinkName.OFFBOARD, SENDER.pack(m)) for m in (takeoff, arm)])
    simulation.step(2.0, [])
    out: list[tuple[LinkName, bytes]] = []
    for i, datagram in enumerate(received):
        out += simulation.step(2.1 + 0.1 * i, [(LinkName.OFFBOARD, datagram)])
    out += simulation.step(4.0, [])
    assert all(map(math.isfinite, simulation.flight.position))
    ear = MavlinkCodec(0, 0)
    heard: list[Any] = [m for _, frame in out for m in ear.parse(frame)]
    assert any(m.get_type() == "HEARTBEAT" for m in heard)
