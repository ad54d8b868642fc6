"""Checks, before arming, that the autopilot's own failsafes are strong.

`companion/vehicle/failsafes.py` decides what is strong enough; this module asks the autopilot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.acting.flight import Flight
from companion.acting.sortie.authority import FRESH_S
from companion.flight_events.sortie import WeakFailsafeAccepted
from companion.geometry import Ned
from companion.outcomes import Failed, Outcome, Progress
from companion.vehicle.failsafes import FlownWithin, parameters_of, weaknesses

ANSWER_TIMEOUT_S = 10.0
"""How long the autopilot may take to send its parameters; each is requested twice a second."""


class FailsafeCheck:
    """One check.

    Args:
        flight: the flight whose autopilot is asked.
        accepts_weak: whether weak failsafes are only reported, and no failure.
        reserve: the charge, 0 to 1, that plans leave; None if plans ignore energy.
        homes: where else the vehicle may be armed, on the ground or a roof; there a PX4 moves its
            home.
    """

    def __init__(
        self,
        flight: Flight,
        accepts_weak: bool,
        reserve: float | None = None,
        homes: Sequence[Ned] = (),
    ) -> None:
        self._reserve, self._homes = reserve, homes
        self._flight = flight
        self._accepts_weak = accepts_weak
        self._asked_s: float | None = None

    def tick(self) -> Outcome:
        """DONE when the failsafes are known and strong, or accepted.

        The time for an answer begins with the question, because the tick before has planned, which
        may take longer than an answer may. It starts again after a silence.
        """
        vehicle, now_s = self._flight.vehicle, self._flight.now_s
        state = vehicle.state
        is_heard = state is not None and state.motion.silence_s(now_s) <= FRESH_S
        if self._asked_s is None or not is_heard:
            self._asked_s = now_s
        values = {name: vehicle.parameters.read(name) for name in parameters_of(self._reserve)}
        is_late = now_s - self._asked_s > ANSWER_TIMEOUT_S
        if None in values.values() and not is_late:
            return Progress.RUNNING
        weak = weaknesses(values, self._flown_within(), self._reserve)
        if weak and not self._accepts_weak:
            lines = "\n    ".join(weak)
            return Failed(f"the autopilot's failsafes are weak, so it is not armed\n    {lines}")
        for line in weak:
            self._flight.report(WeakFailsafeAccepted(line))
        return Progress.DONE

    def _flown_within(self) -> FlownWithin:
        """How far the mission's limits reach from where the vehicle is armed."""
        state, limits = self._flight.vehicle.state, self._flight.limits
        begun = (0.0, 0.0) if state is None else state.motion.position[:2]
        homes = [begun, *(home[:2] for home in self._homes)]
        away_m = (math.dist(home, corner) for home in homes for corner in limits.fence)
        roof_m = max((-home[2] for home in self._homes), default=0.0)
        return FlownWithin(limits.up_m[1], max(away_m, default=0.0), roof_m)
