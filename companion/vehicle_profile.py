"""The vehicle in numbers: its size, its speeds and how fast they change.

A mission has one profile, for planning, trajectories and the gate. The simulator has another, which
may differ from it. vehicle_files.py reads profiles from files. The defaults here are those of
missions/vehicles/quad_35cm.yaml, so that they need no file.
"""

from __future__ import annotations

from dataclasses import dataclass

DEFAULT_VEHICLE = "quad_35cm"
LEAST_MPS = 0.1
"""Least value of a top speed; a slower vehicle looks like one that the wind holds back."""


@dataclass(frozen=True, slots=True)
class VehicleProfile:
    """The numbers of one vehicle, all positive.

    Attributes:
        name: the name of its file.
        radius_m: from the centre to the farthest point of a rotor.
        margin_m: least free distance beside the vehicle, wherever it really flies.
        deviation_m: how much nearer to an obstacle than its route the vehicle may come: by tracking
            errors and on the way to a stop.
        speed_mps: top speed; a mission may allow less.
        climb_mps: top vertical speed upwards.
        descent_mps: top vertical speed downwards.
        acceleration_mps2: the acceleration of trajectories, which plans assume too.
        braking_mps2: for a stop before an obstacle that no route leads around.
        max_acceleration_mps2: limit of the vehicle's position controller.
        jerk_mps3: the jerk of trajectories.
        response_s: delay of the acceleration after its setpoint.
        feed_forward: factor on a trajectory's acceleration in setpoints.
        yaw_rate_radps: the rate of turns, on the spot and in flight.
        carrot_m: largest distance of a setpoint from the vehicle.

    >>> VehicleProfile(radius_m=0.5).clearance_m
    0.75
    """

    name: str = DEFAULT_VEHICLE
    radius_m: float = 0.35
    margin_m: float = 0.10
    deviation_m: float = 0.15
    speed_mps: float = 12.0  # PX4's MPC_XY_VEL_MAX
    climb_mps: float = 3.0  # PX4's MPC_Z_VEL_MAX_UP
    descent_mps: float = 1.5  # PX4's MPC_Z_VEL_MAX_DN
    acceleration_mps2: float = 2.0
    braking_mps2: float = 4.0
    max_acceleration_mps2: float = 5.0  # PX4's MPC_ACC_HOR_MAX
    jerk_mps3: float = 8.0  # PX4's MPC_JERK_MAX
    response_s: float = 0.15  # 1 / PX4's MC_ROLL_P
    feed_forward: float = 1.1  # PX4's MPC_XY_VEL_D_ACC takes a share of 0.2 away again
    yaw_rate_radps: float = 1.5  # 86 degrees a second; PX4's MPC_YAWRAUTO_MAX is 60
    carrot_m: float = 1.5

    @property
    def clearance_m(self) -> float:
        """Least distance of a route from the nearest obstacle."""
        return self.radius_m + self.margin_m + self.deviation_m
