"""MAVSDK, as an authority from outside, uploads, flies and clears missions and geofences over UDP.

The simulator is a child process; simulated time runs only twice as fast, because MAVSDK's own
timers run in wall time.
"""

import asyncio
import math
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from test_mavsdk_client import START_S, first, mavsdk, port, within

from sitl.world.scenario import PX4_HOME

from mavsdk.asyncio.plugins.action import ActionAsync  # isort: skip
from mavsdk.asyncio.plugins.geofence import GeofenceAsync  # isort: skip
from mavsdk.asyncio.plugins.mission import MissionAsync  # isort: skip
from mavsdk.asyncio.plugins.mission_raw import MissionRawAsync  # isort: skip
from mavsdk.asyncio.plugins.telemetry import FlightMode, TelemetryAsync  # isort: skip
from mavsdk.plugins.geofence import geofence  # isort: skip
from mavsdk.plugins.mission.mission import MissionItem, MissionPlan  # isort: skip
from mavsdk.plugins.mission_raw import mission_raw  # isort: skip

__all__ = ["port"]

pytestmark = pytest.mark.sockets


Make = Callable[[type], Any]
"""A plugin of MAVSDK for the vehicle."""


async def connected(port: int, act: Callable[[Make], Awaitable[None]]) -> None:
    """Plugins end before their client and in this thread: MAVSDK aborts otherwise, now and then."""
    kind = mavsdk.ComponentType.GROUND_STATION
    async with mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind)) as client:
        await client.add_any_connection(f"udpin://127.0.0.1:{port}")
        system = await client.first_autopilot(timeout_s=START_S)
        assert system is not None, "no autopilot seen"
        made: list[Any] = []

        def make(plugin: type) -> Any:
            made.append(plugin(system))
            return made[-1]

        try:
            await act(make)
        finally:
            for plugin in made:
                plugin.destroy()


def has_come_to(item: int) -> Callable[[Any], bool]:
    return lambda progress: progress.current >= item


def degrees(north_m: float, east_m: float) -> tuple[float, float]:
    return PX4_HOME.to_global((north_m, east_m, 0.0))[:2]


def raw(seq: int, command: int, north_m: float, east_m: float, up_m: float) -> Any:
    lat_deg, lon_deg = degrees(north_m, east_m)
    return mission_raw.MissionItem(
        seq=seq,
        frame=6,
        command=command,
        current=int(seq == 0),
        autocontinue=1,
        param1=0.0,
        param2=1.5,
        param3=0.0,
        param4=math.nan,
        x=round(lat_deg * 1e7),
        y=round(lon_deg * 1e7),
        z=up_m,
        mission_type=0,
    )


def fields(item: Any) -> tuple[Any, ...]:
    yaw = None if math.isnan(item.param4) else item.param4
    return (item.seq, item.frame, item.command, item.param2, yaw, item.x, item.y, item.z)


async def transfer_raw(make: Make) -> None:
    plugin = make(MissionRawAsync)
    items = [raw(0, 22, 0, 0, 5), *(raw(i, 16, 3.0 * i, -2.0 * i, 5.0 + i) for i in range(1, 80))]
    await within(plugin.upload_mission(items))
    back = await within(plugin.download_mission())
    assert [fields(item) for item in back] == [fields(item) for item in items]
    progress = plugin.subscribe_mission_progress()
    await within(plugin.set_current_mission_item(7))
    assert (await first(progress, lambda p: p.current == 7)).total == 80
    await within(plugin.clear_mission())
    assert await within(plugin.download_mission()) == []


def waypoint(north_m: float, east_m: float, up_m: float, **others: Any) -> Any:
    """An item that uses all that MAVSDK makes of one: speed, gimbal, camera, a pause."""
    lat_deg, lon_deg = degrees(north_m, east_m)
    asked = {
        "speed_m_s": 4.0,
        "is_fly_through": True,
        "gimbal_pitch_deg": math.nan,
        "gimbal_yaw_deg": math.nan,
        "camera_action": MissionItem.CameraAction.NONE,
        "loiter_time_s": math.nan,
        "camera_photo_interval_s": 1.0,
        "acceptance_radius_m": math.nan,
        "yaw_deg": math.nan,
        "camera_photo_distance_m": math.nan,
        "vehicle_action": MissionItem.VehicleAction.NONE,
    } | others
    return MissionItem(lat_deg, lon_deg, up_m, **asked)


async def fly_mission(make: Make) -> None:
    mission, action, telemetry = map(make, (MissionAsync, ActionAsync, TelemetryAsync))
    await first(telemetry.subscribe_health_all_ok(), bool)
    items = [
        waypoint(8, 0, 5, gimbal_pitch_deg=-30.0, gimbal_yaw_deg=0.0),
        waypoint(8, 8, 7, camera_action=MissionItem.CameraAction.TAKE_PHOTO),
        waypoint(0, 8, 5, is_fly_through=False, loiter_time_s=1.0),
    ]
    await within(mission.set_return_to_launch_after_mission(True))
    await within(mission.upload_mission(MissionPlan(items)))
    assert len((await within(mission.download_mission())).mission_items) == len(items)
    assert not await within(mission.is_mission_finished())
    await within(action.set_return_to_launch_altitude(6.0))
    await within(action.arm())
    while await within(telemetry.flight_mode()) != FlightMode.MISSION:
        await within(mission.start_mission())  # refused while the mission is being checked
        await asyncio.sleep(0.05)
    for current in range(1, len(items) + 1):
        progress = await first(mission.subscribe_mission_progress(), has_come_to(current))
        assert progress.total == len(items)
    assert await within(mission.is_mission_finished())
    await first(telemetry.subscribe_armed(), lambda is_armed: not is_armed)
    landed = await within(telemetry.position_velocity_ned())
    assert math.hypot(landed.position.north_m, landed.position.east_m) < 0.5
    await within(mission.clear_mission())


async def transfer_fence(make: Make) -> None:
    plugin, reader = make(GeofenceAsync), make(MissionRawAsync)
    corners = [geofence.Point(*degrees(n, e)) for n, e in [(-50, -50), (-50, 50), (50, 50)]]
    polygon = geofence.Polygon(corners, geofence.FenceType.INCLUSION)
    island = geofence.Point(*degrees(0, 20))
    circle = geofence.Circle(island, 5.0, geofence.FenceType.EXCLUSION)
    await within(plugin.upload_geofence(geofence.GeofenceData([polygon], [circle])))
    stored = await within(reader.download_geofence())
    assert [(i.command, i.param1, i.mission_type) for i in stored] == [
        *[(5001, 3.0, 1)] * 3,
        (5004, 5.0, 1),
    ]
    await within(plugin.clear_geofence())
    assert await within(reader.download_geofence()) == []


@pytest.mark.parametrize("act", [transfer_raw, fly_mission, transfer_fence])
def test_mavsdk_is_content(port: int, act: Callable[[Make], Awaitable[None]]) -> None:
    asyncio.run(connected(port, act))
