"""The speed of routes, physics, MAVLink, and a whole flight."""

from __future__ import annotations

import math
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from random import Random
from statistics import median
from time import process_time
from typing import Any

import psutil
from scipy import ndimage

from benches import MISSION, ROOT, Row, timed
from companion.acting.journal import Journal, NoJournal
from companion.api.simulating import flight_of
from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flights.simulated_world import lockstep, world_of
from companion.geometry import Ned
from companion.mavlink.framing import MavlinkCodec, Message, dialect, split_frames
from companion.mavlink.signing import Signing, SigningKey
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.motion.grid import OccupancyGrid
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.range_scan import RangeScan
from companion.motion.routes import CELLS_PER_TICK
from companion.motion.sensed_map import SensedMap
from companion.planning.flight_times import route_map
from companion.run_sources.only_run import OnlyRun
from companion.vehicle.run_clocks import ClockReading
from sitl.flight.controllers import CONTROL_STEPS, Cascade, TrajectorySetpoint
from sitl.flight.physics import Physics
from sitl.link.routing import LinkName
from sitl.link.server import HOST, LOCAL_PORTS
from sitl.simulation import DT_S
from sitl.world.lidar import STEP_RAD, Lidar, LidarSpec
from sitl.world.scenario import PX4_HOME

AUTOPILOT = 1  # component id
INSTANCE = 97  # of the simulator in real time, away from any other one that runs
CRATE = (122, 172)  # its south-west cell in the hall of the surveillance
ALL = sys.maxsize  # all cells


@dataclass
class Flight:
    """A recorder that keeps what the other rows need."""

    datagrams: list[bytes] = field(default_factory=list)
    journal: Journal = field(default_factory=NoJournal)
    name: str = ""

    def report(self, stamped: Stamped) -> None:
        """Ignores events."""

    def position(self, now_s: float, position: Ned) -> None:
        """Ignores positions."""

    def clocks(self, reading: ClockReading) -> None:
        """Ignores the clocks."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Keeps the datagrams of both directions."""
        self.datagrams += datagrams


def cost_to_go(runs: int) -> Iterator[Row]:
    """The cost-to-go of a place; the peer is the distance field of the same map."""
    mission = load_mission(MISSION)
    home = mission.places["Home"].position

    def first_path_to(goal: str) -> float:
        routes = route_map(mission)  # stores what it has found
        return timed(lambda: routes.distance_m(home, goal), 1)[0]

    goals = [name for name in mission.places if name != "Home"]
    ours = median(first_path_to(goals[i % len(goals)]) for i in range(runs))
    free = ~mission.grid.occupied
    peer = median(timed(lambda: ndimage.distance_transform_edt(free), runs))
    yield Row("cost-to-go of a place", ours, "ms", "scipy's EDT", peer)
    yield repairing(mission, runs)
    yield searching(mission, runs)


def searching(mission: Mission, runs: int) -> Row:
    """The waypoint of a place moves, and the routes to it are searched in slices; longest slice."""
    routes, home = route_map(mission), mission.places["Home"].position
    north, east, down = mission.places["B"].position
    took = []
    for i in range(runs):
        routes.aim("B", (north + 0.1 * (1 + i % 2), east, down))
        parts = [timed(lambda: routes.search(home, "B", CELLS_PER_TICK), 1)]
        while not routes.search(home, "B", 0):
            parts.append(timed(lambda: routes.search(home, "B", CELLS_PER_TICK), 1))
        took.append(max(part for (part,) in parts))
    return Row("cost-to-go in parts, longest", median(took), "ms")


def repairing(mission: Mission, runs: int) -> Row:
    """A crate comes and goes, and each place's cost-to-go is repaired; the peer is a new search."""
    crate = with_crate(mission.grid)
    routes, took, new = route_map(mission), [], []
    routes.find(ALL)
    for i in range(runs):
        routes.see(mission.grid if i % 2 else crate)
        took += timed(lambda: routes.find(ALL), 1)
        fresh = route_map(mission)
        new += timed(partial(fresh.find, ALL), 1)
    each = 1 / len(mission.places)
    return Row("cost-to-go repaired", each * median(took), "ms", "a new search", each * median(new))


