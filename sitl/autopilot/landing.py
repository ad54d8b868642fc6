"""Detection of landings and take-offs.

Modelled on PX4's land detector (user guide, "Land Detector Configuration"). The evidence is how
long the vehicle has rested on the ground, or has been off it. A vehicle whose setpoint is a climb
does not rest. As in PX4, a disarmed vehicle rests wherever it is.

    state           rest of CONTACT_S   rest of LANDED_S   no rest          off it for AIRBORNE_S
    LANDED                                                 LIFTING_OFF      IN_AIR
    LIFTING_OFF     LANDED              LANDED                              IN_AIR
    IN_AIR          GROUND_CONTACT      LANDED
    GROUND_CONTACT                      LANDED             IN_AIR           IN_AIR

Ground contact stops the rotors; a landing is reported and disarms the vehicle.
"""

from __future__ import annotations

from enum import IntEnum

from sitl.flight.physics import FlightState

CONTACT_S = 0.35  # PX4: ground contact
LANDED_S = 1.0  # PX4: contact 0.35 + maybe landed 0.25 + landed 0.30, rounded up
AIRBORNE_S = 0.3


class LandState(IntEnum):
    """Landed or not, with ground contact or without."""

    LANDED = 0
    LIFTING_OFF = 1
    IN_AIR = 2
    GROUND_CONTACT = 3


class _Evidence(IntEnum):
    """The columns of the module's table."""

    CONTACT = 0
    REST = 1
    NO_REST = 2
    AIRBORNE = 3


_CONTACT, _REST, _NO_REST, _AIRBORNE = _Evidence

_TRANSITIONS: tuple[tuple[LandState, LandState, LandState, LandState], ...] = (
    (LandState.LANDED, LandState.LANDED, LandState.LIFTING_OFF, LandState.IN_AIR),
    (LandState.LANDED, LandState.LANDED, LandState.LIFTING_OFF, LandState.IN_AIR),
    (LandState.GROUND_CONTACT, LandState.LANDED, LandState.IN_AIR, LandState.IN_AIR),
    (LandState.GROUND_CONTACT, LandState.LANDED, LandState.IN_AIR, LandState.IN_AIR),
)
"""State, then evidence -> next state."""
_IS_LANDED = (True, True, False, False)
_HAS_CONTACT = (True, False, False, True)
"""For each state; looked up several times in each step of 4 ms."""


class LandDetector:
    """The state of one vehicle, landed at first.

    Attributes:
        state: after the last update.
    """

    def __init__(self) -> None:
        self.state = LandState.LANDED
        self._rest_s = LANDED_S
        self._airborne_s = 0.0

    @property
    def is_landed(self) -> bool:
        """Whether the vehicle counts as landed."""
        return _IS_LANDED[self.state]

    @property
    def has_ground_contact(self) -> bool:
        """Whether the vehicle has rested on the ground for long enough to stop the rotors."""
        return _HAS_CONTACT[self.state]

    def update(
        self,
        state: FlightState,
        is_climbing: bool,
        max_vertical_mps: float,
        dt_s: float,
        is_armed: bool = True,
    ) -> None:
        """Updates the state by a new state of the vehicle.

        Args:
            state: the newest.
            is_climbing: the setpoint is a climb.
            max_vertical_mps: a faster vehicle does not rest (LNDMC_Z_VEL_MAX).
            dt_s: time since the state before.
            is_armed: the motors may turn.
        """
        if state.is_on_ground or not is_armed:
            self._airborne_s = 0.0
            is_still = not is_climbing and abs(state.velocity[2]) <= max_vertical_mps
            is_resting = is_still or not is_armed
            self._rest_s = self._rest_s + dt_s if is_resting else 0.0
            contact = _CONTACT if self._rest_s >= CONTACT_S else _NO_REST
            evidence = _REST if self._rest_s >= LANDED_S else contact
        else:
            self._rest_s = 0.0
            self._airborne_s += dt_s
            evidence = _AIRBORNE if self._airborne_s >= AIRBORNE_S else _NO_REST
        self.state = _TRANSITIONS[self.state][evidence]
