"""Handles a low battery if the mission does not say what to do then.

The autopilot's failsafe comes later, when the charge is critical, and returns straight, across
walls and zones that it does not know. So the companion calls the vehicle away along its own routes
while there is charge for them, to the safe place that it reaches soonest, or home. It does not arm
a vehicle with a low battery.

A mission says what to do by `battery:`, by an event about the battery, or by skills that charge.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.safe_places import SafePlaces
from companion.mission.model import Mission
from companion.mission.steps import Charge
from companion.planning.planner import Planner

LOW_S = 5.0
"""How long the autopilot has to report a low charge; a short load lowers the voltage."""
IN_FLIGHT = "the battery was low, and the mission does not say what is done then"
ON_GROUND = (
    "the battery is low, as the autopilot reports, so it is not armed\n"
    "    charge it; or say in the mission what is done then, by battery: {reserve: 20} or an "
    "event, e.g. low: {when: BATTERY_STATUS.battery_remaining < 25, latch: true}"
)


def says_what_then(mission: Mission) -> bool:
    """Whether a mission says what to do when the battery is low."""
    charges = any(Charge in map(type, skill.execute) for skill in mission.skills.values())
    watches = any(event.when.signal.is_battery for event in mission.events.values())
    return mission.battery is not None or charges or watches


def why_not_armed(flight: Flight, mission: Mission) -> str | None:
    """Why the vehicle is not armed; None if the charge is fine, or the mission says what to do."""
    state = flight.vehicle.state
    is_low = state is not None and state.battery.low_since_s is not None
    return ON_GROUND if is_low and not says_what_then(mission) else None


class LowBattery:
    """Decides when a low battery calls the vehicle away from its task, and where to.

    Args:
        flight: the flight.
        planner: the mission's planner, which knows how long flights take.
    """

    def __init__(self, flight: Flight, planner: Planner) -> None:
        mission = planner.mission
        self._flight, self._home = flight, mission.home.name
        self._is_ours = not says_what_then(mission)
        self._safe = SafePlaces(flight, planner, mission.safe_places)

    @property
    def is_due(self) -> bool:
        """Whether the vehicle has to leave its task because of the battery."""
        state = self._flight.vehicle.state
        if state is None or not self._is_ours or (since_s := state.battery.low_since_s) is None:
            return False
        return self._flight.now_s - since_s >= LOW_S

    def refuge(self) -> str | None:
        """Where the vehicle has to fly; None if nowhere, or if that is not known yet."""
        if not self.is_due:
            return None
        chosen = self._safe.choose()
        return None if chosen is None else chosen.answer or self._home
