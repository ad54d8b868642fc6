"""The pydantic models of `NAME.sim.yaml`: its keys and their values.

scenario.py converts them into the simulator's types. Unknown keys are refused. Error messages use
the field descriptions as hints.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from companion.drawn_maps import MapEntry
from companion.geometry import FAR_M
from companion.vehicle_files import VehicleEntry, VehicleKey
from sitl.world.battery_schema import BatteryEventModel, BatteryModel, PadEventModel, PadModel
from sitl.world.device_schema import (
    CameraEventModel,
    CameraModel,
    GimbalEventModel,
    GimbalModel,
    GripperEventModel,
    GripperModel,
)
from sitl.world.faults import Answer, Direction, Port
from sitl.world.marker_schema import MarkerCameraModel, MarkerEventModel
from sitl.world.schema_fields import (
    Component,
    East,
    EastSpeed,
    North,
    NorthSpeed,
    Strict,
    described,
)
from sitl.world.vary_schema import VaryEntry

ResultName = Literal["ACCEPTED", "TEMPORARILY_REJECTED", "DENIED", "FAILED"]


Result = Annotated[ResultName, described("the MAV_RESULT of the final answer")]
After = Annotated[float, described("seconds until the final answer", ge=0)]
Lost = Annotated[
    bool, described("the command is done, but its answer is lost, once for each command")
]


class StartModel(Strict):
    """Position and heading of the vehicle at the start."""

    east_m: East = 0.0
    north_m: North = 0.0
    heading_deg: Annotated[float, described("clockwise from north", ge=-360, le=360)] = 0.0


class GlobalModel(Strict):
    """A point on the earth."""

    latitude_deg: Annotated[float, described("degrees north", ge=-90, le=90)]
    longitude_deg: Annotated[float, described("degrees east", ge=-180, le=180)]
    altitude_m: Annotated[float, described("above mean sea level", ge=-500, le=9000)] = 488.0


class WindModel(Strict):
    """The air's mean velocity and its gusts."""

    east_mps: EastSpeed = 0.0
    north_mps: NorthSpeed = 0.0
    turbulence_mps: Annotated[
        float,
        described("deviation of vertical gusts; horizontal ones are twice as strong", ge=0, le=10),
    ] = 0.0


class WanderModel(Strict):
    """The errors of the estimate while GPS has a fix; those of PX4 are 0.25 m, 0.3 m/s, 0.5 m."""

    position_m: Annotated[float, described("RMS of the horizontal position", gt=0, le=5)] = 0.25
    velocity_mps: Annotated[float, described("RMS of the velocity", gt=0, le=5)] = 0.3
    height_m: Annotated[float, described("RMS of the height", ge=0, le=5)] = 0.0


class CircleModel(Strict):
    """A circle on the ground."""

    east_m: East
    north_m: North
    radius_m: Annotated[float, described("metres", gt=0, le=FAR_M)]


class VisitModel(CircleModel):
    """A visit of the vehicle to a circle."""

    visit: Annotated[int, described("the vehicle's n-th visit to the circle, from 1", ge=1)] = 1


class TargetModel(Strict):
    """The target detector."""

    component: Component = 26
    seen: Annotated[VisitModel | None, described("when the target is seen first")] = None


class SiteModel(CircleModel):
    """The payload's answer inside a circle."""

    result: Result
    after_s: After = 1.0
    lost: Lost = False


class PayloadModel(Strict):
    """The payload."""

    component: Component = 25
    command: Annotated[str, described("a MAVLink command by name, such as MAV_CMD_USER_1")]
    answers: Annotated[
        tuple[SiteModel, ...], described("the first circle that contains the vehicle answers")
    ] = ()
    otherwise: Annotated[ResultName, described("the answer outside all circles")] = "DENIED"


class LidarModel(Strict):
    """The lidar."""

    component: Component = 196
    range_m: Annotated[float, described("walls farther away are not seen", gt=0, le=600)] = 12.0
    noise_m: Annotated[float, described("deviation of each distance", ge=0, le=100)] = 0.0


class BoxModel(Strict):
    """A box with sides to the east and to the north."""

    east_m: Annotated[tuple[East, East], described("[from, to]")]
    north_m: Annotated[tuple[North, North], described("[from, to]")]


