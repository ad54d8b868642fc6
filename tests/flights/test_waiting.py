"""A vehicle that waits before a closed door goes on soon after it is opened, in lockstep."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion import load_mission, simulate
from companion.flight_events.plans import PlanAwaited, PlanReplaced

ROOMS = Path(__file__).parents[2] / "missions" / "maps" / "rooms.yaml"
MISSION = f"""
version: 1
name: door
map: {ROOMS}
limits: {{speed_mps: 3.0, up_m: [0.5, 4.0]}}
patience_s: 60
places:
  Home: {{east_m: 0, north_m: 0, up_m: 2}}
  Shelf: {{east_m: 2.5, north_m: 8.5, up_m: 2}}
  Bench: {{east_m: 14, north_m: 1, up_m: 2}}
sets: {{Place: [Home, Shelf, Bench]}}
skills:
  move:
    parameters: {{from: Place, to: Place}}
    precondition: at(from)
    assumes: trans_ok(from, to)
    effect: at(to) & !at(from)
    cost: flight_time
    execute: fly(to)
initially: [at(Home)]
task: {{tour: F(at(Shelf) & F(at(Bench) & F at(Home)))}}
"""
WORLD = f"""
version: 1
map: {ROOMS}
wind: {{east_mps: 0.3, north_mps: 0.2, turbulence_mps: 0.1}}
lidar: {{}}
obstacles:
  - {{name: door, box: {{east_m: [5.0, 5.2], north_m: [7.4, 9.6]}}, present: false}}
  - {{name: passage, box: {{east_m: [5.0, 5.2], north_m: [10.2, 14]}}, present: true}}
  - {{name: corridor, box: {{east_m: [5.0, 5.2], north_m: [-0.8, 1.6]}}, present: true}}
happens:
  - place: {{east_m: 2.5, north_m: 7, radius_m: 0.8}}
    obstacle: {{name: door, present: true}}
  - {{at_s: 30, obstacle: {{name: door, present: false}}}}
"""
OPENED_S, SOON_S = 30.0, 8.0


@pytest.mark.parametrize("seed", [1, *(pytest.param(n, marks=pytest.mark.long) for n in (2, 3, 4))])
def test_it_sees_that_the_door_is_open(seed: int) -> None:
    flight = simulate(load_mission(MISSION), WORLD, seed=seed)
    assert flight.failure is None
    (awaited_s,) = (each.time_s for each in flight.events if isinstance(each.event, PlanAwaited))
    replaced = [each.time_s for each in flight.events if isinstance(each.event, PlanReplaced)]
    assert awaited_s < OPENED_S - 10
    assert OPENED_S < replaced[0] < OPENED_S + SOON_S
