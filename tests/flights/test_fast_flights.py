"""Fast flights with the drag of PX4's simulated vehicle, over a link that is late."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import pytest
from lockstep import Lockstep
from moves import MOVE

from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import Phase, PhaseEntered, SetpointRefused
from companion.flights.simulated_world import world_of
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.tick import TICK_S
from companion.vehicle_profile import VehicleProfile

LENGTH_M, SPEED_MPS = 260, 10
ARRIVAL_S = 6.0
"""To catch up, as most of the thrust is taken by drag, and to come to rest at the place."""
OVERSHOOT_M = 1.0
MOST_MPS2 = VehicleProfile().max_acceleration_mps2
LATE: dict[str, Any] = {"at_s": 0, "link": {"port": "companion", "delay_s": 0.02, "jitter_s": 0.04}}
"""With the ticks of both sides, positions are 0.1 to 0.16 s old."""


def straight() -> Mission:
    end = LENGTH_M + 40
    return load_mission(
        {
            "version": 1,
            "name": "straight",
            "limits": {
                "speed_mps": SPEED_MPS,
                "up_m": [1, 20],
                "fence": [[-30, -30], [end, -30], [end, 30], [-30, 30]],
            },
            "places": {
                "Home": {"east_m": 0, "north_m": 0, "up_m": 5, "radius_m": 2},
                "A": {"east_m": LENGTH_M, "north_m": 0, "up_m": 5},
            },
            "sets": {"Place": ["Home", "A"]},
            "skills": {"move": MOVE},
            "initially": ["at(Home)"],
            "task": {"reach": "F at(A)"},
        }
    )


@pytest.mark.parametrize(
    "happens", [[], pytest.param([LATE], marks=pytest.mark.long)], ids=["prompt", "late"]
)
def test_it_keeps_its_speed_and_its_setpoints_change_gently(happens: list[Any]) -> None:
    mission = straight()
    world = {"version": 1, "airframe": "px4_sih", "happens": happens}
    flight = Lockstep(mission, world_of(mission, world))
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    begin_s, farthest_m, before = flight.now_s, 0.0, len(flight.setpoints)
    while not flight.of(PlaceReached):
        flight.run(TICK_S)
        farthest_m = max(farthest_m, flight.simulation.flight.position[1])
    told_mps = [math.hypot(s.message.vx, s.message.vy) for s in flight.setpoints[before:]]
    plain_s = LENGTH_M / SPEED_MPS + SPEED_MPS / VehicleProfile().acceleration_mps2
    assert flight.now_s - begin_s < plain_s + ARRIVAL_S
    changes_mps = [abs(after - earlier) for earlier, after in pairwise(told_mps)]
    assert sum(changes_mps) / len(changes_mps) < MOST_MPS2 * TICK_S
    assert farthest_m < LENGTH_M + OVERSHOOT_M and not flight.of(SetpointRefused)
