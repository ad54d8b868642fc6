"""One step of the whole simulator: datagrams in, datagrams out.

No socket and no clock: the caller passes the time and carries the datagrams, over UDP in real time
(server.py) or in lockstep with the companion in one process (harness.py). Equal arguments and
datagrams give equal answers.

The physics and the rate loop advance in steps of 4 ms. Every 20 ms the world runs, then the
messages of each component, then the autopilot's loops, which steer the next 20 ms. Answers, and
streams due in between, are sent with the state of their own 4 ms step. The autopilot and its
messages know only the estimate; the world and its devices know the truth.
"""

from __future__ import annotations

import math
from random import Random
from typing import cast

from companion.geometry import GlobalOrigin, Ned
from companion.mavlink.framing import MavlinkCodec, Message, source
from companion.mavlink.signing import Signing
from companion.motion.grid import OccupancyGrid
from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.parameters import Parameters, vehicle_defaults
from sitl.autopilot.reboot import rebooted
from sitl.autopilot.reframing import reframed
from sitl.flight.airframes import AIRFRAMES, Airframe
from sitl.flight.controllers import CONTROL_STEPS
from sitl.flight.estimate import Estimator
from sitl.flight.local_frame import LocalFrame
from sitl.flight.physics import FlightState, Physics
from sitl.flight.sensors import Sensors
from sitl.link.autopilot_component import AutopilotComponent
from sitl.link.autopilot_link import AUTOPILOT, Outgoing
from sitl.link.component_sender import PackedMessage
from sitl.link.disturbance import Disturbance
from sitl.link.on_board import components_on_board
from sitl.link.routing import LinkName, Router, target
from sitl.link.signed_links import signed, verified
from sitl.link.streams import StreamReader
from sitl.link.time_offset import TimeOffset
from sitl.link.vehicle import SimulatedVehicle
from sitl.world.faults import Direction, Reboot
from sitl.world.scenario import Scenario
from sitl.world.world import World

DT_S = 0.004
SETTLING_S, SETTLED_STEP_S = 15.0, 0.1
CONTROL_S = CONTROL_STEPS * DT_S
ALL_LINKS = frozenset(LinkName)


