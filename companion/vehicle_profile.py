"""The vehicle in numbers: its size, its speeds and how fast they change.

One profile for planning, trajectories and the gate of a mission, and one for the simulator, which
may differ from it. A profile is read from a file by vehicle_files.py; the defaults here are those
of missions/vehicles/quad_35cm.yaml, so that they are there without any file.
"""

from __future__ import annotations

from dataclasses import dataclass

DEFAULT_VEHICLE = "quad_35cm"
LEAST_MPS = 0.1
"""Of a greatest speed: who flies slower cannot be told from one that is held in the wind."""


@dataclass(frozen=True, slots=True)
class VehicleProfile:
    """The numbers of one vehicle, all positive.

    Attributes:
        name: of its file.
        radius_m: from the centre to the furthest point of a rotor.
        margin_m: stays free beside the vehicle, wherever it really flies.
        deviation_m: how much nearer than its route it may come to an obstacle: tracking,
            the way to a stop.
        speed_mps: greatest speed; a mission may allow less.
        climb_mps: greatest vertical speed upwards.
        descent_mps: greatest vertical speed downwards.
        acceleration_mps2: of trajectories, and of what plans reckon with.
        braking_mps2: of a stop before an obstacle that no route leads round.
        max_acceleration_mps2: that the vehicle's position controller asks for.
        jerk_mps3: of trajectories.
        response_s: how much later than it is asked for its acceleration comes.
        feed_forward: share of a trajectory's acceleration that it is told.
        yaw_rate_radps: how fast it is turned, on the spot and in flight.
        carrot_m: greatest distance of a setpoint from the vehicle.

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
