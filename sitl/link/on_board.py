"""The components on board of a vehicle, from its scenario and its world."""

from __future__ import annotations

from sitl.link.camera_component import CameraComponent
from sitl.link.component_sender import OnboardComponent
from sitl.link.gimbal_component import GimbalComponent
from sitl.link.gripper_component import GripperComponent
from sitl.link.marker_camera import MarkerCameraComponent
from sitl.link.onboard_components import (
    DetectorComponent,
    LidarComponent,
    OperatorComponent,
    PayloadComponent,
)
from sitl.link.vehicle import SimulatedVehicle
from sitl.world.scenario import Scenario
from sitl.world.world import World


def components_on_board(
    system: int, world: World, scenario: Scenario, vehicle: SimulatedVehicle
) -> list[OnboardComponent]:
    """All components beside the autopilot, in the order in which they send."""
    components: list[OnboardComponent] = []
    if world.detector:
        components.append(DetectorComponent(system, world.detector))
    if world.payload:
        components.append(PayloadComponent(system, world.payload))
    if world.lidar:
        components.append(LidarComponent(system, world.lidar))
    for camera in world.cameras:
        components.append(CameraComponent(system, camera, scenario.home))
    if world.gimbal:
        components.append(GimbalComponent(system, world.gimbal))
    if world.gripper:
        components.append(GripperComponent(system, world.gripper))
    if world.marker_camera:
        components.append(MarkerCameraComponent(system, world.marker_camera, vehicle))
    if any(kind == "operator" for event in scenario.events for kind, _ in event.effects):
        components.append(OperatorComponent(system, world.operator_commands))
    return components