def with_crate(grid: OccupancyGrid) -> OccupancyGrid:
    """The hall with a crate on the route to B."""
    occupied = grid.occupied.copy()
    row, col = CRATE
    occupied[row : row + 8, col : col + 8] = True
    return OccupancyGrid(occupied, grid.cell_m, grid.origin)


def rerouting(runs: int) -> Iterator[Row]:
    """A scan shows a crate on the route: the map, its distance field, and a new route."""
    mission = load_mission(MISSION)
    start = (10.3, 12.0)  # in front of the crate
    lidar = Lidar(LidarSpec(), with_crate(mission.grid), Random(0))
    scan = RangeScan(0.0, start, lidar.scan(start, 0.0), 0.0, STEP_RAD, lidar.spec.range_m)
    took: list[float] = []
    for _ in range(runs):
        sensed, routes = SensedMap(mission.grid), route_map(mission)
        routes.route((*start, -2.0), "B")
        sensed.integrate(scan)

        def see(sensed: SensedMap = sensed, routes: LayeredRoutes = routes) -> None:
            if not sensed.integrate(scan):
                raise RuntimeError("the crate was not seen")
            routes.see(sensed.grid)
            routes.route((*start, -2.0), "B")

        took += timed(see, 1)
    yield Row("map update and new route", median(took), "ms")


def simulating(runs: int) -> Iterator[Row]:
    """Physics and control of a vehicle at 2 m height; the peer is the physics alone."""
    steps = 500 * runs
    setpoint = TrajectorySetpoint(
        position=(3.0, 4.0, -2.0), velocity=(None, None, None), yaw_rad=0.0
    )

    cascade = Cascade()

    def control(physics: Physics) -> None:
        physics.follow(cascade.step(physics.state, setpoint, CONTROL_STEPS * DT_S))

    peer = physics_speed(steps)
    ours = physics_speed(steps, control)
    yield Row("physics and control", ours, "x real time", "physics alone", peer)


def hover(physics: Physics) -> None:
    """Motor commands that nearly hold the vehicle."""
    physics.follow((0.5, 0.5, 0.5, 0.5))


def physics_speed(steps: int, control: Callable[[Physics], None] = hover) -> float:
    """Speed of the physics as a multiple of CPU time, if each state is read."""
    physics = Physics(dt_s=DT_S, origin=PX4_HOME)
    start_s = process_time()
    for i in range(steps):
        if i % CONTROL_STEPS == 0:
            control(physics)
        physics.step()
        assert physics.state
    return steps * DT_S / (process_time() - start_s)


