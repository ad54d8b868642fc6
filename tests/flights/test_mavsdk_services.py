"""MAVSDK's telemetry, parameter, action, offboard and info plugins against the simulator.

One simulator and one client serve all tests of the file, each of which ends on the ground or in
a hold. The first flight is in test_mavsdk_client.py, missions are in test_mavsdk_missions.py.
"""

import asyncio
import itertools
import math
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import pytest
from test_mavsdk_client import PHASE_S, SPEED, START_S, first, mavsdk, port, within

from companion.geometry import GlobalOrigin
from sitl.autopilot.parameters import PARAMETERS
from sitl.world.scenario import PX4_HOME

action_plugin = pytest.importorskip("mavsdk.plugins.action.action")
from mavsdk.asyncio.plugins.action import ActionAsync  # noqa: E402
from mavsdk.asyncio.plugins.info import InfoAsync  # noqa: E402
from mavsdk.asyncio.plugins.offboard import OffboardAsync  # noqa: E402
from mavsdk.asyncio.plugins.param import ParamAsync  # noqa: E402
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync  # noqa: E402
from mavsdk.plugins.offboard.offboard import (  # noqa: E402
    AccelerationNed,
    PositionGlobalYaw,
    VelocityBodyYawspeed,
    VelocityNedYaw,
)

pytestmark = pytest.mark.sockets
__all__ = ["port"]

STREAMED = (
    "altitude armed attitude_angular_velocity_body attitude_euler attitude_quaternion battery "
    "distance_sensor fixedwing_metrics flight_mode gps_info heading health health_all_ok home "
    "in_air landed_state position position_velocity_ned raw_gps velocity_ned vtol_state"
).split()
"""Streams that a ground station gets by default."""

ON_REQUEST = ("imu", "odometry", "actuator_output_status", "unix_epoch_time")
"""Streams that it gets once it asks for a rate, as from PX4."""


class Client:
    """The plugins of one vehicle."""

    def __init__(self, system: Any) -> None:
        self.action, self.telemetry = ActionAsync(system), TelemetryAsync(system)
        self.param, self.offboard = ParamAsync(system), OffboardAsync(system)
        self.info = InfoAsync(system)

    async def take_off(self, height_m: float) -> None:
        await within(self.action.set_takeoff_altitude(height_m))
        await within(self.action.arm())
        await within(self.action.takeoff())
        await first(
            self.telemetry.subscribe_position(),
            lambda p: p.relative_altitude_m > height_m - 0.4,
        )

    async def land(self) -> None:
        await within(self.action.land())
        await first(self.telemetry.subscribe_armed(), lambda is_armed: not is_armed)

    async def velocity(self, is_reached: Callable[[float, float, float], bool]) -> None:
        await first(
            self.telemetry.subscribe_velocity_ned(),
            lambda v: is_reached(v.north_m_s, v.east_m_s, v.down_m_s),
        )


@pytest.fixture
def run(port: int) -> Iterator[Callable[[Callable[[Client], Awaitable[None]]], None]]:
    async def connected(task: Callable[[Client], Awaitable[None]]) -> None:
        kind = mavsdk.ComponentType.GROUND_STATION
        async with mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind)) as client:
            await client.add_any_connection(f"udpin://127.0.0.1:{port}")
            system = await client.first_autopilot(timeout_s=START_S)
            assert system is not None
            plugins = Client(system)
            await first(plugins.telemetry.subscribe_health_all_ok(), bool)
            await task(plugins)

    yield lambda task: asyncio.run(connected(task))


Run = Callable[[Callable[[Client], Awaitable[None]]], None]


def test_every_stream_of_telemetry_gives_values(run: Run) -> None:
    async def task(client: Client) -> None:
        for name in ON_REQUEST:
            await within(getattr(client.telemetry, f"set_rate_{name}")(10.0))
        for name in (*STREAMED, *ON_REQUEST):
            await first(getattr(client.telemetry, f"subscribe_{name}")(), lambda value: True)
        battery = await within(client.telemetry.battery())
        assert 90 < battery.remaining_percent <= 100
        assert 15 < battery.voltage_v < 17
        gps = await within(client.telemetry.raw_gps())
        assert gps.latitude_deg == pytest.approx(PX4_HOME.latitude_deg, abs=1e-4)
        imu = await within(client.telemetry.imu())
        assert imu.acceleration_frd.down_m_s2 == pytest.approx(-9.81, abs=0.3)

    run(task)


