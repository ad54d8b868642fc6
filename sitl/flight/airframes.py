"""The airframes that a scenario may choose: their drag and their controllers' gains.

Source of `px4_sih`: PX4 1.16, its simulation-in-hardware quadrotor (SIH_KDV, 1 N per m/s at 1 kg)
and the defaults of mc_pos_control. Only the drag per mass is taken from there; all else is our own
vehicle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sitl.flight.controllers import OWN_GAINS, HorizontalGains


@dataclass(frozen=True, slots=True)
class Airframe:
    """A row of `AIRFRAMES`.

    Attributes:
        linear_drag_n_per_mps: the linear drag of the body.
        gains: the gains of the horizontal position loops.
    """

    linear_drag_n_per_mps: float = 0.0
    gains: HorizontalGains = OWN_GAINS


AIRFRAMES: dict[str, Airframe] = {
    "quad_450": Airframe(),
    "px4_sih": Airframe(1.0, HorizontalGains(0.95, 1.8, 0.4, math.radians(45), is_gentle=False)),
}
"""By the names that scenarios use; the first one is the default."""
