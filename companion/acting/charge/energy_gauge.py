"""The charge of the battery as its gauge shows it, in units of energy.

1. A charge that was never reported counts as full.
2. If the gauge is silent for 5 s, the level continues with the energy of a hover.
3. If the gauge jumps in flight, the lower level counts: nobody has charged the battery, so a higher
   charge is not believed, and later readings count down from the lower level.
"""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.flight_events.energy import GaugeJumped
from companion.planning.energy.mission_energy import MissionEnergy

HALF_STEP = 0.005
"""Half a step of a gauge that shows whole percents."""
SILENT_S = 5.0
JUMP = 0.05


class Gauge:
    """The level of a flight; fulfils `ChargeSource`.

    Args:
        flight: the flight.
        energy: the mission's energy.
    """

    def __init__(self, flight: Flight, energy: MissionEnergy) -> None:
        self._flight, self._energy, self._model = flight, energy, energy.model
        self._known, self._known_s = 1.0, math.inf
        self._told: float | None = None
        self._too_much = 0.0

    def least(self) -> int:
        """The lowest level that is possible; on the ground, without the energy for the take-off."""
        state = self._flight.vehicle.state
        is_landed = state is not None and state.is_landed
        taken = self._energy.to_take_off() if is_landed else 0
        return max(0, self._level(-HALF_STEP) - taken)

    def most(self) -> int:
        """The highest level that is possible."""
        return self._level(HALF_STEP)

    def middle(self) -> int:
        """The most likely level."""
        return self._level(0.0)

    def listen(self) -> None:
        """Takes the present reading; it may be called any number of times."""
        flight, state = self._flight, self._flight.vehicle.state
        if state is None or state.battery.percent is None:
            return
        told = state.battery.percent / 100
        if state.is_landed:
            self._too_much = 0.0  # it was charged, or the battery was changed
        elif self._told is not None and abs(told - self._told) > JUMP:
            before = self._known
            self._too_much = max(0.0, told - before)
            jumped = GaugeJumped(
                before_percent=round(100 * before),
                now_percent=round(100 * told),
                believed_percent=round(100 * (told - self._too_much)),
            )
            flight.report(jumped)
        self._told = told
        self._known = max(0.0, told - self._too_much)
        flight.believed_percent = 100 if not self._too_much else math.floor(100 * self._known)
        self._known_s = min(state.motion.received_s, state.battery.percent_s)

    @property
    def is_flown(self) -> bool:
        """Whether the vehicle is in the air."""
        state = self._flight.vehicle.state
        return state is not None and not state.is_landed

    def _level(self, step: float) -> int:
        self.listen()
        state = self._flight.vehicle.state
        known = self._model.level(min(1.0, max(0.0, self._known + step)))
        if state is None:
            return known
        silent_s = state.motion.received_s - self._known_s
        taken = self._model.hovering(silent_s) if silent_s > SILENT_S else 0
        return max(0, known - taken)
