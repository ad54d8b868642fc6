"""A patrol through a hall where something is put down or taken away all the time, in lockstep.

Crates come and go by chance, none nearer to the vehicle than it can see and avoid. Whatever the
companion makes of that, it touches nothing, and goes on.
"""

from __future__ import annotations

import math
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest
from lockstep import Lockstep

from companion.flight_events.plans import LapCompleted
from companion.geometry import NorthEast
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.vehicle_profile import VehicleProfile
from sitl.world.scenario import read_scenario

QUAD = VehicleProfile()

MISSIONS = Path(__file__).parents[2] / "missions"
CRATES = 10
OFF_PLACES_M = 1.6
EVERY_S = 2.5
NEAREST_M = 2.0
"""From the vehicle's side to a crate that appears: at 2 m/s a stop takes less."""


class Crate(NamedTuple):
    name: str
    centre: NorthEast
    radius_m: float

    def clear_m(self, position: NorthEast) -> float:
        return math.dist(self.centre, position) - self.radius_m - QUAD.radius_m


def crates(rng: Random, places: list[NorthEast]) -> list[Crate]:
    """Some crates anywhere in the hall, but on no place."""
    found: list[Crate] = []
    while len(found) < CRATES:
        centre = (rng.uniform(1, 13), rng.uniform(1, 20))
        if min(math.dist(centre, place) for place in places) > OFF_PLACES_M:
            found.append(Crate(f"c{len(found)}", centre, rng.uniform(0.15, 0.45)))
    return found


def world(folder: Path, hall: list[Crate], changes: list[int]) -> Path:
    """Each MAV_CMD_USER_3 puts the next crate down, or takes it away if it is there."""
    is_there = [False] * len(hall)
    happens = []
    for nth, i in enumerate(changes, start=1):
        is_there[i] = not is_there[i]
        change = f"{{name: {hall[i].name}, present: {str(is_there[i]).lower()}}}"
        happens.append(f"  - {{command: MAV_CMD_USER_3, nth: {nth}, obstacle: {change}}}")
    shapes = [
        f"  - {{name: {c.name}, present: false, circle: {{north_m: {c.centre[0]}, "
        f"east_m: {c.centre[1]}, radius_m: {c.radius_m}}}}}"
        for c in hall
    ]
    lines = ["version: 1", f"map: {MISSIONS}/maps/hall.yaml", "lidar: {}", "obstacles:"]
    path = folder / "world.sim.yaml"
    path.write_text("\n".join([*lines, *shapes, "happens:", *happens]), encoding="utf-8")
    return path


@pytest.mark.long
@pytest.mark.parametrize(("seed", "count"), [(1, 24), *((seed, 80) for seed in range(1, 11))])
def test_nothing_is_touched(tmp_path: Path, seed: int, count: int) -> None:
    rng, mission = Random(seed), load_mission(MISSIONS / "surveillance.yaml")
    hall = crates(rng, [place.position[:2] for place in mission.places.values()])
    changes = [rng.randrange(CRATES) for _ in range(count)]
    scenario = read_scenario(world(tmp_path, hall, changes))
    flight = Lockstep(mission, scenario, seed=seed, has_station=True)
    flight.until(lambda: flight.simulation.mode == "OFFBOARD", limit_s=20.0)
    least_m, next_s = math.inf, flight.now_s
    while changes and not flight.companion.has_ended:
        flight.tick()
        north, east, _ = flight.simulation.flight.position
        true_map = flight.simulation.true_map
        assert true_map is not None
        least_m = min(least_m, true_map.clearance_m((north, east)))
        if flight.now_s >= next_s and hall[changes[0]].clear_m((north, east)) >= NEAREST_M:
            changes.pop(0)
            next_s = flight.now_s + EVERY_S
            flight.station_commands(dialect.MAV_CMD_USER_3)
    assert flight.simulation.collisions == 0
    assert least_m >= QUAD.radius_m
    assert len(flight.of(LapCompleted)) >= count // 24
