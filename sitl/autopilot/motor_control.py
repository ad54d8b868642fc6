"""What do the motors do, every step? The fast half of the autopilot.

In: whether the vehicle is armed, and a target. Out: motor commands. The motors idle for
COM_SPOOLUP_TIME after arming, and on the ground until the target wants to climb; otherwise the
control cascade follows the target. Take-off and landing are detected here.
"""

from __future__ import annotations

from companion.geometry import Quaternion
from sitl.autopilot.landing import LandDetector
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.situation import heading
from sitl.flight.controllers import Cascade, Limits, Target
from sitl.flight.mixer import MAX_THRUST_N, Motors
from sitl.flight.physics import FlightState

STOPPED: Motors = (0.0, 0.0, 0.0, 0.0)
CLIMB_M = 0.1  # a target this far above the vehicle wants it to leave the ground


class MotorControl:
    """The motors of one vehicle, stopped at first.

    Args:
        parameters: of the autopilot.

    Attributes:
        target: what the cascade follows, None while disarmed.
        motors: the newest commands.
    """

    def __init__(self, parameters: Parameters) -> None:
        self.target: Target | None = None
        self.motors = STOPPED
        self._parameters = parameters
        self._cascade = Cascade()
        self._landing = LandDetector()
        self._armed_s = 0.0
        self._climbs = False

    @property
    def is_landed(self) -> bool:
        """The vehicle rests on the ground."""
        return self._landing.is_landed

    @property
    def attitude_target(self) -> tuple[Quaternion, float]:
        """The attitude that is wanted, body to NED, and the thrust as a share of the most."""
        return self._cascade.attitude, self._cascade.thrust_n / (4 * MAX_THRUST_N)

    def arm(self, state: FlightState) -> None:
        """Begin to spin, with the limits of the parameters."""
        limit = self._parameters
        self._armed_s = state.time_s
        self._cascade = Cascade(
            Limits(
                speed_mps=limit["MPC_XY_VEL_MAX"],
                climb_mps=limit["MPC_Z_VEL_MAX_UP"],
                descent_mps=limit["MPC_Z_VEL_MAX_DN"],
            )
        )
        self._cascade.reset(heading(state))

    def aim(self, target: Target | None, state: FlightState) -> None:
        """Follow another target from now on; None stops the motors."""
        self.target = target
        self._climbs = target is not None and _wants_to_climb(target, state)

    def step(self, state: FlightState, dt_s: float) -> Motors:
        """Motor commands for the next step.

        Args:
            state: the newest, `dt_s` after the one before.
            dt_s: length of a step.
        """
        parameters = self._parameters
        self._landing.update(state, self._climbs, parameters["LNDMC_Z_VEL_MAX"], dt_s)
        is_spinning_up = state.time_s - self._armed_s < parameters["COM_SPOOLUP_TIME"]
        if self.target is None:
            self.motors = STOPPED
        elif is_spinning_up or (self._landing.is_touching and not self._climbs):
            self.motors = self._cascade.idle()
        else:
            self.motors = self._cascade.step(state, self.target, dt_s)
        return self.motors


def _wants_to_climb(target: Target, state: FlightState) -> bool:
    if target.position[2] is not None:
        return target.position[2] < state.position[2] - CLIMB_M
    if target.velocity[2] is not None:
        return target.velocity[2] < 0
    return target.acceleration[2] < 0
