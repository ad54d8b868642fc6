"""Estimates the drag of the vehicle in flight, so that the companion can feed it forward.

Without a feed-forward of drag a vehicle lags behind: PX4's controller builds up the thrust against
drag from a position error, and does so again in each turn. PX4's built-in simulated quadrotor (1
/s) lags by half a metre, and swings out of its turns by as much.

In level flight the thrust carries the weight. Its horizontal part accelerates the vehicle or
overcomes drag:

    g tan(tilt) = dv/dt + k (v - w)

with the drag k per mass and the wind w. Over windows of a second this is linear in (k, k w), and a
Kalman filter with three states estimates them. The wind may change. The filter begins without drag,
and never forgets k, which is a property of the vehicle. Errors of the estimated velocity, 0.3 m/s,
are noise.

Left out: quadratic drag. At the speeds of a mission its slope is part of k.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast

WINDOW_S = 1.0
GAP_S = 0.3
"""A window with a longer gap between measurements is not used."""
NOISE_MPS = 0.2
"""Standard deviation of a window's equation, from errors of the velocity, in one direction."""
UNKNOWN_PER_S, UNKNOWN_MPS2 = 0.5, 0.5
"""Standard deviations of the drag, and of the wind's part, before anything is known."""
CHANGE_MPS2 = 0.05
"""Standard deviation of the change of the wind's part from window to window."""
MOST_PER_S = 1.5


class DragEstimate:
    """What is known of the drag of one vehicle."""

    def __init__(self) -> None:
        self._mean = np.zeros(3)  # drag, and the wind's part north and east
        self._covariance = np.diag([UNKNOWN_PER_S**2, UNKNOWN_MPS2**2, UNKNOWN_MPS2**2])
        self._last_s = self._window_s = 0.0
        self._begin_velocity: NorthEast | None = None
        self._thrust: NorthEast = (0.0, 0.0)  # its integral, m/s
        self._travel: NorthEast = (0.0, 0.0)  # integral of the velocity, m

    @property
    def per_s(self) -> float:
        """The drag coefficient: deceleration per speed."""
        return min(max(float(self._mean[0]), 0.0), MOST_PER_S)

    def take(self, measured_s: float, velocity: NorthEast, thrust_mps2: NorthEast) -> None:
        """Takes a measurement of the flying vehicle.

        Args:
            measured_s: time of the measurement, by the autopilot's clock.
            velocity: north and east.
            thrust_mps2: horizontal acceleration that follows from the tilt, north and east.
        """
        passed_s = measured_s - self._last_s
        if passed_s == 0.0:
            return
        self._last_s = measured_s
        if self._begin_velocity is None or not 0.0 < passed_s <= GAP_S:
            self._begin(velocity)
            return
        self._window_s += passed_s
        self._thrust = _sum(self._thrust, thrust_mps2, passed_s)
        self._travel = _sum(self._travel, velocity, passed_s)
        if self._window_s >= WINDOW_S:
            self._learn(self._thrust - np.subtract(velocity, self._begin_velocity))
            self._begin(velocity)

    def pause(self) -> None:
        """Interrupts the estimate: the vehicle is on the ground, or nothing is known of it."""
        self._begin_velocity = None

    def _begin(self, velocity: NorthEast) -> None:
        self._begin_velocity, self._window_s = velocity, 0.0
        self._thrust = self._travel = (0.0, 0.0)

    def _learn(self, spent_mps: npt.NDArray[np.float64]) -> None:
        """One step of the Kalman filter: (2,) the part of a window's thrust that overcame drag."""
        seconds = self._window_s * np.eye(2)
        model = np.column_stack([self._travel, -seconds])
        prior = self._covariance + np.diag([0.0, CHANGE_MPS2**2, CHANGE_MPS2**2])
        gain = prior @ model.T @ np.linalg.inv(model @ prior @ model.T + NOISE_MPS**2 * np.eye(2))
        self._mean = self._mean + gain @ (spent_mps - model @ self._mean)
        self._covariance = (np.eye(3) - gain @ model) @ prior


def _sum(integral: NorthEast, rate: NorthEast, passed_s: float) -> NorthEast:
    return integral[0] + rate[0] * passed_s, integral[1] + rate[1] * passed_s
