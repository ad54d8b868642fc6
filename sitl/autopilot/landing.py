"""Does the vehicle stand on the ground or fly?

Modelled on PX4's land detector (user guide, "Land Detector Configuration"): contact for a short
time stops the rotors, contact and rest for longer is a landing; leaving the ground is believed
after a moment in the air. A vehicle that is told to climb is not landing.
"""

from __future__ import annotations

from sitl.flight.physics import FlightState

CONTACT_S = 0.35  # PX4: ground contact
LANDED_S = 1.0  # PX4: contact 0.35 + maybe landed 0.25 + landed 0.30, rounded up
AIRBORNE_S = 0.3


class LandDetector:
    """Starts landed.

    Attributes:
        is_landed: the vehicle rests on the ground.
    """

    def __init__(self) -> None:
        self.is_landed = True
        self._contact_s = LANDED_S
        self._airborne_s = 0.0

    @property
    def is_touching(self) -> bool:
        """The vehicle has been on the ground for long enough to stop the rotors."""
        return self._contact_s >= CONTACT_S

    def update(
        self, state: FlightState, is_climbing: bool, max_vertical_mps: float, dt_s: float
    ) -> None:
        """Take one more state.

        Args:
            state: the newest.
            is_climbing: the vehicle is told to go up.
            max_vertical_mps: faster is no rest (LNDMC_Z_VEL_MAX).
            dt_s: time since the state before.
        """
        if not state.is_on_ground:
            self._contact_s = 0.0
            self._airborne_s += dt_s
            if self._airborne_s >= AIRBORNE_S:
                self.is_landed = False
            return
        self._airborne_s = 0.0
        is_resting = not is_climbing and abs(state.velocity[2]) <= max_vertical_mps
        self._contact_s = self._contact_s + dt_s if is_resting else 0.0
        if self._contact_s >= LANDED_S:
            self.is_landed = True
