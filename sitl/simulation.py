"""All parts of the simulator in one step: datagrams in, datagrams out, nothing else.

No socket, no clock: the caller says what time it is and carries the datagrams, over UDP in real
time (server.py) or in lockstep with the companion in one process (harness.py). Equal arguments
and datagrams give equal answers.

Within a step of 4 ms: autopilot, physics, world, then what each component has to say.
"""

from __future__ import annotations

from dataclasses import replace
from random import Random

from companion.geometry import Ned
from companion.mavlink.framing import Endpoint, Message, source
from companion.motion.grid import OccupancyGrid
from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.parameters import Parameters
from sitl.flight.physics import FlightState, Physics
from sitl.link.component import AUTOPILOT, AutopilotComponent, Outgoing
from sitl.link.devices import DetectorDevice, Device, LidarDevice, PayloadDevice, Sent
from sitl.link.messages import Vehicle
from sitl.link.routing import LinkName, Router, target
from sitl.world.collision import CollisionWatch, is_wreck
from sitl.world.detector import Detector
from sitl.world.happenings import EFFECTS, Schedule
from sitl.world.lidar import Lidar
from sitl.world.obstacles import TrueMap
from sitl.world.payload import Answer, Payload
from sitl.world.scenario import Scenario

DT_S = 0.004
COLLISION_STEPS = 5  # walls are looked for every 20 ms
ALL_LINKS = frozenset(LinkName)


class Simulation:
    """One vehicle in one world.

    Args:
        scenario: the world.
        grid: its true map, None without walls.
        seed: of everything random (gusts).
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
        system = 1 + instance
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
        state = self._physics.state
        parameters = Parameters({**scenario.parameters, "MAV_SYS_ID": system})
        self._autopilot = Autopilot(parameters, state)
        self._vehicle = Vehicle(self._autopilot, state, scenario.home)
        self._map = TrueMap(grid, scenario.obstacles)
        self._detector = Detector(scenario.detector) if scenario.detector else None
        self._payload = Payload(scenario.payload) if scenario.payload else None
        self._lidar = (
            Lidar(scenario.lidar, self._map.grid, Random(f"lidar {seed}"))
            if scenario.lidar
            else None
        )
        self._devices = self._make_devices(system)
        self._schedule = Schedule(scenario.happenings, state.position)
        self._pads = scenario.pads
        self._system = system
        self.wanted_charge: float | None = None
        self.gps_is_lost, self.gps_noise_m = False, 0.0
        self.arming_refused: str | None = None
        self.happened: list[tuple[float, str]] = []
        addresses = [(system, AUTOPILOT), *(device.address for device in self._devices)]
        self._local = frozenset(addresses)
        self._router = Router(links, self._local)
        self._component = AutopilotComponent(system, self._vehicle, links, self._router)
        self._ears = {link: Endpoint(system, AUTOPILOT) for link in links}
        self._walls = CollisionWatch(self._map.grid)
        self._is_wreck = False
        self._steps = 0

    @property
    def flight(self) -> FlightState:
        """The true state of the vehicle."""
        return self._vehicle.state

    @property
    def is_armed(self) -> bool:
        """The motors turn."""
        return self._autopilot.is_armed

    @property
    def mode(self) -> str:
        """The flight mode flown now, by PX4's name."""
        return self._autopilot.mode

    @property
    def collisions(self) -> int:
        """How often the vehicle hit a wall."""
        return self._walls.count

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
            self._route(device.receive(message, self._vehicle.state), out)

    def _advance(self, out: Outgoing) -> None:
        autopilot, physics = self._autopilot, self._physics
        motors = autopilot.step(self._vehicle.state, DT_S)
        if physics.is_draining != autopilot.is_armed:
            physics.is_draining = autopilot.is_armed  # as PX4's simulator
        state = self._lie(self.flight) if self._is_wreck else physics.step(motors)
        self._vehicle.state = state
        for happening in self._schedule.step(state.position, state.time_s):
            self.happened.append((state.time_s, happening.text))
            for kind, value in happening.effects:
                EFFECTS[kind](self, value)
        if not self._is_wreck and self._steps % COLLISION_STEPS == 0:
            self._look_for_damage(state)
        out += self._component.step()
        for device in self._devices:
            self._route(device.step(state), out)

    def _look_for_damage(self, state: FlightState) -> None:
        if self._walls.update(state.position):
            self._autopilot.crash("Collision with a wall")
        if is_wreck(state):
            self._is_wreck = True
            self._autopilot.crash("Crash detected")

    def _lie(self, state: FlightState) -> FlightState:
        """A wreck: nothing but time goes on."""
        still = (0.0, 0.0, 0.0)
        return replace(state, time_s=self._steps * DT_S, velocity=still, rates=still)

    def _route(self, sent: list[Sent], out: Outgoing) -> None:
        for message, frame in sent:
            out += [(to, frame) for to in self._router.destinations(message, None)]

    def _hear_command(self, message: Message) -> None:
        system, component = target(message)
        if system in (0, self._system) and not getattr(message, "confirmation", 0):
            self._schedule.hear(message.command, component, self.flight.time_s)

    def _make_devices(self, system: int) -> list[Device]:
        devices: list[Device] = []
        if self._detector:
            devices.append(DetectorDevice(system, self._detector))
        if self._payload:
            devices.append(PayloadDevice(system, self._payload))
        if self._lidar:
            devices.append(LidarDevice(system, self._lidar))
        return devices

    # What a scenario can do to the world; see sitl/world/happenings.py.

    def show_target(self, is_seen: bool) -> None:
        """The detector sees the target from now on, or does not."""
        if self._detector:
            self._detector.sees_target = is_seen

    def set_payload_answer(self, answer: Answer) -> None:
        """The payload's answer from now on, everywhere."""
        if self._payload:
            self._payload.override = answer

    def set_wind(self, wind: Ned) -> None:
        """The air's mean velocity, NED."""
        self._physics.set_wind(wind)

    def place_obstacle(self, name: str, is_present: bool) -> None:
        """Put an obstacle there or take it away."""
        if self._map.place(name, is_present):
            self._walls.grid = self._map.grid
            if self._lidar:
                self._lidar.see(self._map.grid)

    def set_charge(self, charge: float) -> None:
        """The battery's state of charge, 0 to 1."""
        self.wanted_charge = charge

    def set_gps(self, is_lost: bool | None, noise_m: float | None) -> None:
        """How good GPS is; None leaves it as it is."""
        self.gps_is_lost = self.gps_is_lost if is_lost is None else is_lost
        self.gps_noise_m = self.gps_noise_m if noise_m is None else noise_m

    def refuse_arming(self, reason: str | None) -> None:
        """Arming is refused for this reason; None allows it."""
        self.arming_refused = reason

    @property
    def charging_a(self) -> float:
        """The current of the charging pad that the disarmed vehicle stands on; 0 without."""
        if self.is_armed or not self.flight.is_on_ground:
            return 0.0
        currents = (a for circle, a in self._pads if circle.holds(self.flight.position))
        return next(currents, 0.0)
