"""Reports the charge of the battery: what the gauge says, and what the present plan expects.

Both are for programs: the record, the monitor page, flight.png. No decision depends on them.
"""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.flight_events.charge import ChargeMeasured
from companion.planning.energy.forecast import charge_ahead
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.lasso import Lasso

EVERY_S = 1.0
"""Least time between two reported readings of the gauge."""


class ChargeReport:
    """Reports changes of the charge.

    Args:
        flight: the flight.
        energy: the mission's energy; None if plans ignore energy.
    """

    def __init__(self, flight: Flight, energy: MissionEnergy | None) -> None:
        self._flight, self._energy = flight, energy
        self._percent: int | None = None
        self._told_s = -math.inf
        self._told: tuple[Lasso | None, int] = (None, 0)

    def look(self, lasso: Lasso | None) -> None:
        """Reports changes; called once a tick.

        Args:
            lasso: the present plan; None without one.
        """
        self._tell_measured()
        plan = lasso, self._flight.progress.laps
        if lasso is None or (self._told[0] is lasso and self._told[1] == plan[1]):
            return
        self._told = plan
        if self._energy is not None and not (lasso.ends_at_rest and plan[1]):
            now = lasso if not plan[1] else Lasso((), lasso.loop)
            reserve, facts = self._energy.model.reserve, self._flight.task.facts
            energy = self._energy.now(is_en_route=True)
            self._flight.report(charge_ahead(energy, reserve, facts, now))

    def _tell_measured(self) -> None:
        flight, state = self._flight, self._flight.vehicle.state
        percent = state.battery.percent if state is not None else None
        if percent != self._percent and flight.now_s - self._told_s >= EVERY_S:
            self._percent, self._told_s = percent, flight.now_s
            flight.report(ChargeMeasured(percent))
