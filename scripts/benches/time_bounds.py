"""Plans with time bounds: how long planning takes, and what it finds."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from statistics import median
from time import process_time

from benches import Row
from benches.worlds import Asked, patrol, straight
from companion.errors import SearchLimit
from companion.ltl.parser import parse_line
from companion.mission.model import Mission
from companion.planning.explain import NoPlan
from companion.planning.lasso import Problem
from companion.planning.planner import Planner
from companion.slices import InSlices

BOUNDS = 3
ALL = ((6, 0.7, 1.2), (6, 0.9, 1.4), (10, 0.9, 1.4))
"""Number of sites, and the range of the limits as shares of the tour."""


def bounded(sites: int, least: float, most: float, seed: int) -> Mission:
    """A patrol in which some sites have to be visited often."""
    chance = random.Random(seed)
    mission = patrol(sites, 1, seed)
    tour_s = _planner(mission).plan().lap_cost_s
    visited = chance.sample([f"s{i}" for i in range(sites)], BOUNDS)
    lines = {
        f"often_{place}": parse_line(
            f"revisit({place}) <= {round(chance.uniform(least, most) * tour_s) + 2} s"
        )
        for place in visited
    }
    return replace(mission, task={**mission.task, **lines})


def dropping(runs: int) -> Iterator[Row]:
    """Which lines of too short bounds a replan drops; the peer has not planned before."""
    took_ms, alone_ms = [], []
    for seed in range(max(2, runs // 10)):
        mission = bounded(8, 0.5, 0.9, seed)
        lines = [line for line in mission.task if line.startswith("often")]
        mission = replace(mission, priorities={line: n for n, line in enumerate(lines, 1)})
        planner = _planner(mission)
        planner.plan()
        for problem, _ in _later(planner, seed):
            took_ms.append(_dropping_ms(planner, problem))
            alone_ms.append(_dropping_ms(_planner(mission), problem))
    name = f"bounds in time, 8 sites, {BOUNDS} bounds of 0.5 to 0.9 tours that may be dropped"
    what, peer = f"{name}: which to drop in flight", "a planner that has not planned before"
    yield Row(what, median(took_ms), "ms", peer, median(alone_ms))


def _dropping_ms(planner: Planner, problem: Problem) -> float:
    start_s = process_time()
    planner.solver.lines_to_drop(problem)
    return 1000 * (process_time() - start_s)


def _planner(mission: Mission) -> Planner:
    return Planner(mission, straight(mission))


def plans(runs: int) -> Iterator[Row]:
    """First plans, including proofs that there is none, and replans, in CPU time."""
    for sites, least, most in ALL if runs >= 50 else ALL[:1]:
        first_ms, later_ms, slices_ms = [], [], []
        found = longer = given_up = 0
        seeds = range(max(3, runs // 5))
        for seed in seeds:
            planner = _planner(bounded(sites, least, most, seed))
            plain = _planner(patrol(sites, 1, seed)).plan().lap_cost_s
            start_s = process_time()
            try:
                solution = planner.solver.solve(*planner.initial_problem())
            except NoPlan:
                solution = None
            except SearchLimit:
                solution, given_up = None, given_up + 1
            first_ms.append(1000 * (process_time() - start_s))
            if solution is None:
                continue
            found, longer = found + 1, longer + (solution.lap_cost_s > plain)
            for asked in _later(planner, seed):
                took_ms = _slices_ms(planner, asked)
                later_ms.append(sum(took_ms))
                slices_ms += took_ms
        name = f"bounds in time, {sites} sites, {BOUNDS} bounds of {least:g} to {most:g} tours"
        yield Row(f"{name}: with a plan", 100 * found / len(seeds), "%")
        yield Row(f"{name}: with one beyond the tour", 100 * longer / len(seeds), "%")
        yield Row(f"{name}: given up", 100 * given_up / len(seeds), "%")
        yield Row(f"{name}: first plan, or why there is none, median", median(first_ms), "ms")
        yield Row(f"{name}: the same, worst", max(first_ms), "ms")
        if later_ms:
            yield Row(f"{name}: replan, median", median(later_ms), "ms")
            yield Row(f"{name}: replan, worst", max(later_ms), "ms")
            yield Row(f"{name}: its longest slice", max(slices_ms), "ms")


def _later(planner: Planner, seed: int) -> Iterator[Asked]:
    """Problems from some places, with clocks that have run for some time."""
    chance = random.Random(seed)
    for place in chance.sample(list(planner.mission.places), 5):
        problem, histories = planner.initial_problem(at=place)
        clocks = (
            shown if shown is None or not c.bound else chance.randrange(c.bound.limit_ms // 3)
            for c, shown in zip(problem.conjuncts, problem.clocks_ms, strict=True)
        )
        yield replace(problem, clocks_ms=tuple(clocks)), histories


def _slices_ms(planner: Planner, asked: Asked) -> list[float]:
    planning, took_ms, is_done = InSlices(lambda: _replan(planner, asked)), [], False
    while not is_done:
        start_s = process_time()
        is_done = planning.step()
        took_ms.append(1000 * (process_time() - start_s))
    return took_ms


def _replan(planner: Planner, asked: Asked) -> bool:
    try:
        return planner.solver.replan(*asked) is not None
    except SearchLimit:
        return False