class ObstacleModel(Strict):
    """An obstacle that the mission's map does not show: a circle or a box."""

    name: Annotated[str, described("its name, for events", min_length=1)]
    circle: Annotated[CircleModel | None, described("its shape, if it is round")] = None
    box: Annotated[BoxModel | None, described("its shape, if it is a box")] = None
    present: Annotated[bool, described("whether it is there at the start")] = True


class PayloadEventModel(Strict):
    """The payload's answer from now on, everywhere."""

    result: Result = "ACCEPTED"
    after_s: After = 1.0
    silent: Annotated[bool, described("the payload does not answer at all")] = False
    lost: Lost = False
    progress: Annotated[bool, described("the payload reports its progress each second")] = False


class WindEventModel(Strict):
    """The air's mean velocity from now on."""

    east_mps: EastSpeed = 0.0
    north_mps: NorthSpeed = 0.0


class ObstacleEventModel(Strict):
    """An obstacle appears or disappears."""

    name: Annotated[str, described("the name of one of the obstacles")]
    present: Annotated[bool, described("true: it appears; false: it disappears")]


class GpsEventModel(Strict):
    """The quality of GPS from now on; keys left out change nothing."""

    lost: Annotated[bool | None, described("there is no fix")] = None
    noise_m: Annotated[float | None, described("deviation of the fix, metres", ge=0, le=100)] = None


class ArmingEventModel(Strict):
    """Arming is refused, or allowed again."""

    refused: Annotated[str | None, described("the reason, for people", min_length=1)] = None
    allowed: Annotated[Literal[True] | None, described("the refusal ends")] = None


Share = Annotated[float, described("share of the datagrams", ge=0, le=1)]
Late = Annotated[float, described("seconds", ge=0, le=60)]
Jump = Annotated[float, described("metres", ge=-FAR_M, le=FAR_M)]


class LinkEventModel(Strict):
    """How a link treats datagrams from now on; keys left out mean no disturbance."""

    port: Annotated[Port | None, described("companion: 14540; ground: 14550; default: both")] = None
    direction: Annotated[Direction | None, described("only in this direction; default: both")] = (
        None
    )
    loss: Annotated[Share, described("share of the datagrams that is lost; 1 cuts the link")] = 0.0
    doubled: Annotated[Share, described("share of the datagrams that arrives twice")] = 0.0
    delay_s: Annotated[Late, described("each datagram arrives this much later")] = 0.0
    jitter_s: Annotated[Late, described("further delay at random, up to this")] = 0.0


class EstimateEventModel(Strict):
    """The estimated position is shifted by a vector, and keeps this error."""

    east_m: Jump = 0.0
    north_m: Jump = 0.0
    up_m: Jump = 0.0


class RebootEventModel(Strict):
    """The autopilot restarts: it is disarmed, and its clock starts at 0."""

    silent_s: Annotated[float, described("seconds until it is heard again", ge=0, le=600)] = 3.0
    recovers: Annotated[bool, described("in the air: the vehicle holds and stays armed")] = False


class AnswerEventModel(Strict):
    """How the autopilot answers a command from now on."""

    command: Annotated[str, described("MAV_CMD_... to the autopilot")]
    answer: Annotated[Answer | None, described("the answer; by default the usual one")] = None


class ScenarioEventModel(Strict):
    """One trigger (`at_s`, place or command) and its effects, which happen once."""

    at_s: Annotated[float | None, described("trigger: simulated seconds", ge=0)] = None
    place: Annotated[VisitModel | None, described("trigger: a visit to a circle")] = None
    command: Annotated[str | None, described("trigger: MAV_CMD_... that arrives on board")] = None
    nth: Annotated[int | None, described("only the n-th such command", ge=1)] = None
    component: Annotated[int | None, described("the receiver of the command", ge=1, le=255)] = None
    after_s: Annotated[float, described("seconds after the trigger", ge=0)] = 0.0
    target: Annotated[
        Literal["seen", "lost"] | None, described("whether the detector sees the target")
    ] = None
    payload: Annotated[PayloadEventModel | None, described("the payload's answer from now on")] = (
        None
    )
    wind: Annotated[WindEventModel | None, described("where the air moves to from now on")] = None
    obstacle: Annotated[ObstacleEventModel | None, described("one appears or disappears")] = None
    battery: Annotated[BatteryEventModel | None, described("what changes about the battery")] = None
    pad: Annotated[PadEventModel | None, described("what changes about a pad")] = None
    gps: Annotated[GpsEventModel | None, described("GPS is lost, found or noisy")] = None
    arming: Annotated[ArmingEventModel | None, described("it is refused, or allowed again")] = None
    operator: Annotated[
        str | None, described("MAV_CMD_... that the operator sends to the companion")
    ] = None
    link: Annotated[
        LinkEventModel | None, described("it loses or delays datagrams, or is good")
    ] = None
    estimate: Annotated[EstimateEventModel | None, described("the position jumps")] = None
    origin: Annotated[GlobalModel | None, described("the origin of the local frame changes")] = None
    reboot: Annotated[RebootEventModel | None, described("the autopilot restarts")] = None
    answer: Annotated[AnswerEventModel | None, described("how the autopilot answers a command")] = (
        None
    )
    marker: Annotated[
        MarkerEventModel | None, described("a landing marker appears, disappears or moves")
    ] = None
    camera: Annotated[CameraEventModel | None, described("what changes about a camera")] = None
    gimbal: Annotated[GimbalEventModel | None, described("what changes about the gimbal")] = None
    gripper: Annotated[GripperEventModel | None, described("what changes about the gripper")] = None
    report: Annotated[
        dict[str, float | dict[str, float]] | None,
        described("{NAME: NUMBER}: a program on board reports this to the --events port, once"),
    ] = None


