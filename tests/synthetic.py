"""Small missions for tests, made without files: an empty room, and places on a square of 6 m.

A --- B          north
|     |            |
H --- C            +-- east
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from companion.errors import KeyPath
from companion.geometry import Ned
from companion.ltl.parser import parse_line
from companion.mission.conditions import parse_condition
from companion.mission.events import Event
from companion.mission.facts import Fact
from companion.mission.literals import parse_fact, parse_literals
from companion.mission.model import Mission
from companion.mission.otherwise import LandAtSafePlace, Otherwise
from companion.mission.places import Limits, Place
from companion.mission.signals import Signal
from companion.mission.skills import Skill
from companion.mission.steps import Command, Execution, Fly
from companion.motion.grid import OccupancyGrid
from companion.motion.region import Disc
from companion.planning.planner import Planner

POSITIONS: dict[str, Ned] = {
    "H": (0.0, 0.0, -2.0),
    "A": (6.0, 0.0, -2.0),
    "B": (6.0, 6.0, -2.0),
    "C": (0.0, 6.0, -2.0),
}
FENCE = ((-1.5, -1.5), (-1.5, 7.5), (7.5, 7.5), (7.5, -1.5))
PAYLOAD, USER_1 = 25, 31010


def skill(
    name: str,
    execute: Execution,
    parameters: str = "",
    precondition: str = "",
    assumes: Iterable[str] = (),
    effect: str = "",
    cost_s: float | None = 3.0,
    tries: int = 1,
    timeout_s: float | None = None,
) -> Skill:
    """A skill, its literals written as in a mission file; every parameter is a place."""
    return Skill(
        name=name,
        parameters=tuple((p, "Place") for p in parameters.split()),
        precondition=parse_literals(precondition) if precondition else (),
        assumes=tuple(parse_fact(text) for text in assumes),
        effect=parse_literals(effect) if effect else (),
        cost_s=cost_s,
        execute=(execute,),
        tries=tries,
        timeout_s=timeout_s,
    )


def move(tries: int = 3, timeout_s: float | None = None, precondition: str = "at(from)") -> Skill:
    """The paper's move."""
    return skill(
        "move",
        Fly("to"),
        "from to",
        precondition,
        ["trans_ok(from, to)"],
        "at(to) & !at(from)",
        cost_s=None,
        tries=tries,
        timeout_s=timeout_s,
    )


def command(name: str, precondition: str = "", effect: str = "", **more: float | None) -> Skill:
    """A skill that sends MAV_CMD_USER_1 to the payload; it assumes can_<name>."""
    execute = Command(PAYLOAD, USER_1, "MAV_CMD_USER_1", (1.5, -2.0))
    return skill(name, execute, "", precondition, [f"can_{name}"], effect, **more)  # type: ignore[arg-type]


def event(
    name: str, latch: bool = False, for_s: float = 0.0, restarts: Iterable[str] = ()
) -> Event:
    """An event that is true while NAMED_VALUE_INT of its name is positive."""
    when = parse_condition(f"NAMED_VALUE_INT[{name}].value > 0")
    return Event(name, when, None, latch, for_s, frozenset(restarts))


def reading(name: str, value: float = 1.0) -> tuple[Signal, float]:
    """A reading for an event made by `event`."""
    return (Signal("NAMED_VALUE_INT", name, "value"), value)


def facts_of(*spellings: str) -> frozenset[Fact]:
    """Facts, spelled as in a mission file."""
    return frozenset(map(Fact.parse, spellings))


def mission(
    task: str | Mapping[str, str],
    places: str = "HAB",
    skills: Iterable[Skill] = (),
    events: Iterable[Event] = (),
    initially: Iterable[str] = ("at(H)",),
    otherwise: Otherwise | LandAtSafePlace = Otherwise.LAND,
    priorities: Mapping[str, int] | None = None,
) -> Mission:
    """A mission that starts at H and can move; a task that is one text is called "task"."""
    lines = {"task": task} if isinstance(task, str) else task
    skills = tuple(skills)
    own_move = () if any(s.name == "move" for s in skills) else (move(),)
    return Mission(
        name="synthetic",
        path="synthetic.yaml",
        text="name: synthetic\n",
        grid=OccupancyGrid(np.zeros((20, 20), dtype=np.bool_), 0.5, (-2.0, -2.0)),
        limits=Limits(speed_mps=2.0, up_m=(0.5, 4.0), fence=FENCE),
        places={name: Place(name, POSITIONS[name], Disc(0.6)) for name in places},
        sets={"Place": tuple(places)},
        events={e.name: e for e in events},
        skills={s.name: s for s in (*own_move, *skills)},
        initially=frozenset(map(Fact.parse, initially)),
        task={name: parse_line(text) for name, text in lines.items()},
        otherwise=otherwise,
        priorities=priorities or {},
        lines_at={name: KeyPath(("task", name)) for name in lines},
    )


def planner(asked: Mission) -> Planner:
    """A planner for whom every flight takes four seconds."""
    return Planner(asked, lambda origin, goal: 4.0)
