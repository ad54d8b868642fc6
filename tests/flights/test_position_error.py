"""Flights whose position is not exact: a GPS that wanders, and a PX4's own drag and wander.

The vehicle needs 45 cm around its centre: 35 of its own, and the 10 that are to stay free.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shipped import MISSIONS, ShippedFlight

from companion.acting.flight import TICK_S
from companion.flight_events.skills import ClearanceChanged, SkillFailed
from companion.flight_events.sortie import TaskSatisfied, VehicleCrashed
from companion.geometry import horizontal_distance
from sitl.flight.estimate import GpsQuality, Wander
from sitl.world.scenario import Scenario, read_scenario

LEAST_M = 0.45
SEEN_M = 90.0


class FlightInError(ShippedFlight):
    """A shipped mission in a world in which the position is not exact.

    Attributes:
        phantoms: cells that the companion took for occupied, far from all that truly was.
        arrivals_s: how long each flight took to be at its place after its trajectory had ended.
    """
