"""The speed of planning, and the quality of plans."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from statistics import median
from time import perf_counter

import numpy as np

from benches import MISSION, Row, timed
from benches.references import share_of_best
from benches.worlds import (
    Asked,
    interrupted,
    patrol,
    patrol_in_a_hall,
    straight,
    target_found,
    with_implied_lines,
)
from companion.acting.preparation import anticipate_events, prepare
from companion.geometry import Ned
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.motion.departure import at_rest
from companion.motion.layered_routes import LayeredRoutes
from companion.planning.engines import solve_with
from companion.planning.flight_times import flight_times, route_map
from companion.planning.flown_routes import FlownRoutes
from companion.planning.lasso import Solution
from companion.planning.objective import Encoding, Objective
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState

ENGINE = "fast-downward"


def loading(runs: int) -> Iterator[Row]:
    """The import of the package, and from the mission file to the first plan."""
    took = [_import_ms() for _ in range(max(3, runs // 5))]
    yield Row("import companion", median(took), "ms")

    def first_plan() -> None:
        Planner(load_mission(MISSION)).plan()

    yield Row("load, ground and plan", median(timed(first_plan, max(1, runs // 4))), "ms")


def _import_ms() -> float:
    """The import time in a Python process that has imported nothing of ours."""
    script = (
        "import time; t = time.perf_counter(); import companion; print(time.perf_counter() - t)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    return 1000 * float(done.stdout)


def replanning(runs: int) -> Iterator[Row]:
    """The three plans of the paper's flight; the peer solves the same problems in the same run."""
    mission = load_mission(MISSION)
    routes = route_map(mission)
    here = [mission.places["A"].position]
    planner = Planner(mission, flight_times(mission, FlownRoutes(routes), lambda: at_rest(here[0])))
    actions = {action.name: action for action in planner.actions.model.actions}
    task = TaskState(planner)
    yield from _phase("plan at the start", planner, [task.problem()] * runs)

    task.begin(actions["move(Home, A)"])
    task.complete(actions["move(Home, A)"], 0.0)
    task.begin(actions["move(A, B)"])
    task.take(mission.events["targetFound"], True)
    task.interrupt()
    passed, problems = [], []
    for here[0] in points_between(mission, routes, "A", "B", 4 * runs):
        passed += timed(lambda: planner.solver.replan(*task.problem()), 1)
        problems.append(task.problem())
    yield from _rows("replan en route, target found", passed, _peer_ms(problems[0]))

    refused = planner.initial_problem(at="r1", facts={"targetFound"}, without={"canUpload(r1)"})
    yield from _phase("replan at r1, refused", planner, [refused] * runs)


def _phase(name: str, planner: Planner, problems: list[Asked]) -> Iterator[Row]:
    passed = [ms for asked in problems for ms in timed(partial(planner.solver.replan, *asked), 1)]
    yield from _rows(name, passed, _peer_ms(problems[0]))


def _rows(name: str, passed: list[float], peer_ms: float) -> Iterator[Row]:
    yield Row(f"{name}, median", median(passed), "ms", f"{ENGINE} v4", peer_ms)
    yield Row(f"{name}, p99", float(np.percentile(passed, 99)), "ms")


def _peer_ms(asked: Asked) -> float:
    """A classical planner on the decomposed compilation, with its start; the best of three."""
    return min(timed(lambda: solve_with(*asked, ENGINE, Encoding.V4, Objective.SUM, 60.0), 3))


