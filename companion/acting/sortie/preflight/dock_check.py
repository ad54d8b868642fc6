"""Warns, before arming, of docks that a vehicle with an inaccurate position may miss.

The autopilot lands where its position says that the dock is, without looking. Nobody tells the
companion how large a dock is. A landing begins up to ARRIVAL_M beside the place, and the position
may be off by its error in addition: of 97 landings of a PX4 whose position was accurate to 0.29 m,
95 % were within 1.13 m of their place, and this estimate gives 1.2 m.
"""

from __future__ import annotations

from companion.acting.behaviour_tree.move import ARRIVAL_M
from companion.acting.flight import Flight
from companion.flight_events.landing import DockMayBeMissed
from companion.mission.model import Mission
from companion.mission.steps import Charge, Land
from companion.motion.position_error import EXACT_M, greatest_error_m
from companion.outcomes import Outcome, Progress


def needs_docks(mission: Mission) -> bool:
    """Whether a mission charges where it lands without a marker."""
    steps = [step for skill in mission.skills.values() for step in skill.execute]
    return any(isinstance(step, Charge) for step in steps) and Land() in steps


class DockCheck:
    """The warning for one flight.

    Args:
        flight: the flight of the vehicle that has to land.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight

    def tick(self) -> Outcome:
        """DONE at once, after the warning."""
        state = self._flight.vehicle.state
        if state is not None and state.motion.accuracy_m > EXACT_M:
            beside_m = ARRIVAL_M + greatest_error_m(state.motion.accuracy_m)
            self._flight.report(DockMayBeMissed(round(beside_m, 1)))
        return Progress.DONE
