"""What drives the motors: the autopilot's control loops.

In: whether the vehicle is armed, and a setpoint. Out: a setpoint of the rate loop, or motor
commands. The motors idle for COM_SPOOLUP_TIME after arming, and on the ground until the setpoint is
a climb. Otherwise, the control cascade follows the setpoint. Take-offs and landings are detected
here.
a climb; otherwise the control cascade follows the setpoint. Take-off and landing are detected here.
"""

from __future__ import annotations

from companion.geometry import Quaternion
from sitl.autopilot.landing import LandDetector
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.situation import heading
from sitl.flight.controllers import (
    OWN_GAINS,
    Cascade,
    ControllerLimits,
    HorizontalGains,
    TrajectorySetpoint,
)
from sitl.flight.physics import FlightState, RateSetpoint
from sitl.flight.rotors import MAX_THRUST_N, Motors

STOPPED: Motors = (0.0, 0.0, 0.0, 0.0)
CLIMB_M = 0.1  # a setpoint this far above the vehicle is a climb


class MotorControl:
    """The motors of one vehicle, stopped at first.

    Args:
        parameters: the parameters of the autopilot.
        gains: the gains of the horizontal position loops.

    Attributes:
        setpoint: followed by the cascade, None while disarmed.
        land_detector: the detector of take-offs and landings.
    """

    def __init__(self, parameters: Parameters, gains: HorizontalGains = OWN_GAINS) -> None:
        self.setpoint: TrajectorySetpoint | None = None
        self._parameters = parameters
        self._gains = gains
        self._cascade = Cascade()
        self.land_detector = LandDetector()
        self._armed_s = 0.0
        self._is_climbing = False

    @property
    def attitude_target(self) -> tuple[Quaternion, float]:
        """The attitude setpoint, body to NED, and the thrust setpoint as a share of full thrust."""
        return self._cascade.attitude, self._cascade.thrust_n / (4 * MAX_THRUST_N)

    def arm(self, state: FlightState) -> None:
        """Starts to spin the motors, with the limits of the parameters."""
        limit = self._parameters
        self._armed_s = state.time_s
        self._cascade = Cascade(
            ControllerLimits(
                speed_mps=limit["MPC_XY_VEL_MAX"],
                climb_mps=limit["MPC_Z_VEL_MAX_UP"],
                descent_mps=limit["MPC_Z_VEL_MAX_DN"],
                acceleration_mps2=max(0.1, limit["MPC_ACC_HOR_MAX"]),  # any value may be stored
            ),
            self._gains,
        )
        self._cascade.reset(heading(state))

    def follow(self, setpoint: TrajectorySetpoint | None, state: FlightState) -> None:
        """Follows another setpoint; None stops the motors."""
        self.setpoint = setpoint
        self._is_climbing = setpoint is not None and _is_climb(setpoint, state)

    def step(self, state: FlightState, dt_s: float) -> RateSetpoint | Motors:
        """What drives the motors in the next `dt_s`.

        Args:
            state: the newest, `dt_s` after the one before.
            dt_s: time between two calls.
        """
        parameters, is_armed = self._parameters, self.setpoint is not None
        most_mps = parameters["LNDMC_Z_VEL_MAX"]
        self.land_detector.update(state, self._is_climbing, most_mps, dt_s, is_armed)
        is_spinning_up = state.time_s - self._armed_s < parameters["COM_SPOOLUP_TIME"]
        if self.setpoint is None:
            return STOPPED
        if is_spinning_up or (self.land_detector.has_ground_contact and not self._is_climbing):
            return self._cascade.idle()
        if state.is_on_ground and not self._is_climbing:
            return self._cascade.touch_down(state, self.setpoint, dt_s)
        return self._cascade.step(state, self.setpoint, dt_s)


def _is_climb(setpoint: TrajectorySetpoint, state: FlightState) -> bool:
    if setpoint.position[2] is not None:
        return setpoint.position[2] < state.position[2] - CLIMB_M
    if setpoint.velocity[2] is not None:
        return setpoint.velocity[2] < 0
    return setpoint.acceleration[2] < 0
