"""What is there besides the vehicle, and what does it do to it?

The true map with its obstacles, the target detector, the payload, the lidar and charging pads; the
schedule of what happens; collisions. All of it knows the truth. A happening acts on the vehicle by
its physics (wind, charge), its estimate (GPS) and its autopilot (arming).
"""

from __future__ import annotations

from dataclasses import replace
from random import Random

from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid
from sitl.autopilot.autopilot import Autopilot
from sitl.flight.estimate import Estimator
from sitl.flight.physics import FlightState, Physics
from sitl.world.collision import CollisionWatch, is_wreck
from sitl.world.detector import Detector
from sitl.world.happenings import EFFECTS, Schedule
from sitl.world.lidar import Lidar
from sitl.world.obstacles import TrueMap
from sitl.world.payload import Answer, Payload
from sitl.world.scenario import Scenario


class World:
    """The world of one vehicle; `happenings.Actuators` for its scenario.

    Args:
        scenario: what is there and what happens.
        grid: of the map file, None without walls.
        physics: of the vehicle.
        estimator: what it believes.
        autopilot: of the vehicle.
        rng: of the lidar's noise.

    Attributes:
        happened: time and text of each happening so far, damage included.
        is_wreck: the vehicle has fallen over or hit the ground with its body.
        asked: MAV_CMD names that the operator is to send to the companion now; who sends them
            takes them off the list.
    """

    def __init__(
        self,
        scenario: Scenario,
        grid: OccupancyGrid | None,
        physics: Physics,
        estimator: Estimator,
        autopilot: Autopilot,
        rng: Random,
    ) -> None:
        self._physics, self._estimator, self._autopilot = physics, estimator, autopilot
        self._map = TrueMap(grid, scenario.obstacles)
        self.walls = CollisionWatch(self._map.grid)
        self.detector = Detector(scenario.detector) if scenario.detector else None
        self.payload = Payload(scenario.payload) if scenario.payload else None
        self.lidar = Lidar(scenario.lidar, self._map.grid, rng) if scenario.lidar else None
        self.happened: list[tuple[float, str]] = []
        self.is_wreck = False
        self.asked: list[str] = []
        self._schedule = Schedule(scenario.happenings, physics.state.position)
        self._pads = scenario.pads
        self._drains_always = scenario.drains_always

    def hear_command(self, command: int, component: int, now_s: float) -> None:
        """A command has arrived for a component on board, 0 for all."""
        self._schedule.hear(command, component, now_s)

    def step(self, state: FlightState) -> None:
        """Take the true state of the vehicle."""
        for happening in self._schedule.step(state.position, state.time_s):
            self.happened.append((state.time_s, happening.text))
            for kind, value in happening.effects:
                EFFECTS[kind](self, value)
        self._feed(state)
        if not self.is_wreck:
            self._look_for_damage(state)

    def _feed(self, state: FlightState) -> None:
        """What flows into the battery and out of it; in PX4's simulator it drains while armed."""
        physics, is_armed = self._physics, self._autopilot.is_armed
        is_draining = is_armed or self._drains_always
        if physics.is_draining != is_draining:
            physics.is_draining = is_draining
        if self._pads:
            charging_a = 0.0
            if not is_armed and state.is_on_ground:
                charging_a = next((a for c, a in self._pads if c.holds(state.position)), 0.0)
            if physics.charging_a != charging_a:
                physics.charging_a = charging_a

    def _look_for_damage(self, state: FlightState) -> None:
        if self.walls.update(state.position):
            self._break(state, "Collision with a wall")
        if is_wreck(state):
            self.is_wreck = True
            self._break(state, "Crash detected")

    def _break(self, state: FlightState, text: str) -> None:
        self.happened.append((state.time_s, text))
        self._autopilot.crash(text)

    # What a scenario can do; see happenings.py.

    def show_target(self, is_seen: bool) -> None:
        """The detector sees the target from now on, or does not."""
        if self.detector:
            self.detector.sees_target = is_seen

    def set_payload_answer(self, answer: Answer) -> None:
        """The payload's answer from now on, everywhere."""
        if self.payload:
            self.payload.override = answer

    def set_wind(self, wind: Ned) -> None:
        """The air's mean velocity, NED."""
        self._physics.set_wind(wind)

    def place_obstacle(self, name: str, is_present: bool) -> None:
        """Put an obstacle there or take it away."""
        if self._map.place(name, is_present):
            self.walls.grid = self._map.grid
            if self.lidar:
                self.lidar.see(self._map.grid)

    def set_charge(self, charge: float) -> None:
        """The battery's state of charge, 0 to 1."""
        self._physics.set_charge(charge)

    def set_gps(self, is_lost: bool | None, noise_m: float | None) -> None:
        """How good GPS is; None leaves it as it is."""
        gps = self._estimator.gps
        if is_lost is not None:
            gps = replace(gps, is_lost=is_lost)
        if noise_m is not None:
            gps = replace(gps, noise_m=noise_m)
        self._estimator.gps = gps

    def refuse_arming(self, reason: str | None) -> None:
        """Arming is refused for this reason; None allows it."""
        self._autopilot.refuse_arming(reason)

    def ask_companion(self, command: str) -> None:
        """The operator sends the companion a MAV_CMD."""
        self.asked.append(command)
