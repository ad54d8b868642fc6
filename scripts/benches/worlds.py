"""The surveillance mission with more sites, at random in a square or in a walled hall."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np

from benches import MISSION
from companion.ltl.parser import parse
from companion.mission.facts import HERE
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.places import Place
from companion.motion.grid import OccupancyGrid
from companion.motion.region import Disc
from companion.planning.instances import FlightTime
from companion.planning.lasso import Letter, Problem
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState

SIDE_M = 100.0
HALL_M, HALL_CELL_M = (40.0, 60.0), 0.2
SPEED_MPS = 2.0
Asked = tuple[Problem, list[list[Letter]]]
"""A problem, and what each conjunct has read."""


def patrol(sites: int, upload_sites: int, seed: int) -> Mission:
    """Searches `sites` sites, reports from one of `upload_sites` others, flies home."""
    searched = [f"s{i}" for i in range(sites)]
    uploads = [f"r{i}" for i in range(upload_sites)]
    names = ["Home", *searched, *uploads]
    chance = random.Random(seed)
    places = {
        name: Place(name, (chance.uniform(0, SIDE_M), chance.uniform(0, SIDE_M), -2.0), Disc(0.6))
        for name in names
    }
    search = " & ".join(f"F (at({name}) | targetFound)" for name in searched)
    mission = load_mission(MISSION)
    return replace(
        mission,
        places=places,
        sets={"Place": tuple(names), "UploadSite": tuple(uploads)},
        task={**mission.task, "search": parse(f"G ({search})")},
    )


def patrol_in_a_hall(sites: int, upload_sites: int, seed: int) -> Mission:
    """The same in a hall of 60,000 cells with five walls, each with three gaps."""
    chance = random.Random(seed)
    grid = OccupancyGrid(_walls(chance), HALL_CELL_M, (0.0, 0.0))
    mission = patrol(sites, upload_sites, seed)
    positions: list[tuple[float, float]] = []
    while len(positions) < len(mission.places):
        position = chance.uniform(1.0, HALL_M[0] - 1.0), chance.uniform(1.0, HALL_M[1] - 1.0)
        is_apart = all(math.dist(position, other) > 1.0 for other in positions)
        if is_apart and grid.clearance_m(position) > 0.8:
            positions.append(position)
    places = {
        name: Place(name, (*position, -2.0), Disc(0.5))
        for name, position in zip(mission.places, positions, strict=True)
    }
    (north, east) = HALL_M
    fence = ((0.0, 0.0), (north, 0.0), (north, east), (0.0, east))
    return replace(mission, places=places, grid=grid, limits=replace(mission.limits, fence=fence))


def _walls(chance: random.Random) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    rows, cols = (round(edge_m / HALL_CELL_M) for edge_m in HALL_M)
    occupied = np.zeros((rows, cols), dtype=np.bool_)
    for wall in range(1, 6):
        col = round(cols * wall / 6)
        occupied[:, col : col + 2] = True
        for _ in range(3):
            row = chance.randrange(rows - 20)
            occupied[row : row + 18, col : col + 2] = False
    return occupied


def with_implied_lines(mission: Mission, sites: int, lines: int, seed: int) -> Mission:
    """A patrol with redundant lines: implied by one of its lines, or by several together."""
    chance = random.Random(seed)
    kinds = (
        "G ({} -> F {})",
        "F ({} & F {})",
        "G ({} -> F ({} & F {}))",
        "G ({} -> X F {} & F {})",
    )
    added = {}
    for number in range(lines):
        kind = kinds[(seed + number) % len(kinds)]
        places = chance.sample(range(sites), kind.count("{}"))
        line = kind.format(*(f"at(s{place})" for place in places))
        added[f"implied_{number}"] = parse(f"({line}) | targetFound")
    return replace(mission, task={**mission.task, **added})


def straight(mission: Mission) -> FlightTime:
    """Flight times in straight lines; `here` is the middle of the square."""
    positions = {name: place.position for name, place in mission.places.items()}
    positions[HERE] = (SIDE_M / 2, SIDE_M / 2, -2.0)
    return lambda origin, goal: math.dist(positions[origin], positions[goal]) / SPEED_MPS


def target_found(planner: Planner, goal: str) -> Asked:
    """The target is found on the first flight to a place."""
    return interrupted(planner, goal, "targetFound")


def interrupted(planner: Planner, goal: str, *events: str) -> Asked:
    """The first flight to a place is interrupted after some events."""
    task = TaskState(planner)
    task.begin(next(a for a in planner.actions.model.actions if a.name == f"move(Home, {goal})"))
    for event in events:
        task.take(planner.mission.events[event], True)
    task.interrupt()
    return task.problem()