def test_rates_can_be_changed(run: Run) -> None:
    async def task(client: Client) -> None:
        """Twice a second; what is heard first may have been sent before."""
        await within(client.telemetry.set_rate_attitude_euler(2.0))
        seen: list[int] = []

        def is_regular(attitude: Any) -> bool:
            seen.append(attitude.timestamp_us)
            intervals = [b - a for a, b in itertools.pairwise(seen[-5:])]
            return len(intervals) == 4 and intervals == [pytest.approx(5e5, rel=0.1)] * 4

        await first(client.telemetry.subscribe_attitude_euler(), is_regular)
        assert len(seen) < 100

    run(task)


def test_parameters_are_read_and_written(run: Run) -> None:
    async def task(client: Client) -> None:
        everything = await within(client.param.get_all_params())
        names = {p.name for p in (*everything.int_params, *everything.float_params)}
        assert names >= set(PARAMETERS)
        await within(client.param.set_param_float("MPC_XY_CRUISE", 3.0))
        await within(client.param.set_param_int("COM_LOW_BAT_ACT", 2))
        assert await within(client.param.get_param_float("MPC_XY_CRUISE")) == 3.0
        assert await within(client.param.get_param_int("COM_LOW_BAT_ACT")) == 2
        with pytest.raises(Exception, match="WRONG_TYPE"):
            await within(client.param.get_param_float("COM_LOW_BAT_ACT"))
        with pytest.raises(Exception, match="TIMEOUT"):  # as from PX4: silence
            await within(client.param.get_param_int("NO_SUCH_PARAM"))

    run(task)


def test_who_it_is(run: Run) -> None:
    async def task(client: Client) -> None:
        version = await within(client.info.get_version())
        assert (version.flight_sw_major, version.flight_sw_minor) == (1, 16)
        await within(client.info.get_identification())
        await within(client.info.get_product())
        async with asyncio.timeout(PHASE_S):  # a busy machine pauses the simulator
            while await client.info.get_speed_factor() != pytest.approx(SPEED, rel=0.2):
                await asyncio.sleep(0.1)

    run(task)


def test_places_speeds_and_modes(run: Run) -> None:
    async def task(client: Client) -> None:
        await client.take_off(5.0)
        await within(client.action.set_current_speed(3.0))
        latitude, longitude, altitude = PX4_HOME.to_global((200.0, 0.0, -7.0))
        await within(client.action.goto_location(latitude, longitude, altitude, 90.0))
        await client.velocity(lambda n, e, d: n > 2.8)
        await within(client.action.set_return_to_launch_altitude(8.0))
        assert await within(client.action.get_return_to_launch_altitude()) == 8.0
        await within(client.action.return_to_launch())
        await client.velocity(lambda n, e, d: n < 0)
        await within(client.action.hold())
        await client.velocity(lambda n, e, d: abs(n) < 0.1)
        stopped = await within(client.telemetry.position_velocity_ned())
        assert 1.0 < stopped.position.north_m < 190.0
        with pytest.raises(Exception, match="DENIED"):
            await within(client.action.disarm())
        await client.land()
        landed = await within(client.telemetry.position_velocity_ned())
        assert landed.position.north_m == pytest.approx(stopped.position.north_m, abs=0.5)

    run(task)


def test_offboard_by_velocity_acceleration_and_global_position(run: Run) -> None:
    async def task(client: Client) -> None:
        await client.take_off(5.0)
        offboard = client.offboard
        await within(offboard.set_velocity_ned(VelocityNedYaw(0.0, 2.0, 0.0, 90.0)))
        await within(offboard.start())
        await client.velocity(lambda n, e, d: abs(e - 2) < 0.1 and abs(n) < 0.1)
        await within(offboard.set_velocity_body(VelocityBodyYawspeed(-1.0, 0.0, -0.5, 0.0)))
        await client.velocity(lambda n, e, d: abs(e + 1) < 0.15 and abs(d + 0.5) < 0.15)
        await within(offboard.set_acceleration_ned(AccelerationNed(1.0, 0.0, 0.0)))
        await client.velocity(lambda n, e, d: n > 2.0)
        there = GlobalOrigin(
            PX4_HOME.latitude_deg, PX4_HOME.longitude_deg, PX4_HOME.altitude_m
        ).to_global((0.0, 0.0, -6.0))
        kind = PositionGlobalYaw.AltitudeType.AMSL
        await within(offboard.set_position_global(PositionGlobalYaw(*there, 0.0, kind)))
        await first(
            client.telemetry.subscribe_position_velocity_ned(),
            lambda p: math.hypot(p.position.north_m, p.position.east_m) < 0.3,
        )
        await within(offboard.stop())
        await client.land()

    run(task)


def test_the_motors_can_be_stopped_in_the_air(run: Run) -> None:
    async def task(client: Client) -> None:
        await client.take_off(3.0)
        await within(client.action.kill())
        await first(client.telemetry.subscribe_armed(), lambda is_armed: not is_armed)

    run(task)
