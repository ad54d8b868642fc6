"""The warning, before arming, of docks that a vehicle may miss whose position is not exact.

The autopilot lands where its position says that the dock is, without looking. How large a dock is
nobody tells the companion. A landing begins up to ARRIVAL_M beside the place, and the position is
off by so much again as it may be: of 97 landings of a PX4 whose position was good for 0.29 m, 95 %
were within 1.13 m of their place, and that makes 1.2 m.
"""

from __future__ import annotations

from companion.acting.behaviour_tree.move import ARRIVAL_M
from companion.acting.flight import Flight
from companion.flight_events.landing import DockMayBeMissed
from companion.mission.model import Mission
from companion.mission.steps import Charge, Land
from companion.motion.position_error import EXACT_M, greatest_error_m
from companion.vehicle.port import Outcome, Progress


def needs_docks(mission: Mission) -> bool:
    """Whether a mission charges where it has landed without a marker."""
    steps = [step for skill in mission.skills.values() for step in skill.execute]
    return any(isinstance(step, Charge) for step in steps) and Land() in steps


class DockCheck:
    """One warning.

    Args:
        flight: of the vehicle that is to land.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight

    def tick(self) -> Outcome:
        """DONE at once."""
        state = self._flight.vehicle.state
        if state is not None and state.accuracy_m > EXACT_M:
            beside_m = ARRIVAL_M + greatest_error_m(state.accuracy_m)
            self._flight.report(DockMayBeMissed(round(beside_m, 1)))
        return Progress.DONE
