"""All parts of the simulator in one step: datagrams in, datagrams out, nothing else.

No socket, no clock: the caller says what time it is and carries the datagrams, over UDP in real
time (server.py) or in lockstep with the companion in one process (harness.py). Equal arguments
and datagrams give equal answers.

Within a step of 4 ms: autopilot, physics, world, then what each component has to say. The autopilot
and what it tells know the estimate alone; the world and its devices know the truth.
"""

from __future__ import annotations

from random import Random

from companion.mavlink.framing import MavlinkCodec, Message, source
from companion.motion.grid import OccupancyGrid
from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.parameters import Parameters
from sitl.flight.estimate import Estimator
from sitl.flight.physics import FlightState, Physics
from sitl.flight.sensors import Sensors
from sitl.link.component import AUTOPILOT, AutopilotComponent, Outgoing
from sitl.link.devices import (
    DetectorDevice,
    Device,
    LidarDevice,
    OperatorDevice,
    PayloadDevice,
    Sent,
)
from sitl.link.routing import LinkName, Router, target
from sitl.link.vehicle import Vehicle
from sitl.world.scenario import Scenario
from sitl.world.world import World

DT_S = 0.004
WORLD_STEPS = 5  # the world acts, and devices speak, every 20 ms
ALL_LINKS = frozenset(LinkName)


class Simulation:
    """One vehicle in one world.

    Args:
        scenario: the world.
        grid: its map, None without walls.
        seed: of everything random (gusts, sensors, the estimate).
        instance: the system id is 1 + instance.
        links: those with somebody at the other end; nothing is packed for the others.

    Attributes:
        happened: time and text of each happening of the scenario so far.
    """

    def __init__(
        self,
        scenario: Scenario,
        grid: OccupancyGrid | None,
        *,
        seed: int,
        instance: int = 0,
        links: frozenset[LinkName] = ALL_LINKS,
    ) -> None:
        self._system = system = 1 + instance
        self._physics = Physics(
            dt_s=DT_S,
            origin=scenario.home,
            start=scenario.start,
            yaw_rad=scenario.yaw_rad,
            charge=scenario.charge,
            wind=scenario.wind,
            turbulence_mps=scenario.turbulence_mps,
            seed=seed,
        )
        self._truth = state = self._physics.state
        self._estimator = Estimator(Random(f"estimate {seed}"))
        self._sensors = Sensors(scenario.home, Random(f"sensors {seed}"), state)
        parameters = Parameters({**scenario.parameters, "MAV_SYS_ID": system})
        self._autopilot = Autopilot(parameters, state)
        self._vehicle = Vehicle(
            self._autopilot, state, scenario.home, self._sensors, self._physics.battery
        )
        self._world = World(
            scenario,
            grid,
            self._physics,
            self._estimator,
            self._autopilot,
            Random(f"lidar {seed}"),
        )
        self.happened = self._world.happened
        self._devices = _devices(system, self._world)
        if any(kind == "operator" for h in scenario.happenings for kind, _ in h.effects):
            self._devices.append(OperatorDevice(system, self._world.asked))
        addresses = [(system, AUTOPILOT), *(device.address for device in self._devices)]
        self._local = frozenset(addresses)
        self._router = Router(links, self._local)
        self._component = AutopilotComponent(system, self._vehicle, links, self._router)
        self._ears = {link: MavlinkCodec(system, AUTOPILOT) for link in links}
        self._steps = 0

    @property
    def flight(self) -> FlightState:
        """The true state of the vehicle."""
        return self._truth

    @property
    def is_armed(self) -> bool:
        """The motors turn."""
        return self._autopilot.is_armed

    @property
    def mode(self) -> str:
        """The flight mode flown now, by PX4's name."""
        return self._autopilot.mode

    @property
    def true_map(self) -> OccupancyGrid | None:
        """The walls and the obstacles that are there now; None is a world without walls."""
        return self._world.walls.grid

    @property
    def collisions(self) -> int:
        """How often the vehicle hit a wall."""
        return self._world.walls.count

    def step(self, now_s: float, datagrams: list[tuple[LinkName, bytes]]) -> Outgoing:
        """Take what has arrived, then go on to a time.

        Args:
            now_s: simulated time since the start; an earlier one than before moves nothing.
            datagrams: with the link on which each arrived.

        Returns:
            Frames to send, in order, each with its link.
        """
        out: Outgoing = []
        for link, datagram in datagrams:
            if link in self._ears:
                for message in self._ears[link].parse(datagram):
                    self._receive(link, message, out)
        out += self._component.flush()
        due = int(now_s / DT_S + 1e-6)
        while self._steps < due:
            self._steps += 1
            self._advance(out)
        return out

    def _receive(self, link: LinkName, message: Message, out: Outgoing) -> None:
        if source(message) in self._local:
            return  # our own, sent back by somebody who forwards
        self._router.hear(link, message)
        frame = bytes(message.get_msgbuf())
        out += [(to, frame) for to in self._router.destinations(message, link)]
        if message.get_type() in ("COMMAND_LONG", "COMMAND_INT"):
            self._hear_command(message)
        self._component.receive(link, message)
        for device in self._devices:
            self._route(device.receive(message, self._truth), out)

    def _hear_command(self, message: Message) -> None:
        system, component = target(message)
        if system in (0, self._system) and not getattr(message, "confirmation", 0):
            self._world.hear_command(message.command, component, self._truth.time_s)

    def _advance(self, out: Outgoing) -> None:
        motors = self._autopilot.step(self._vehicle.state, DT_S)
        state = self._lie() if self._world.is_wreck else self._physics.step(motors)
        self._truth = state
        self._vehicle.state = self._estimator.step(state, state.time_s)
        self._autopilot.position_age_s = self._estimator.position_lost_s
        self._sensors.step(state, self._estimator.gps, self._estimator.fix_error)
        is_worlds_turn = self._steps % WORLD_STEPS == 0
        if is_worlds_turn:
            self._world.step(state)
        out += self._component.step()
        if is_worlds_turn:
            for device in self._devices:
                self._route(device.step(state), out)

    def _lie(self) -> FlightState:
        """A wreck: nothing but time goes on."""
        still = (0.0, 0.0, 0.0)
        return self._truth._replace(time_s=self._steps * DT_S, velocity=still, rates=still)

    def _route(self, sent: list[Sent], out: Outgoing) -> None:
        for message, frame in sent:
            out += [(to, frame) for to in self._router.destinations(message, None)]


def _devices(system: int, world: World) -> list[Device]:
    devices: list[Device] = []
    if world.detector:
        devices.append(DetectorDevice(system, world.detector))
    if world.payload:
        devices.append(PayloadDevice(system, world.payload))
    if world.lidar:
        devices.append(LidarDevice(system, world.lidar))
    return devices