def flying(runs: int) -> Iterator[Row]:
    """The whole mission in lockstep, as in a campaign; the peer is the physics alone.

    Then MAVLink, with the autopilot's frames of this flight.
    """
    mission, speeds, steps = load_mission(MISSION), [], 0
    for _ in range(max(1, runs // 10)):
        with flight_of(mission, world_of(mission)) as (flight, _):
            start_s = process_time()
            flight.fly()
            speeds.append(flight.now_s / (process_time() - start_s))
        if flight.companion.failure is not None:
            raise flight.companion.failure
        steps = round(flight.now_s / DT_S)
    yield Row(
        "simulator and companion in lockstep",
        median(speeds),
        "x real time",
        peer="physics alone",
        peer_figure=physics_speed(steps),
    )
    seen = Flight()
    lockstep(Companion(OnlyRun(mission, seen)), world_of(mission)).fly()
    frames = [frame for datagram in seen.datagrams for frame in split_frames(datagram)]
    yield from mavlink([f for f in frames if f[6] == AUTOPILOT], runs)
    yield from signed([f for f in frames if f[6] == AUTOPILOT], runs)


def serving(runs: int) -> Iterator[Row]:
    """`python -m sitl` in real time in flight, telemetry on both links: its share of a core."""
    seconds = min(10.0, 0.5 * runs)
    command = [sys.executable, "-m", "sitl", "-i", str(INSTANCE)]
    with (
        subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE) as sitl,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp,
    ):
        assert sitl.stdout is not None
        sitl.stdout.readline(), sitl.stdout.readline()  # the ports are open
        take_off(udp)
        process = psutil.Process(sitl.pid)
        before = process.cpu_times()
        time.sleep(seconds)
        after = process.cpu_times()
        sitl.terminate()
    used = after.user + after.system - before.user - before.system
    yield Row("sitl at real time", 100 * used / seconds, "% of a core")


def take_off(udp: socket.socket) -> None:
    """Makes the simulator on the instance's port arm and climb.

    Raises:
        RuntimeError: it did not arm within 5 s.
    """
    system = 1 + INSTANCE
    station = MavlinkCodec(255, 190)
    takeoff, arm = dialect.MAV_CMD_NAV_TAKEOFF, dialect.MAV_CMD_COMPONENT_ARM_DISARM
    for command, parameters in ((takeoff, (0, 0, 0, *(math.nan,) * 4)), (arm, (1, *(0,) * 6))):
        message = dialect.MAVLink_command_long_message(system, AUTOPILOT, command, 0, *parameters)
        udp.sendto(station.pack(message), (HOST, LOCAL_PORTS[LinkName.OFFBOARD] + INSTANCE))
    udp.settimeout(5.0)
    deadline_s = time.monotonic() + 5.0
    while time.monotonic() < deadline_s:
        for message in station.parse(udp.recv(65535)):
            if message.get_type() == "HEARTBEAT" and message.base_mode & 0x80:
                return
    raise RuntimeError("the simulator did not arm")


def mavlink(frames: list[bytes], runs: int) -> Iterator[Row]:
    """Messages per second, one frame a datagram; the peer is pymavlink's own code."""
    frames = frames[: 200 * runs]
    codec = MavlinkCodec(1, AUTOPILOT)
    plain = dialect.MAVLink(None, srcSystem=1, srcComponent=AUTOPILOT)
    messages: list[Message] = [m for frame in frames for m in codec.parse(frame)]

    def rate(call: Callable[[Any], object], items: Sequence[object]) -> float:
        return 1000 * len(items) / median(timed(lambda: [call(item) for item in items], 3))

    peer = rate(lambda message: message.pack(plain), messages)
    yield Row("pack MAVLink", rate(codec.pack, messages), "messages/s", "pymavlink", peer)
    peer = rate(plain.parse_buffer, frames)
    yield Row("parse MAVLink", rate(codec.parse, frames), "messages/s", "pymavlink", peer)


def signed(frames: list[bytes], runs: int) -> Iterator[Row]:
    """The same with signatures: packing with signing, and verifying with parsing."""
    frames = frames[: 200 * runs]
    key, codec = SigningKey(bytes(range(32))), MavlinkCodec(1, AUTOPILOT)
    messages: list[Message] = [m for frame in frames for m in codec.parse(frame)]
    arriving = Signing(key, 0.0).send(0.0, frames)

    def rate(all_of_them: Callable[[], object]) -> float:
        return 1000 * len(frames) / median(timed(all_of_them, 3))

    def pack() -> None:
        signing = Signing(key, 0.0)
        for message in messages:
            signing.send(0.0, [codec.pack(message)])

    def parse() -> None:
        signing = Signing(key, 0.0)
        for frame in arriving:
            for accepted in signing.receive(0.0, [frame]):
                codec.parse(accepted)

    def with_key() -> Any:
        plain = dialect.MAVLink(None, srcSystem=1, srcComponent=AUTOPILOT)
        plain.signing.secret_key, plain.signing.sign_outgoing = key.secret, True
        return plain

    def peer_packs() -> None:
        plain = with_key()
        for message in messages:
            message.pack(plain)

    def peer_parses() -> None:
        plain = with_key()
        for frame in arriving:
            plain.parse_buffer(frame)

    peer = rate(peer_packs)
    yield Row("pack and sign MAVLink", rate(pack), "messages/s", "pymavlink", peer)
    peer = rate(peer_parses)
    yield Row("verify and parse MAVLink", rate(parse), "messages/s", "pymavlink", peer)
