"""Gusts near the ground: Dryden's spectra, by MIL-F-8785C for low altitude.

In: height above the ground, speed through the air, time. Out: the velocity of the air relative to
the mean wind, local NED. Gusts are fixed in the air, and the vehicle flies through them: without
air moving past the vehicle they do not change. Along the wind a gust correlates as e^-x with x = V
t / L; across it and downwards as e^-x (1 - x/2).

JSBSim's own gusts are not used: they take the height above sea level for that above the ground
(FGWinds::Run, 1.3.3). At Zurich's 488 m, all gusts were therefore those of a high altitude, 1.4 m/s
upwards and downwards for a minute.

Left out: gusts that turn the vehicle, because the vehicle is smaller than they are.

Source: MIL-F-8785C, 3.7; Moorhouse and Woodcock, AFWAL-TR-81-3109, 1982.
"""

from __future__ import annotations

import math
from random import Random

from companion.geometry import Ned

M_PER_FT = 0.3048
LOWEST_FT, HIGHEST_FT = 10.0, 1000.0
"""The range of the standard in ft; outside it, the values at its ends apply."""
_ROOT_3, _ROOT_2 = math.sqrt(3.0), math.sqrt(2.0)


def scale(height_m: float) -> tuple[float, float, float]:
    """The length scales of gusts, horizontal and vertical, in m; and how much stronger the
    horizontal gusts are.

    >>> [round(each, 1) for each in scale(6.0)]
    [43.1, 6.0, 1.9]
    """
    height_ft = min(HIGHEST_FT, max(LOWEST_FT, height_m / M_PER_FT))
    shape = 0.177 + 0.000823 * height_ft
    return M_PER_FT * height_ft / shape**1.2, M_PER_FT * height_ft, shape**-0.4


class _Transverse:
    """White noise through (1 + sqrt(3) s) / (1 + s)^2, which has Dryden's transverse spectrum."""

    def __init__(self) -> None:
        self._first = self._second = 0.0

    def step(self, keep: float, noise: float) -> float:
        """The next value, of standard deviation 1.

        Args:
            keep: e^-x for a step of x length scales, the share of a value that remains.
            noise: white, of standard deviation 1.
        """
        self._second += (1 - keep) * (self._first - self._second)
        self._first = keep * self._first + math.sqrt(1 - keep * keep) * noise
        return (_ROOT_3 * self._first + (1 - _ROOT_3) * self._second) / _ROOT_2


class Gusts:
    """The gusts of one flight.

    Args:
        deviation_mps: standard deviation of vertical gusts; horizontal ones are about twice as
            strong.
        seed: any integer.
    """

    def __init__(self, deviation_mps: float, seed: int) -> None:
        self._deviation_mps = deviation_mps
        self._noise = Random(f"gusts {seed}").gauss
        self._along, self._across, self._down = 0.0, _Transverse(), _Transverse()
        self._wind: Ned = (0.0, 0.0, 0.0)
        self._ahead = (1.0, 0.0)

    def step(self, height_m: float, airspeed_mps: float, wind: Ned, dt_s: float) -> Ned:
        """The next gust.

        Args:
            height_m: above the ground.
            airspeed_mps: the airspeed of the vehicle, in the mean wind.
            wind: the mean wind, NED, m/s; it defines what is along and across.
            dt_s: length of the step.
        """
        noise = self._noise
        level_m, upright_m, stronger = scale(height_m)
        flown_m = airspeed_mps * dt_s
        keep = math.exp(-flown_m / level_m)
        self._along = keep * self._along + math.sqrt(1 - keep * keep) * noise()
        across = self._across.step(keep, noise())
        down_mps = self._deviation_mps * self._down.step(math.exp(-flown_m / upright_m), noise())
        level_mps = self._deviation_mps * stronger
        if wind is not self._wind:
            self._turn(wind)
        ahead_n, ahead_e = self._ahead
        north = level_mps * (ahead_n * self._along - ahead_e * across)
        east = level_mps * (ahead_e * self._along + ahead_n * across)
        return north, east, down_mps

    def _turn(self, wind: Ned) -> None:
        """Adopts the direction of another mean wind."""
        speed_mps = math.hypot(wind[0], wind[1])
        self._wind = wind
        self._ahead = (wind[0] / speed_mps, wind[1] / speed_mps) if speed_mps else (1.0, 0.0)