class Simulation:
    """One vehicle in one world.

    Args:
        scenario: the world.
        grid: the map of the world; None without walls.
        seed: the seed of everything random (gusts, sensors, the estimate, links).
        instance: the system id is 1 + instance.
        links: those with somebody at the other end; nothing is packed for the others.
        signing: the key with which all links sign, as PX4 does; None without signatures.
        reader: what reads the streams, on a link without disturbances; if it is the only receiver,
            streams that it does not read are not packed.

    Attributes:
        event_log: time and text of each scenario event that has happened.
    """

    def __init__(
        self,
        scenario: Scenario,
        grid: OccupancyGrid | None,
        *,
        seed: int,
        instance: int = 0,
        links: frozenset[LinkName] = ALL_LINKS,
        signing: Signing | None = None,
        reader: StreamReader | None = None,
    ) -> None:
        self._signing, self._reader = signing, reader
        self._system = system = 1 + instance
        self._airframe = airframe = AIRFRAMES[scenario.airframe]
        self._physics = physics = _physics(scenario, airframe, seed)
        self._truth = state = physics.state
        self._estimator = Estimator(Random(f"estimate {seed}"), wander=scenario.wander)
        self._sensors = Sensors(scenario.home, seed, state)
        own = vehicle_defaults(scenario.vehicle)
        parameters = Parameters({**own, **scenario.parameters, "MAV_SYS_ID": system})
        self._frame = LocalFrame(scenario.home, scenario.origin or scenario.home)
        estimate = self._frame.seen(self._estimator.step(state, state.time_s))
        self._autopilot = Autopilot(parameters, estimate, airframe.gains)
        self._vehicle = SimulatedVehicle(
            self._autopilot,
            estimate,
            self._frame.origin,
            self._sensors,
            physics.battery,
            self._estimator,
        )
        self._world = World(scenario, grid, physics, self._estimator, self._autopilot, seed=seed)
        self.event_log = self._world.event_log
        self._on_board = components_on_board(system, self._world, scenario, self._vehicle)
        self._local = frozenset([(system, AUTOPILOT), *(each.address for each in self._on_board)])
        self._refusals = scenario.arming_refusals
        self._links = links
        self._start_autopilot()
        self._silent_until_s = 0.0
        self._arriving, self._leaving = (
            Disturbance(direction, self._world.link_qualities, seed)
            for direction in (Direction.TO_VEHICLE, Direction.FROM_VEHICLE)
        )
        self._codecs = {link: MavlinkCodec(system, AUTOPILOT) for link in links}
        self._steps = 0

    @property
    def flight(self) -> FlightState:
        """The true state of the vehicle."""
        return self._truth

    @property
    def is_armed(self) -> bool:
        """Whether the motors turn."""
        return self._autopilot.is_armed

    @property
    def mode(self) -> str:
        """The present flight mode, by PX4's name."""
        return self._autopilot.mode

    def take_reports(self) -> list[bytes]:
        """What programs on board have reported since the last call, for the companion's port."""
        return self._world.reporter.take()

    def time_offset(self, link: LinkName) -> TimeOffset:
        """The autopilot's estimate of the offset of the clock at the other end of a link."""
        return self._autopilot_component.time_offset(link)

    @property
    def true_map(self) -> OccupancyGrid | None:
        """The walls and the obstacles that are present; None in a world without walls."""
        return self._world.collisions.grid

    @property
    def walls_beside(self) -> OccupancyGrid | None:
        """The part of the true map that can collide with the vehicle at its present height."""
        return self._world.collisions.walls(self._truth.position, self._physics.ground_up_m)

    @property
    def collisions(self) -> int:
        """The number of collisions with walls."""
        return self._world.collisions.count

    @property
    def set_down_m(self) -> float:
        """Least distance at which an obstacle has appeared beside the vehicle; inf if none."""
        return self._world.set_down_m

    @property
    def setpoint_gap_m(self) -> float | None:
        """Distance from the vehicle to its setpoint; None if it follows no setpoint."""
        is_flown = self.mode == "OFFBOARD" and self._frame.is_told(self._truth.time_s)
        setpoint = self._autopilot.setpoint if is_flown else None
        if setpoint is None or None in setpoint.position:
            return None
        return math.dist(cast(Ned, setpoint.position), self._vehicle.state.position)

    @property
    def is_damaged(self) -> bool:
        """The vehicle has hit a wall, or the ground with its body."""
        return self._autopilot.is_crashed

    def settle(self) -> None:
        """Simulates without any messages until the vehicle is disarmed and at rest.

        A vehicle left in the air may still hit something; the wait for that ends after 15 s.
        """
        end_s = self._truth.time_s + SETTLING_S
        while self._truth.time_s < end_s and not self._is_at_rest:
            self.step(self._steps * DT_S + SETTLED_STEP_S, [])

    @property
    def _is_at_rest(self) -> bool:
        is_still = self._truth.is_on_ground or self._world.is_wreck
        return is_still and not self._autopilot.is_armed

    def step(self, now_s: float, datagrams: list[tuple[LinkName, bytes]]) -> Outgoing:
        """Takes the datagrams that have arrived, then advances to a time.

        Args:
            now_s: simulated time since the start; a time before the last one advances nothing.
            datagrams: each with the link on which it arrived.

        Returns:
            Frames to send, in order, each with its link.
        """
        out: Outgoing = []
        arrived = self._arriving.step(now_s, datagrams)
        if self._signing is not None:
            arrived = verified(self._signing, now_s, arrived)
        for link, datagram in arrived:
            if link in self._codecs and not self._is_silent:
                for message in self._codecs[link].parse(datagram):
                    self._receive(link, message, out)
        out += self._autopilot_component.flush()
        self._autopilot_component.attend()
        due = int(now_s / DT_S + 1e-6)
        while self._steps < due:
            self._advance(due * DT_S, out)
        self._look()
        if self._signing is not None:
            out = signed(self._signing, now_s, out, self._local)
        return self._leaving.step(now_s, out)

    @property
    def _is_silent(self) -> bool:
        """Whether the autopilot restarts, so that nothing passes its ports."""
        return self._steps * DT_S < self._silent_until_s

    def _start_autopilot(self) -> None:
        """Creates the autopilot's end of the links, with default streams and no peer heard yet."""
        self._router = Router(self._links, self._local)
        self._autopilot_component = AutopilotComponent(
            self._system,
            self._vehicle,
            self._links,
            self._router,
            self._world.answers,
            self._refusals,
            self._reader,
        )

    def _reboot(self, reboot: Reboot) -> None:
        vehicle, now_s = self._vehicle, self._truth.time_s
        autopilot = rebooted(
            self._autopilot, vehicle.state, self._airframe.gains, recovers=reboot.recovers
        )
        self._autopilot = vehicle.autopilot = self._world.autopilot = autopilot
        vehicle.booted_s, self._silent_until_s = now_s, now_s + reboot.silent_s
        self._start_autopilot()

    def _lay_origin(self, origin: GlobalOrigin) -> None:
        """Moves the origin of the autopilot's local frame to another point on the earth."""
        vehicle, before = self._vehicle, self._vehicle.state.position
        here = origin.to_local(*self._frame.origin.to_global(before))
        by = (here[0] - before[0], here[1] - before[1], here[2] - before[2])
        self._frame.lay(origin, self._truth.time_s)
        vehicle.origin = origin
        vehicle.state = vehicle.state._replace(position=here)
        autopilot = reframed(self._autopilot, vehicle.state, self._airframe.gains, by)
        self._autopilot = vehicle.autopilot = self._world.autopilot = autopilot
        self._estimator.resets += 1

    def _receive(self, link: LinkName, message: Message, out: Outgoing) -> None:
        if source(message) in self._local:
            return  # our own frame, sent back by a forwarder
        self._router.learn(link, message)
        frame = bytes(message.get_msgbuf())
        out += [(to, frame) for to in self._router.destinations(message, link)]
        if message.get_type() in ("COMMAND_LONG", "COMMAND_INT"):
            self._note_command(message)
        self._autopilot_component.receive(link, message)
        for component in self._on_board:
            self._route(component.receive(message, self._truth), out)

    def _note_command(self, message: Message) -> None:
        system, component = target(message)
        if system in (0, self._system) and not getattr(message, "confirmation", 0):
            self._world.note_command(message.command, component, self._truth.time_s)

    def _advance(self, until_s: float, out: Outgoing) -> None:
        """Advances by one step; all that is sent during it arrives at one time."""
        if self._steps % CONTROL_STEPS == 0:
            self._physics.follow(self._autopilot.step(self._vehicle.state, CONTROL_S))
            self._autopilot_component.follow()
        if not self._world.is_wreck:
            self._physics.step()
        self._steps += 1
        if self._steps % CONTROL_STEPS == 0:
            self._act(until_s, out)
        elif self._autopilot_component.is_asked:
            self._look()
            self._speak(until_s, out)
        elif self._steps * DT_S >= self._autopilot_component.due_s:
            self._stream(until_s, out)

    def _act(self, until_s: float, out: Outgoing) -> None:
        """Runs what happens at 50 Hz."""
        state = self._truth = self._true_state()
        self._vehicle.state = self._frame.seen(self._estimator.step(state, state.time_s))
        self._autopilot.health.position_age_s = self._estimator.time_since_fix_s
        gps, fix_error = self._estimator.gps, self._estimator.fix_error
        self._sensors.step(state, gps, fix_error, ground_up_m=self._physics.ground_up_m)
        self._world.step(state)
        for reboot in self._world.take_reboots():
            self._reboot(reboot)
        for origin in self._world.take_origins():
            self._lay_origin(origin)
        self._speak(until_s, out)
        for component in self._on_board:
            said = component.step(state)
            if not self._is_silent:
                self._route(said, out)

    def _speak(self, until_s: float, out: Outgoing) -> None:
        if not self._is_silent:
            out += self._autopilot_component.step(until_s)

    def _stream(self, until_s: float, out: Outgoing) -> None:
        """Sends streams due between two autopilot steps, with the state of this step."""
        component = self._autopilot_component
        if self._is_silent or not (due := component.due(self._steps * DT_S, until_s)):
            return
        self._look()
        for link, name in due:
            link.stream(name)
        out += component.flush()

    def _look(self) -> None:
        """Reads the state of this step."""
        self._truth = self._true_state()
        self._vehicle.state = self._frame.seen(self._estimator.seen(self._truth))

    def _true_state(self) -> FlightState:
        return self._frozen_truth() if self._world.is_wreck else self._physics.state

    def _frozen_truth(self) -> FlightState:
        """The state of a wreck: only its time advances."""
        still = (0.0, 0.0, 0.0)
        return self._truth._replace(time_s=self._steps * DT_S, velocity=still, rates=still)

    def _route(self, packed: list[PackedMessage], out: Outgoing) -> None:
        for message, frame in packed:
            out += [(to, frame) for to in self._router.destinations(message, None)]


def _physics(scenario: Scenario, airframe: Airframe, seed: int) -> Physics:
    return Physics(
        dt_s=DT_S,
        origin=scenario.home,
        start=scenario.start,
        yaw_rad=scenario.yaw_rad,
        battery=scenario.battery,
        wind=scenario.wind,
        linear_drag_n_per_mps=airframe.linear_drag_n_per_mps,
        turbulence_mps=scenario.turbulence_mps,
        seed=seed,
    )
