"""Flights over many sites: the longest tick while events come and walls are seen."""

from __future__ import annotations

import gc
import math
import random
from collections.abc import Iterator
from typing import Any

from benches import Row
from benches.answering import MOVE
from benches.missions import Tracking, timed_steps
from companion.acting.sortie.flight_limit import FlightLimit
from companion.acting.sortie.terms import SortieTerms
from companion.app import Companion
from companion.flights.simulated_world import lockstep
from companion.mission.loader import load_mission
from companion.run_sources.only_run import OnlyRun
from sitl.world.scenario import read_scenario

SIDE_M = 60.0
APART_M = 2.5
COLUMNS = 14
FIRST_EVENT_S, EVERY_S = 12.0, 8.0


def flights(runs: int) -> Iterator[Row]:
    """Half of the sites matter while it is red, all of them otherwise; no map has the columns."""
    sites, duration_s = (100, 60.0) if runs >= 50 else (20, 24.0)
    mission = load_mission(_patrol(sites))
    world = read_scenario(_world(duration_s), default_map=mission.grid)
    seen = Tracking()
    terms = SortieTerms(limit=FlightLimit(duration_s=duration_s))
    flight = lockstep(Companion(OnlyRun(mission, seen), terms), world)
    seen.simulation, ticks_s = flight.simulation, timed_steps(flight.companion)
    gc.collect()
    gc.freeze()  # as before any flight by the clock
    flight.fly()
    gc.unfreeze()
    name = f"{sites} sites, events and columns"
    yield Row(f"{name}: slowest tick of {len(ticks_s)}", 1000 * max(ticks_s), "ms")


def _patrol(sites: int) -> dict[str, Any]:
    places = {f"s{i}": place for i, place in enumerate(_scattered(sites))}
    places["Home"] = {"east_m": 0, "north_m": 0, "up_m": 2}
    lines = [f"F (at(s{i}) | red)" if i % 2 else f"F at(s{i})" for i in range(sites)]
    return {
        "version": 1,
        "name": f"patrol_of_{sites}",
        "map": {"east_m": [-2, SIDE_M + 2], "north_m": [-2, SIDE_M + 2], "cell_m": 0.4},
        "limits": {
            "speed_mps": 4,
            "up_m": [0.5, 5],
            "fence": [[-1, -1], [SIDE_M, -1], [SIDE_M, SIDE_M], [-1, SIDE_M]],
        },
        "places": places,
        "sets": {"Place": list(places)},
        "events": {"red": {"when": "NAMED_VALUE_INT[target].value > 0"}},
        "skills": {"move": {**MOVE, "assumes": "trans_ok(from, to)"}},
        "initially": ["at(Home)"],
        "task": {"patrol": f"G ({' & '.join(lines)})"},
    }


def _scattered(sites: int) -> Iterator[dict[str, float]]:
    """Random places with small regions and a minimum distance."""
    chance, taken = random.Random(1), [(0.0, 0.0)]
    while len(taken) <= sites:
        point = chance.uniform(2, SIDE_M - 2), chance.uniform(2, SIDE_M - 2)
        if min(math.dist(point, other) for other in taken) > APART_M:
            taken.append(point)
            yield {"east_m": point[0], "north_m": point[1], "up_m": 2, "radius_m": 0.4}


def _world(duration_s: float) -> dict[str, Any]:
    """Random columns, and an event that comes and goes."""
    chance = random.Random(2)
    columns = [
        {"east_m": chance.uniform(5, 55), "north_m": chance.uniform(5, 55), "radius_m": 0.5}
        for _ in range(COLUMNS)
    ]
    changes = range(int((duration_s - FIRST_EVENT_S) / EVERY_S) + 1)
    return {
        "version": 1,
        "target": {"component": 26},
        "obstacles": [{"name": f"column {i}", "circle": c} for i, c in enumerate(columns)],
        "happens": [
            {"at_s": FIRST_EVENT_S + EVERY_S * i, "target": "lost" if i % 2 else "seen"}
            for i in changes
        ],
    }