def laps(runs: int) -> Iterator[Row]:
    """Patrols over random places: planning time, and the possible distance from the best plan."""
    seeds = range(max(1, runs // 10))
    for sites in (10, 17) if runs >= 50 else (6,):
        answers = [_answers(sites, 3, seed) for seed in seeds]
        yield Row(f"best lap of {sites} sites", median(a[-1][0] for a in answers), "ms")
    answers = [_answers(50, 3, seed) for seed in seeds]
    yield Row("first plan for 50 sites", median(a[0][0] for a in answers), "ms")
    yield Row("last plan for 50 sites", median(a[-1][0] for a in answers), "ms")
    excess = [100 * (a[-1][1].cost_ms / a[-1][1].bound_ms - 1) for a in answers]
    yield Row("its lap over the lower bound, worst", max(excess), "%")


def large(runs: int) -> Iterator[Row]:
    """Replans of large missions when the target is found, and the first plan of a larger one.

    The planner is prepared as before a run; the first plan includes making the planner.
    """
    seeds = range(max(1, runs // 10))
    for sites, upload_sites in (20, 20), (100, 3), (100, 100):
        found, missed = [], []
        for seed in seeds:
            mission = patrol(sites, upload_sites, seed)
            planner = Planner(mission, straight(mission))
            anticipate_events(planner)
            found += _replan_ms(planner, target_found(planner, "s0"))
            missed += _replan_ms(planner, interrupted(planner, "s0"))
        name = f"replan en route, {sites} sites, {upload_sites} upload sites"
        yield Row(name, median(found), "ms")
        yield Row(f"{name}, patrol", median(missed), "ms")
    took = []
    for seed in seeds:
        mission = patrol(200, 3, seed)

        def first(mission: Mission = mission) -> None:
            planner = Planner(mission, straight(mission))
            next(planner.solver.solutions(*planner.initial_problem()))

        took += timed(first, 1)
    yield Row("planner and first plan, 200 sites", median(took), "ms")
    sites = 196 if runs >= 50 else 16
    mission = patrol_in_a_hall(sites, 3, seed=0)
    took = timed(lambda: prepare(mission), 1)
    yield Row(f"preparation, {sites + 4} places in 60,000 cells", median(took), "ms")


def _replan_ms(planner: Planner, asked: Asked) -> list[float]:
    gc.freeze()  # as before a flight (driving.py)
    try:
        return timed(lambda: planner.solver.replan(*asked), 1)
    finally:
        gc.unfreeze()


def implied(runs: int) -> Iterator[Row]:
    """Patrols with one to three implied lines: the cost of these lines, ideally 0."""
    for sites in (10, 17) if runs >= 50 else (6,):
        excess, took = [], []
        for seed in range(max(1, runs // 10)):
            *_, (_, best) = _answers(sites, 3, seed)
            *_, (ms, found) = _answers(sites, 3, seed, lines=1 + seed % 3)
            excess.append(100 * (found.cost_ms / best.cost_ms - 1))
            took.append(ms)
        yield Row(f"{sites} sites, implied lines: lap over best", max(excess), "%")
        yield Row(f"{sites} sites, implied lines: best lap", median(took), "ms")


def random_missions(runs: int) -> Iterator[Row]:
    """How many plans of random missions are the best of all lassos, by the semantics of LTL."""
    yield Row("random missions, plan is the best lasso", 100 * share_of_best(6 * runs), "%")


def _answers(
    sites: int, upload_sites: int, seed: int, lines: int = 0
) -> list[tuple[float, Solution]]:
    """The solutions of a patrol, each with the milliseconds until it was found."""
    mission = with_implied_lines(patrol(sites, upload_sites, seed), sites, lines, seed)
    planner = Planner(mission, straight(mission))
    asked = planner.initial_problem()
    start_s = perf_counter()
    return [(1000 * (perf_counter() - start_s), s) for s in planner.solver.solutions(*asked)]


def points_between(
    mission: Mission, routes: LayeredRoutes, start: str, goal: str, count: int
) -> Iterator[Ned]:
    """Equally spaced positions on the route from one place to another."""
    route = routes.route(mission.places[start].position, goal)
    assert route is not None
    legs = np.linalg.norm(np.diff(route.waypoints, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(legs)])
    for distance in np.linspace(0.0, along[-1], count + 2)[1:-1]:
        north, east, down = (np.interp(distance, along, axis) for axis in route.waypoints.T)
        yield (float(north), float(east), float(down))
