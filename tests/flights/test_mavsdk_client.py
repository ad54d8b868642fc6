"""MAVSDK, as an authority from outside, flies the simulator over UDP and is content with it.

The simulator is a child process, as a user would start it. MAVSDK's own timers run in wall time,
and on a busy machine it is paused for longer than an autopilot waits for setpoints, so simulated
time runs only twice as fast.
"""

import asyncio
import signal
import subprocess
import sys
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Iterator
from typing import TypeVar

import pytest
from ports import free_instance, own_ports

mavsdk = pytest.importorskip("mavsdk.asyncio")
from mavsdk.asyncio.plugins.action import ActionAsync  # noqa: E402
from mavsdk.asyncio.plugins.offboard import OffboardAsync  # noqa: E402
from mavsdk.asyncio.plugins.param import ParamAsync  # noqa: E402
from mavsdk.asyncio.plugins.telemetry import LandedState, TelemetryAsync  # noqa: E402
from mavsdk.plugins.offboard.offboard import PositionNedYaw  # noqa: E402

pytestmark = pytest.mark.sockets

SPEED = 2
PHASE_S = START_S = 300.0  # wall time that no phase of a flight and no start needs
T = TypeVar("T")


@pytest.fixture
def port() -> Iterator[int]:
    """The ground station's port of a running simulator."""
    instance = free_instance()
    command = [sys.executable, "-m", "sitl", *own_ports(instance), "--speed", str(SPEED)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        printed = child.stdout.readline() + child.stdout.readline()
        assert str(14550 + instance) in printed
        try:
            yield 14550 + instance
        finally:
            assert child.poll() is None
            child.send_signal(signal.SIGINT)
            assert child.wait(timeout=START_S) == 0


async def first(stream: AsyncIterator[T], wanted: Callable[[T], bool]) -> T:
    """The first value that is wanted; the stream is closed afterwards."""

    async def search() -> T:
        async for value in stream:
            if wanted(value):
                return value
        raise AssertionError("the stream has ended")

    try:
        return await asyncio.wait_for(search(), PHASE_S)
    finally:
        if isinstance(stream, AsyncGenerator):
            await stream.aclose()


async def within(call: Awaitable[T]) -> T:
    return await asyncio.wait_for(call, PHASE_S)


async def fly(port: int) -> None:
    kind = mavsdk.ComponentType.GROUND_STATION
    async with mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind)) as client:
        await client.add_any_connection(f"udpin://127.0.0.1:{port}")
        system = await client.first_autopilot(timeout_s=START_S)
        assert system is not None, "no autopilot seen"
        action, telemetry = ActionAsync(system), TelemetryAsync(system)
        offboard, param = OffboardAsync(system), ParamAsync(system)

        await first(telemetry.subscribe_health_all_ok(), bool)
        assert await within(param.get_param_int("COM_OBL_RC_ACT")) == 5
        await within(action.set_takeoff_altitude(4.0))
        assert await within(action.get_takeoff_altitude()) == 4.0

        await within(action.arm())
        await within(action.takeoff())
        await first(telemetry.subscribe_landed_state(), lambda s: s == LandedState.IN_AIR)
        await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m > 3.5)

        await within(offboard.set_position_ned(PositionNedYaw(5.0, -3.0, -6.0, 90.0)))
        await within(offboard.start())
        await first(
            telemetry.subscribe_position_velocity_ned(),
            lambda p: (
                abs(p.position.north_m - 5) < 0.3
                and abs(p.position.east_m + 3) < 0.3
                and abs(p.position.down_m + 6) < 0.3
            ),
        )
        await first(telemetry.subscribe_attitude_euler(), lambda a: abs(a.yaw_deg - 90) < 5)
        await within(offboard.stop())
        await within(action.hold())

        await within(action.return_to_launch())
        await first(telemetry.subscribe_armed(), lambda is_armed: not is_armed)
        landed = await within(telemetry.position_velocity_ned())
        assert abs(landed.position.north_m) < 0.5
        assert abs(landed.position.east_m) < 0.5


def test_a_mavsdk_client_flies_from_connect_to_disarm(port: int) -> None:
    asyncio.run(fly(port))
