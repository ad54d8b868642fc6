"""The surveillance mission with more sites, at random places of an open square."""

from __future__ import annotations

import math
import random
from dataclasses import replace

from benches import MISSION
from companion.ltl.parser import parse
from companion.mission.facts import HERE
from companion.mission.loader import load_mission
from companion.mission.model import Mission, Place
from companion.planning.instances import FlightTime
from companion.planning.lasso import Letter, Problem
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState

SIDE_M = 100.0
SPEED_MPS = 2.0
Asked = tuple[Problem, list[list[Letter]]]
"""A problem, and what each conjunct has read."""


def patrol(sites: int, upload_sites: int, seed: int) -> Mission:
    """Search so many sites; report from one of so many others; fly home."""
    searched = [f"s{i}" for i in range(sites)]
    uploads = [f"r{i}" for i in range(upload_sites)]
    names = ["Home", *searched, *uploads]
    chance = random.Random(seed)
    places = {
        name: Place(name, (chance.uniform(0, SIDE_M), chance.uniform(0, SIDE_M), -2.0), 0.6)
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


def with_implied_lines(mission: Mission, sites: int, lines: int, seed: int) -> Mission:
    """A patrol with lines that say nothing new: by one of its lines, or by several together."""
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
    """Flight times as the crow flies; `here` is the middle of the square."""
    positions = {name: place.position for name, place in mission.places.items()}
    positions[HERE] = (SIDE_M / 2, SIDE_M / 2, -2.0)
    return lambda origin, goal: math.dist(positions[origin], positions[goal]) / SPEED_MPS


def target_found(planner: Planner, goal: str) -> Asked:
    """The target is found on the first flight, which leads to some place."""
    return interrupted(planner, goal, "targetFound")


def interrupted(planner: Planner, goal: str, *events: str) -> Asked:
    """The first flight, which leads to some place, is interrupted after some events."""
    task = TaskState(planner)
    task.begin(next(a for a in planner.model.actions if a.name == f"move(Home, {goal})"))
    for event in events:
        task.take(planner.mission.events[event], True)
    task.interrupt()
    return task.problem()
