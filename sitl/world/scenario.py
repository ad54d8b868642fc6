"""The scenario file `NAME.sim.yaml`: the world in which a mission is flown.

A scenario says what the mission must not know: the true map, the wind, where a target appears, what
the payload answers, the battery's charge, and which parameters differ. Only the simulator reads it.
All keys but `version` are optional. Positions are in ENU metres from home, headings in degrees
clockwise from north; inside the simulator, everything is in local NED and radians.

    version: 1
    map: maps/hall.yaml
    vehicle: {profile: quad_35cm, radius_m: 0.4}
    start: {east_m: 2, north_m: 2, heading_deg: 90}
    wind: {east_mps: 2, north_mps: 0, turbulence_mps: 0.3}
    target: {component: 26, seen: {east_m: 5, north_m: 13, radius_m: 0.8, visit: 2}}
    payload:
      command: MAV_CMD_USER_1
      answers:
        - {east_m: 9, north_m: 4, radius_m: 1, result: FAILED, after_s: 2}
    obstacles:
      - {name: crate, circle: {east_m: 6, north_m: 6, radius_m: 0.5}, present: false}
    happens:
      - {at_s: 30, obstacle: {name: crate, present: true}}

This module is a door: it opens the file, its map and its vehicle profile. A scenario may also be
given as text or as data.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from companion.documents import (
    Document,
    DocumentReading,
    Given,
    Source,
    begin_reading,
    did_you_mean,
    read_source,
)
from companion.drawn_maps import MapEntry, drawn_map, walls_of
from companion.errors import Location, MissionError
from companion.geometry import GlobalOrigin, Ned, ned_from_enu
from companion.maps import read_map
from companion.mavlink.parameters import INT32, encode
from companion.motion.grid import OccupancyGrid
from companion.vehicle_files import read_vehicle
from companion.vehicle_profile import VehicleProfile
from sitl.autopilot.parameters import PARAMETERS
from sitl.flight.battery import NEW, BatterySpec
from sitl.flight.estimate import Wander
from sitl.results import MavResult
from sitl.world.battery_schema import battery, pads
from sitl.world.camera import CameraSpec
from sitl.world.device_schema import camera, gimbal, gripper
from sitl.world.gimbal import GimbalSpec
from sitl.world.gripper import GripperSpec
from sitl.world.lidar import LidarSpec
from sitl.world.marker_schema import marker_camera
from sitl.world.markers import MarkerCameraSpec
from sitl.world.obstacles import Obstacle, TrueMap
from sitl.world.pads import PadSpec
from sitl.world.payload import PayloadAnswer, PayloadScript, PayloadSite
from sitl.world.reading import DEVICES, command_number, read_events, read_obstacles
from sitl.world.scenario_events import ScenarioEvent, VisitTrigger
from sitl.world.schema import GlobalModel, PayloadModel, ScenarioModel
from sitl.world.vary import Data, Factor, read_factors
from sitl.world.visits import Circle

DEFAULT_MAP = "the default map"
_AREA = "write east_m and north_m: [from, to], or neither: it spans walls and obstacles then"
PX4_HOME = GlobalOrigin(47.397742, 8.545594, 488.0)  # PX4's default in SITL: Irchelpark, Zurich


@dataclass(frozen=True, slots=True)
class Scenario:
    """A world; the default is an empty one.

    Attributes:
        home: where the world's local NED (0, 0, 0) lies.
        origin: where the autopilot's own origin lies; None means at home.
        vehicle: its true properties, which may differ from the mission's.
        start: first position of the vehicle.
        yaw_rad: its first heading.
        airframe: a key of `AIRFRAMES`.
        wander: errors of the estimate; None means none.
        wind: the air's mean velocity, NED.
        battery: the pack at the start.
        drains_always: the battery also drains while disarmed.
        parameters: values that differ from the airframe's.
        detector: component id of the target detector; None means none.
        lidar: None means none.
        marker_camera: the camera for landing markers; None means neither camera nor markers.
        cameras: those that take photos.
        gimbal, gripper: None means none.
        pads: on which the battery is charged or exchanged.
        events: in the order of the file.
        map: its file or its content; None is a world without walls, unless the caller gives a map.
        factors: what a campaign varies.
    """

    home: GlobalOrigin = PX4_HOME
    vehicle: VehicleProfile = field(default_factory=VehicleProfile)
    start: Ned = (0.0, 0.0, 0.0)
    yaw_rad: float = 0.0
    airframe: str = "quad_450"
    wander: Wander | None = None
    wind: Ned = (0.0, 0.0, 0.0)
    turbulence_mps: float = 0.0
    battery: BatterySpec = NEW
    drains_always: bool = False
    parameters: Mapping[str, float] = field(default_factory=dict)
    detector: int | None = None
    payload: PayloadScript | None = None
    lidar: LidarSpec | None = None
    obstacles: tuple[Obstacle, ...] = ()
    pads: tuple[PadSpec, ...] = ()
    events: tuple[ScenarioEvent, ...] = ()
    origin: GlobalOrigin | None = None
    map: Path | MapEntry | None = None
    marker_camera: MarkerCameraSpec | None = None
    cameras: tuple[CameraSpec, ...] = ()
    gimbal: GimbalSpec | None = None
    gripper: GripperSpec | None = None
    factors: tuple[Factor, ...] = ()

    @property
    def disturbs_links(self) -> bool:
        """Whether any event disturbs links (loses, delays, doubles datagrams) or restarts the
        autopilot.
        """
        kinds = {key for event in self.events for key, _ in event.effects}
        return not kinds.isdisjoint({"link", "reboot"})

    @property
    def met_obstacles(self) -> tuple[Obstacle, ...]:
        """Obstacles that are present at the start, or that some event adds."""
        told = [value for event in self.events for key, value in event.effects if key == "obstacle"]
        appear = {value.name for value in told if value.present}
        return tuple(each for each in self.obstacles if each.is_present or each.name in appear)

    @property
    def arming_refusals(self) -> tuple[str, ...]:
        """The reasons for which its events refuse arming."""
        values = [v for event in self.events for key, v in event.effects if key == "arming"]
        return tuple(value.refused for value in values if value.refused is not None)


def read_scenario(
    given: Given | Source,
    default_home: GlobalOrigin = PX4_HOME,
    default_map: OccupancyGrid | None = None,
) -> tuple[Scenario, OccupancyGrid | None]:
    """Reads a scenario and its map.

    Args:
        given: path of the file, to which the path of its map is relative; or YAML text; or data.
        default_home: home, if the scenario does not say it.
        default_map: the map, if the scenario names none.

    Raises:
        MissionError: a file cannot be read, or its content is invalid.
    """
    source = given if isinstance(given, Source) else read_source(given, "scenario")
    has_walls = default_map is not None and bool(default_map.occupied.any())
    stands_in = DEFAULT_MAP if has_walls else MapEntry()
    scenario, document = _parse(source, default_home, stands_in if default_map else None)
    grid = _grid(scenario, document) or default_map
    now = TrueMap(grid, scenario.obstacles).grid
    radius_m = scenario.vehicle.radius_m
    if now and now.at(0.0).clearance_m(scenario.start[:2]) < radius_m:
        raise MissionError(
            "the start lies in a wall or an obstacle, too near one, or off the map",
            document.where("start"),
            f"the vehicle needs {radius_m} m around it",
        )
    return scenario, grid


def parse_scenario(text: str, path: Path) -> Scenario:
    """The scenario of a text; opens no map, but opens the file of a vehicle profile.

    Raises:
        MissionError: with the place in the file.
    """
    return _parse(Source(text, str(path), path.parent, path), PX4_HOME)[0]


def _parse(
    source: Source, default_home: GlobalOrigin, default_map: str | MapEntry | None = None
) -> tuple[Scenario, Document]:
    if isinstance(source.content, str) and re.search(r"^(skills|task):", source.content, re.M):
        hint = "the world in which MISSION.yaml is flown is MISSION.sim.yaml (docs/scenario.md)"
        raise MissionError("the file is a mission, and no world", Location(source.name, 1, 1), hint)
    model, document, reading = begin_reading(
        source.content, source.name, ScenarioModel, {("version",): 1}
    )
    if model.map is None and default_map is None and model.obstacles:
        model = model.model_copy(update={"map": MapEntry()})  # an open field
    map_ = source.folder / model.map if isinstance(model.map, str) else model.map
    if map_ is None:
        model = model.model_copy(update={"map": default_map})
    checked = _checked(model, source.folder, document, reading)
    reading.tell()

    def varied(data: Data) -> None:
        scenario, its = _parse(replace(source, content=data, path=None), default_home, default_map)
        if isinstance(scenario.map, MapEntry):
            _grid(scenario, its)

    start, home, wind = model.start, model.home, model.wind
    lidar = model.lidar_on_board
    scenario = replace(
        checked,
        home=_on_earth(home) if home else default_home,
        start=ned_from_enu(start.east_m, start.north_m, 0.0),
        yaw_rad=math.radians(start.heading_deg),
        airframe=model.airframe,
        wander=Wander(**model.wander.model_dump()) if model.wander else None,
        wind=ned_from_enu(wind.east_mps, wind.north_mps, 0.0),
        turbulence_mps=wind.turbulence_mps,
        battery=battery(model.battery),
        drains_always=model.battery.drains == "always",
        detector=model.target.component if model.target else None,
        lidar=LidarSpec(lidar.component, lidar.range_m, lidar.noise_m) if lidar else None,
        events=_first_sighting(model) + checked.events,
        origin=_on_earth(model.origin) if model.origin else None,
        map=map_,
        cameras=tuple(map(camera, model.cameras)),
        gripper=gripper(model.gripper) if model.gripper else None,
        factors=read_factors(model.vary, document, varied),
    )
    return scenario, document


def _checked(
    model: ScenarioModel, folder: Path, document: Document, reading: DocumentReading
) -> Scenario:
    """The parts of a scenario that can be invalid; those that are invalid are left out."""
    for name, value in model.parameters.items():
        reading.read(("parameters", name), _check_parameter, name, value, document)
    if all(map(reading.is_whole, DEVICES)):
        reading.check(_check_components, model, document)
    vehicle = reading.read(("vehicle",), read_vehicle, model.vehicle, folder, document)
    payload = markers = pointed = None
    if model.payload:
        payload = reading.read(("payload",), _payload, model.payload, document)
    if model.marker_camera:
        keys = ("marker_camera",)
        markers = reading.read(keys, marker_camera, model.marker_camera, document)
    if model.gimbal:
        pointed = reading.read(("gimbal",), gimbal, model.gimbal, document)
    obstacles = read_obstacles(model, document, reading)
    charging = reading.read(("pads",), pads, model.pads, document)
    events = read_events(model, document, reading)
    return Scenario(
        vehicle=vehicle or VehicleProfile(),
        parameters=dict(model.parameters),
        payload=payload,
        obstacles=obstacles,
        pads=charging or (),
        events=events,
        marker_camera=markers,
        gimbal=pointed,
    )


def _on_earth(place: GlobalModel) -> GlobalOrigin:
    return GlobalOrigin(place.latitude_deg, place.longitude_deg, place.altitude_m)


def _grid(scenario: Scenario, document: Document) -> OccupancyGrid | None:
    """The map that a scenario names or draws; without an area, it spans all that stands there."""
    map_ = scenario.map
    try:
        if not isinstance(map_, MapEntry):
            return read_map(map_) if map_ else None
        walls = walls_of(map_)
        corners = [corner for wall in walls for corner in wall.corners]
        corners += [corner for obstacle in scenario.obstacles for corner in obstacle.corners]
        if (map_.east_m is None) != (map_.north_m is None):
            missing = "east_m" if map_.east_m is None else "north_m"
            raise MissionError(f"the map has no {missing}", hint=_AREA)
        return drawn_map(map_, walls, corners or [scenario.start[:2]])
    except MissionError as error:
        where = error.where or document.where("map")
        raise MissionError(error.what, where, error.hint) from error


def _first_sighting(model: ScenarioModel) -> tuple[ScenarioEvent, ...]:
    """The event that the key `target: {seen: ...}` stands for."""
    seen = model.target.seen if model.target else None
    if seen is None:
        return ()
    trigger = VisitTrigger(Circle((seen.north_m, seen.east_m), seen.radius_m), seen.visit)
    return (ScenarioEvent(trigger, (("target", "seen"),), "target: seen"),)


def _check_components(model: ScenarioModel, document: Document) -> None:
    owners: dict[int, tuple[str | int, ...]] = {}
    for keys, component in model.components:
        if component in owners:
            first = owners[component]
            said = keys if keys[0] in model.model_fields_set else first
            names = [" ".join(map(str, each)) for each in (first, keys)]
            raise MissionError(
                f"{' and '.join(names)} have the same component id {component}",
                document.where(*said, "component"),
                "each component on board needs an id of its own",
            )
        owners[component] = keys


def _check_parameter(name: str, value: float, document: Document) -> None:
    if name not in PARAMETERS:
        raise MissionError(
            f"the autopilot has no parameter {name}",
            document.key_at("parameters", name),
            did_you_mean(name, PARAMETERS),
        )
    param_type, _ = PARAMETERS[name]
    try:
        encode(value, param_type)
    except ValueError as error:
        raise MissionError(
            f"{value:g} does not fit the parameter {name}",
            document.where("parameters", name),
            "a whole number of 32 bits" if param_type == INT32 else "a number of single precision",
        ) from error


def _payload(model: PayloadModel, document: Document) -> PayloadScript:
    command = command_number(model.command, document, "payload", "command")
    sites = tuple(
        PayloadSite(
            (site.north_m, site.east_m),
            site.radius_m,
            PayloadAnswer(MavResult[site.result], site.after_s, is_lost=site.lost),
        )
        for site in model.answers
    )
    return PayloadScript(model.component, command, sites, MavResult[model.otherwise])
