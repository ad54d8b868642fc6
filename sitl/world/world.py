"""The world around the vehicle, and its effects on the vehicle.

It contains the true map with obstacles, the target detector, the payload, the lidar, the pads, the
schedule of scenario events, and collisions. All of them know the truth. An event acts on the
vehicle by its physics (wind, charge), its estimate (GPS) or its autopilot (arming). Effects on
links and on answers to commands are only stored here; link and autopilot apply them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from random import Random

from companion.geometry import GlobalOrigin, Ned
from companion.motion.grid import OccupancyGrid
from sitl.autopilot.autopilot import Autopilot
from sitl.flight.battery import BatteryChange
from sitl.flight.estimate import Estimator
from sitl.flight.physics import FlightState, Physics
from sitl.world.camera import Camera, CameraChange
from sitl.world.collision import CollisionCounter, ground_up_m, is_over_edge, is_wreck
from sitl.world.detector import TargetDetector
from sitl.world.faults import Answer, Direction, LinkQuality, Port, Reboot
from sitl.world.gimbal import Gimbal, GimbalChange
from sitl.world.gripper import Gripper, GripperChange
from sitl.world.lidar import Lidar
from sitl.world.markers import MarkerCamera, MarkerChange
from sitl.world.obstacles import TrueMap
from sitl.world.pads import PadChange, Pads
from sitl.world.payload import Payload, PayloadAnswer
from sitl.world.reporter import Reporter
from sitl.world.scenario import Scenario
from sitl.world.scenario_events import EFFECTS, EventSchedule


class World:
    """The world of one vehicle; the `EffectReceiver` of its scenario's events.

    Args:
        scenario: what exists, and its events.
        grid: the map file; None without walls.
        physics: the physics of the vehicle.
        estimator: the estimator of the vehicle.
        autopilot: the vehicle's first one.
        seed: the seed of all random parts of the world.

    Attributes:
        event_log: time and text of each event so far, damage included.
        is_wreck: the vehicle has fallen over or hit the ground with its body.
        operator_commands: MAV_CMD names that the operator has to send to the companion now; the
            sender removes them.
        autopilot: the present one; a reboot replaces it.
        link_qualities: the qualities of the links that are disturbed.
        answers: how the autopilot answers a MAV_CMD, where this differs from PX4.
        reporter: a program on board.
        set_down_m: the least distance at which an obstacle has appeared beside the vehicle.
    """

    def __init__(
        self,
        scenario: Scenario,
        grid: OccupancyGrid | None,
        physics: Physics,
        estimator: Estimator,
        autopilot: Autopilot,
        seed: int = 0,
    ) -> None:
        self._physics, self._estimator, self.autopilot = physics, estimator, autopilot
        self._map = TrueMap(grid, scenario.obstacles)
        self.collisions = CollisionCounter(self._map.grid, scenario.vehicle.radius_m)
        self.detector = TargetDetector(scenario.detector) if scenario.detector else None
        self.payload = Payload(scenario.payload) if scenario.payload else None
        lidar, camera = scenario.lidar, scenario.marker_camera
        noise = Random(f"lidar {seed}")
        self.lidar = Lidar(lidar, self._map.grid, noise) if lidar else None
        self.marker_camera = MarkerCamera(camera, Random(f"markers {seed}")) if camera else None
        self.cameras = [
            Camera(each, Random(f"camera {each.component} {seed}")) for each in scenario.cameras
        ]
        self.gimbal = Gimbal(scenario.gimbal) if scenario.gimbal else None
        self.gripper = Gripper(scenario.gripper) if scenario.gripper else None
        self.event_log: list[tuple[float, str]] = []
        self.is_wreck = False
        self.operator_commands: list[str] = []
        self._reboots: list[Reboot] = []
        self._origins: list[GlobalOrigin] = []
        self.link_qualities: dict[tuple[Port, Direction], LinkQuality] = {}
        self.answers: dict[int, Answer] = {}
        self.reporter = Reporter()
        self.set_down_m = math.inf
        self._schedule = EventSchedule(scenario.events, physics.state.position)
        self._pads = Pads(scenario.pads) if scenario.pads else None
        self._drains_always = scenario.drains_always

    def note_command(self, command: int, component: int, now_s: float) -> None:
        """Counts a command for a component on board; component 0 means all."""
        self._schedule.note_command(command, component, now_s)

    def take_reboots(self) -> list[Reboot]:
        """The reboots that have become due since the last call."""
        reboots, self._reboots = self._reboots, []
        return reboots

    def take_origins(self) -> list[GlobalOrigin]:
        """The new origins of the autopilot's local frame since the last call."""
        origins, self._origins = self._origins, []
        return origins

    def step(self, state: FlightState) -> None:
        """Takes the true state of the vehicle."""
        for event in self._schedule.step(state.position, state.time_s):
            self.event_log.append((state.time_s, event.text))
            for kind, value in event.effects:
                EFFECTS[kind](self, value)
        self._update_battery(state)
        if not self.is_wreck:
            self._detect_damage(state)
            self._lay_ground(state)

    def _update_battery(self, state: FlightState) -> None:
        """Charges and drains the battery; as in PX4's simulator, it drains while armed."""
        battery, is_armed = self._physics.battery, self.autopilot.is_armed
        is_draining = is_armed or self._drains_always
        if battery.is_draining != is_draining:
            battery.is_draining = is_draining
        if self._pads is not None:
            stands = not is_armed and state.is_on_ground
            charging_a, is_changed = self._pads.step(
                state.time_s, state.position if stands else None
            )
            if battery.charging_a != charging_a:
                battery.charging_a = charging_a
            if is_changed:
                battery.set_charge(1.0)
                self.event_log.append((state.time_s, "battery: changed"))

    def _detect_damage(self, state: FlightState) -> None:
        ground_m = self._physics.ground_up_m
        if self.collisions.update(state.position, ground_m):
            self._crash(state, "Collision with a wall")
        is_falling = is_over_edge(self._map.grid, state, ground_m)
        if is_falling or is_wreck(state, ground_m):
            self.is_wreck = True
            self._crash(state, "Over the edge of a roof" if is_falling else "Crash detected")

    def _lay_ground(self, state: FlightState) -> None:
        """Tells the physics what carries the vehicle: the ground, or the roof below it."""
        before_m = self._physics.ground_up_m
        ground_m = ground_up_m(self._map.grid, state.position, before_m)
        if ground_m != before_m:
            self._physics.ground_up_m = ground_m

    def _crash(self, state: FlightState, text: str) -> None:
        self.event_log.append((state.time_s, text))
        self.autopilot.crash(text)

    # The effects of events.

    def show_target(self, is_seen: bool) -> None:
        """Switches the detector's sighting of the target on or off."""
        if self.detector:
            self.detector.sees_target = is_seen

    def set_payload_answer(self, answer: PayloadAnswer) -> None:
        """Replaces the payload's answer everywhere."""
        if self.payload:
            self.payload.override = answer

    def set_wind(self, wind: Ned) -> None:
        """Sets the mean air velocity, NED."""
        self._physics.set_wind(wind)

    def place_obstacle(self, name: str, is_present: bool) -> None:
        """Adds or removes an obstacle."""
        if self._map.place(name, is_present):
            if is_present:
                away_m = self._map.distance_m(name, self._physics.state.position[:2])
                self.set_down_m = min(self.set_down_m, away_m)
            self.collisions.grid = self._map.grid
            if self.lidar:
                self.lidar.set_map(self._map.grid)

    def change_battery(self, change: BatteryChange) -> None:
        """Changes the battery."""
        self._physics.battery.age(change.capacity, change.resistance)
        if change.charge is not None:
            self._physics.battery.set_charge(change.charge)
        if change.is_known is not None:
            self.autopilot.health.knows_battery = change.is_known

    def change_pad(self, change: PadChange) -> None:
        """Changes a pad."""
        if self._pads is not None:
            self._pads.change(change)

    def set_gps(self, is_lost: bool | None, noise_m: float | None) -> None:
        """Sets the quality of GPS; None leaves a property as it is."""
        gps = self._estimator.gps
        if is_lost is not None:
            gps = replace(gps, is_lost=is_lost)
        if noise_m is not None:
            gps = replace(gps, noise_m=noise_m)
        self._estimator.gps = gps

    def refuse_arming(self, reason: str | None) -> None:
        """Refuses arming for a reason; None allows it."""
        self.autopilot.refuse_arming(reason)

    def report(self, values: Mapping[str, object]) -> None:
        """Lets a program on board report values to the companion."""
        self.reporter.report(values)

    def send_operator_command(self, command: str) -> None:
        """Lets the operator send a MAV_CMD to the companion."""
        self.operator_commands.append(command)

    def set_link_quality(
        self, port: Port | None, direction: Direction | None, quality: LinkQuality
    ) -> None:
        """Sets how a link treats datagrams; None as port or direction means both."""
        for each in Port if port is None else (port,):
            for towards in Direction if direction is None else (direction,):
                if quality == LinkQuality():
                    self.link_qualities.pop((each, towards), None)
                else:
                    self.link_qualities[each, towards] = quality

    def jump_estimate(self, by: Ned) -> None:
        """Shifts the estimated position by a vector, NED."""
        self._estimator.jump(by)

    def lay_origin(self, origin: GlobalOrigin) -> None:
        """Moves the origin of the autopilot's local frame."""
        self._origins.append(origin)

    def reboot(self, reboot: Reboot) -> None:
        """Restarts the autopilot."""
        self._reboots.append(reboot)

    def set_answer(self, command: int, answer: Answer | None) -> None:
        """Sets how the autopilot answers a MAV_CMD; None restores PX4's answer."""
        if answer is None:
            self.answers.pop(command, None)
        else:
            self.answers[command] = answer

    def change_marker(self, change: MarkerChange) -> None:
        """Changes a landing marker."""
        if self.marker_camera:
            self.marker_camera.change(change, self._physics.state.time_s)

    def change_camera(self, change: CameraChange) -> None:
        """Changes a camera."""
        for camera in self.cameras:
            if change.component in (None, camera.spec.component):
                camera.change(change)
                return

    def change_gimbal(self, change: GimbalChange) -> None:
        """Changes the gimbal."""
        if self.gimbal:
            self.gimbal.change(change)

    def change_gripper(self, change: GripperChange) -> None:
        """Changes the gripper."""
        if self.gripper:
            self.gripper.change(change)