class ScenarioModel(Strict):
    """The whole file."""

    version: Annotated[Literal[1], described("of this format")]
    vehicle: VehicleKey = VehicleEntry()
    map: Annotated[
        str | MapEntry | None,
        described("ROS map_server YAML file, relative to this file, or an area with walls"),
    ] = None
    start: Annotated[StartModel, described("where the vehicle stands at the start")] = StartModel()
    home: Annotated[GlobalModel | None, described("the position of home on the earth")] = None
    origin: Annotated[
        GlobalModel | None, described("origin of the autopilot's local frame; by default at home")
    ] = None
    airframe: Annotated[
        Literal["quad_450", "px4_sih"],
        described("px4_sih: with the heavy drag and the gains of PX4's built-in quadrotor"),
    ] = "quad_450"
    wind: Annotated[WindModel, described("where the air moves to, and its gusts")] = WindModel()
    wander: Annotated[
        WanderModel | None, described("the estimated position wanders around the true one")
    ] = None
    battery: Annotated[BatteryModel, described("the battery at the start")] = BatteryModel()
    parameters: Annotated[
        dict[str, float], described("the autopilot's parameters that differ, by PX4's names")
    ] = {}
    target: Annotated[TargetModel | None, described("a target detector on board")] = None
    payload: Annotated[PayloadModel | None, described("a payload on board")] = None
    lidar: Annotated[
        LidarModel | None, described("on board by default if there are walls or obstacles")
    ] = None
    marker_camera: Annotated[
        MarkerCameraModel | None, described("looks down for landing markers")
    ] = None
    cameras: Annotated[tuple[CameraModel, ...], described("cameras on board")] = ()
    gimbal: Annotated[GimbalModel | None, described("a gimbal on board")] = None
    gripper: Annotated[GripperModel | None, described("a gripper on board")] = None
    obstacles: Annotated[
        tuple[ObstacleModel, ...], described("obstacles that the mission's map does not show")
    ] = ()
    pads: Annotated[
        tuple[PadModel, ...], described("circles in which the battery is charged or changed")
    ] = ()
    happens: Annotated[
        tuple[ScenarioEventModel, ...], described("what happens, and when; each once")
    ] = ()
    vary: Annotated[
        dict[str, VaryEntry],
        described("what a campaign varies: a key's path, and its range or distribution"),
    ] = {}

    @property
    def lidar_on_board(self) -> LidarModel | None:
        """The lidar: as in the file, or by default one if there is something to detect."""
        has_walls = self.map.walls if isinstance(self.map, MapEntry) else self.map
        return self.lidar or (LidarModel() if has_walls or self.obstacles else None)

    @property
    def components(self) -> tuple[tuple[tuple[str | int, ...], int], ...]:
        """For each component on board, its place in the file and its MAVLink component id."""
        parts = {
            "target": self.target,
            "payload": self.payload,
            "lidar": self.lidar_on_board,
            "marker_camera": self.marker_camera,
            "gimbal": self.gimbal,
            "gripper": self.gripper,
        }
        single = [((key,), part.component) for key, part in parts.items() if part]
        cameras = [(("cameras", i), each.component) for i, each in enumerate(self.cameras)]
        return (*single, *cameras)


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a scenario file."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **ScenarioModel.model_json_schema(),
    }
