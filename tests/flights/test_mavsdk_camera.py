"""MAVSDK as the other end of the camera protocol: its camera server makes the photos of a flight,
and its camera client makes photos with the camera of the simulator.

MAVSDK's timers run in wall time, so the flight does too.
"""

import asyncio
import socket
from collections.abc import Iterator
from typing import Any

import pytest
from lockstep import Lossy
from photo_missions import AREA, PhotoFlight, photo_mission

from companion.tick import TICK_S
from sitl.link.routing import LinkName
from sitl.simulation import Simulation
from sitl.world.scenario import read_scenario

mavsdk = pytest.importorskip("mavsdk.asyncio")
from mavsdk.asyncio.plugins.camera import CameraAsync  # noqa: E402
from mavsdk.asyncio.plugins.camera_server import CameraServerAsync  # noqa: E402
from mavsdk.plugins.camera_server.camera_server import (  # noqa: E402
    CameraFeedback,
    CaptureInfo,
    CaptureStatus,
    Information,
)

pytestmark = pytest.mark.sockets

LIMIT_S = 300.0
SHOT_S = 0.5
LOCAL = "127.0.0.1"


class Bridge:
    """Carries datagrams between one end and MAVSDK."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((LOCAL, 0))
        self._socket.setblocking(False)
        self._peer: Any = None

    @property
    def url(self) -> str:
        return f"udpout://{LOCAL}:{self._socket.getsockname()[1]}"

    def receive(self) -> list[bytes]:
        datagrams: list[bytes] = []
        while True:
            try:
                datagram, self._peer = self._socket.recvfrom(4096)
            except OSError:
                return datagrams
            datagrams.append(datagram)

    def send(self, datagrams: list[bytes]) -> None:
        for datagram in datagrams if self._peer else ():
            self._socket.sendto(datagram, self._peer)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def bridge() -> Iterator[Bridge]:
    made = Bridge()
    yield made
    made.close()


class Served:
    """MAVSDK's camera server, and how many photos it has made."""

    def __init__(self, server: Any) -> None:
        self._server = server
        self.made = 0
        self.asked: list[int] = []
        self._is_shooting = False

    async def shoot(self) -> None:
        async for sequence in self._server.subscribe_take_photo():
            self.asked.append(sequence)
            self._is_shooting = True
            await self._server.set_in_progress(True)
            await asyncio.sleep(SHOT_S)
            self.made += 1
            self._is_shooting = False
            await self._server.set_in_progress(False)
            info = CaptureInfo(is_success=True, index=sequence)
            await self._server.respond_take_photo(CameraFeedback.OK, info)

    async def tell(self) -> None:
        kinds = CaptureStatus.ImageStatus
        async for _ in self._server.subscribe_capture_status():
            image = kinds.CAPTURE_IN_PROGRESS if self._is_shooting else kinds.IDLE
            status = CaptureStatus(
                image_status=image,
                video_status=CaptureStatus.VideoStatus.IDLE,
                image_count=self.made,
            )
            await self._server.respond_capture_status(CameraFeedback.OK, status)


async def flown(flight: PhotoFlight) -> None:
    """In wall time."""
    while not flight.companion.has_ended:
        assert flight.now_s < LIMIT_S
        flight.tick()
        await asyncio.sleep(TICK_S)


async def served(bridge: Bridge, share: float, seed: int) -> None:
    configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.CAMERA)
    configuration.system_id, configuration.component_id = 1, 100
    up, down = Lossy(share, seed), Lossy(share, seed + 1)

    def to_vehicle(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        arrived = down(now_s, datagrams)
        bridge.send(arrived)
        return arrived

    def to_companion(now_s: float, datagrams: list[bytes]) -> list[bytes]:
        return up(now_s, datagrams + bridge.receive())

    async with mavsdk.Mavsdk(configuration) as client:
        await client.add_any_connection(bridge.url)
        component = await client.server_component_by_id(100)
        camera = Served(CameraServerAsync(component))
        about = Information("Seed", "peer", "1.0.0", 8.0, 6.0, 4.5, 4000, 3000)
        await camera._server.set_information(about)
        serving = [asyncio.create_task(camera.shoot()), asyncio.create_task(camera.tell())]
        flight = PhotoFlight(photo_mission(), None, up=to_companion, down=to_vehicle)
        await flown(flight)
        for task in serving:
            task.cancel()
        await asyncio.gather(*serving, return_exceptions=True)
    assert flight.exit_code == 0, flight.events
    assert camera.made == 3 and [place for _, place in flight.told] == ["A", "B", "C"]


@pytest.mark.parametrize(
    ("share", "seed"), [pytest.param(0.1, 1, marks=pytest.mark.long), (0.3, 2)]
)
def test_mavsdks_camera_makes_each_photo_once(bridge: Bridge, share: float, seed: int) -> None:
    asyncio.run(served(bridge, share, seed))


async def client_of(bridge: Bridge) -> None:
    """The simulator alone, with a camera, and MAVSDK as its ground station."""
    scenario, grid = read_scenario({"version": 1, "map": AREA, "cameras": [{"images": 4}]})
    simulation = Simulation(scenario, grid, seed=0, links=frozenset({LinkName.GCS}))
    camera = simulation._world.cameras[0]

    async def simulated() -> None:
        now_s = 0.0
        while True:
            arrived = [(LinkName.GCS, datagram) for datagram in bridge.receive()]
            bridge.send([datagram for _, datagram in simulation.step(now_s, arrived)])
            now_s += TICK_S
            await asyncio.sleep(TICK_S)

    kind = mavsdk.ComponentType.GROUND_STATION
    async with mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind)) as client:
        running = asyncio.create_task(simulated())
        await client.add_any_connection(bridge.url)
        system = await client.first_autopilot(timeout_s=LIMIT_S)
        plugin = CameraAsync(system)
        while not (cameras := (await plugin.camera_list()).cameras):
            await asyncio.sleep(0.2)
        assert [each.component_id for each in cameras] == [100]
        heard = []

        async def listen() -> None:
            async for info in plugin.subscribe_capture_info():
                heard.append((info.index, info.is_success))

        listening = asyncio.create_task(listen())
        await asyncio.sleep(0.5)
        for expected in (5, 6):
            await asyncio.wait_for(plugin.take_photo(100), LIMIT_S)
            while len(heard) < expected - 4:
                await asyncio.sleep(0.1)
            assert camera.images == expected
        for task in (listening, running):
            task.cancel()
        await asyncio.gather(listening, running, return_exceptions=True)
    assert heard == [(4, True), (5, True)]


def test_mavsdks_client_makes_photos_with_the_simulators_camera(bridge: Bridge) -> None:
    asyncio.run(asyncio.wait_for(client_of(bridge), LIMIT_S))
