"""The rotor constants as configured in the autopilot, at sea level.

The constants are those of `quadrotor.xml`; a test compares the two.
"""

from __future__ import annotations

MASS_KG = 1.5
THRUST_CONSTANT = 1.2916e-5  # N / (rad/s)^2
SPEED_CONSTANT = 950.0 / 16.8  # rad/s per volt at full command
IDLE_SPEED = 60.0  # rad/s
MAX_SPEED = 850.0  # rad/s, below the 950 that only a full battery gives

MIN_THRUST_N = THRUST_CONSTANT * IDLE_SPEED**2
MAX_THRUST_N = THRUST_CONSTANT * MAX_SPEED**2
IDLE_COMMAND = IDLE_SPEED / (SPEED_CONSTANT * 16.8)

Motors = tuple[float, float, float, float]
"""Motor commands 0 to 1: front right, rear left, front left, rear right."""
