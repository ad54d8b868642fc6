"""Plans on a battery: how long planning takes, and how good the plans are."""

from __future__ import annotations

import gc
import random
from collections.abc import Iterator
from dataclasses import replace
from statistics import median
from time import process_time

from benches import Row
from benches.docks import HOME, patrol_between_docks
from benches.worlds import Asked
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.planning.energy.known_loops import KnownLoops
from companion.planning.planner import Planner
from companion.planning.solver import SolverMemory
from companion.planning.timed.known_laps import KnownLaps
from companion.slices import InSlices

NOTHING = SolverMemory(KnownLoops(), KnownLaps())


FIELDS = 8
CAPACITIES_WH = {1: 30, 2: 18, 3: 13}
"""Number of charges that most laps over twenty sites take -> capacity for it."""


def patrol_on_a_battery(sites: int, docks: int, seed: int, capacity_wh: float = 30) -> Mission:
    """A patrol over a large field."""
    chance = random.Random(seed)
    visited, pads = [f"s{i}" for i in range(sites)], [f"Dock{i}" for i in range(docks)]

    def place() -> dict[str, float]:
        return {"east_m": chance.uniform(0, 400), "north_m": chance.uniform(0, 300), "up_m": 6.0}

    return load_mission(
        patrol_between_docks(
            "patrol_on_a_battery",
            places={name: place() for name in (HOME, *visited, *pads)},
            docks=pads,
            fence=[[-20, -20], [420, -20], [420, 320], [-20, 320]],
            battery={"reserve": 20, "capacity_wh": capacity_wh},
            charge_rate=[[0, 0.5], [80, 0.5], [90, 0.2], [100, 0.02]],
        )
    )


def plans(runs: int) -> Iterator[Row]:
    """First plans, with automata and routes, and replans from any place and charge, in CPU time.

    A replan keeps the lap of the first plan; for "anew" no lap is known.
    """
    seeds = range(max(1, runs // 10))
    for sites in (10, 20) if runs >= 50 else (6,):
        first_ms, kept_ms, anew_ms, slices_ms = [], [], [], []
        for seed in seeds:
            mission = patrol_on_a_battery(sites, 2, seed)
            start_s = process_time()
            planner = Planner(mission)
            planner.explain()
            first_ms.append(1000 * (process_time() - start_s))
            gc.collect()
            gc.freeze()  # as before any flight by the clock
            for asked in _later(planner, seed):
                kept_ms.append(sum(_slices_ms(planner, asked)))
                known = planner.solver.memory
                planner.solver.recall(NOTHING)
                took_ms = _slices_ms(planner, asked)
                planner.solver.recall(known)
                anew_ms.append(sum(took_ms))
                slices_ms += took_ms
        gc.unfreeze()
        name = f"on a battery, {sites} sites, 2 docks"
        yield Row(f"{name}: first plan", median(first_ms), "ms")
        yield Row(f"{name}: replan that keeps the lap, median", median(kept_ms), "ms")
        yield Row(f"{name}: replan that keeps the lap, worst", max(kept_ms), "ms")
        yield Row(f"{name}: replan anew, median", median(anew_ms), "ms")
        yield Row(f"{name}: replan anew, worst", max(anew_ms), "ms")
        yield Row(f"{name}: its longest slice", max(slices_ms), "ms")


def laps(runs: int) -> Iterator[Row]:
    """How far laps may be from the shortest, over many sites, and how long that proof takes."""
    sites, fields = (20, FIELDS) if runs >= 50 else (12, 1)
    for charges, capacity_wh in CAPACITIES_WH.items():
        above, first_above, took_s = [], [], []
        for seed in range(fields):
            planner = Planner(patrol_on_a_battery(sites, 2, seed, capacity_wh))
            start_s = process_time()
            first, *others = planner.solver.solutions(*planner.initial_problem())
            best = [first, *others][-1]
            took_s.append(process_time() - start_s)
            above.append(100 * (best.cost_ms / best.bound_ms - 1))
            first_above.append(100 * (first.cost_ms / best.bound_ms - 1))
        name = f"on a battery, {sites} sites, {charges} charges or more"
        yield Row(f"{name}: above a proved bound, worst", max(above), "%")
        yield Row(f"{name}: the same in flight, median", median(first_above), "%")
        yield Row(f"{name}: the same in flight, worst", max(first_above), "%")
        yield Row(f"{name}: to prove it, worst", max(took_s), "s")


def _later(planner: Planner, seed: int) -> Iterator[Asked]:
    """Problems from some places, with any charge above a third."""
    chance = random.Random(seed)
    for place in chance.sample(list(planner.mission.places), 5):
        problem, histories = planner.initial_problem(at=place)
        assert problem.energy is not None
        full = len(problem.energy.percents)
        level = chance.randrange(full // 3, full)
        yield replace(problem, energy=replace(problem.energy, level=level)), histories


def _slices_ms(planner: Planner, asked: Asked) -> list[float]:
    planning, took_ms, is_done = InSlices(lambda: planner.solver.replan(*asked)), [], False
    while not is_done:
        start_s = process_time()
        is_done = planning.step()
        took_ms.append(1000 * (process_time() - start_s))
    return took_ms
