"""Random missions and the worlds that they are flown in.

Places between walls, lines of all kinds, skills that fail or land, and events at any time, in the
air and on the ground. The walls are on the map and the wind is weak: nothing excuses a crash.
"""

from __future__ import annotations

import math
from random import Random
from typing import Any

Data = dict[str, Any]
HOME = (0.0, 0.0)
APART_M, OFF_WALLS_M = 2.0, 1.2
CALLS = {"alarm": "MAV_CMD_USER_3", "calledHome": "MAV_CMD_NAV_RETURN_TO_LAUNCH"}
BUSY, FREE = "MAV_CMD_USER_1", "MAV_CMD_USER_2"
ERRANDS = (
    "F at({a})",
    "visit({a}, {b})",
    "sequenced_visit({a}, {b})",
    "ordered_visit({a}, {b})",
    "F at({a}) & (!at({a})) U at({b})",
    "patrolling({a}, {b}) | F calledHome",
    "G F (at({a}) | calledHome)",
    "revisit(at({a}) | calledHome) <= 200 s",
)
ANSWERS = ("F at({a})", "X at({a})", "F[<=120s] at({a})", "(!at({b}) U at({a}))")
WORKS: tuple[tuple[str | list[str], float], ...] = (
    ("command(payload, MAV_CMD_USER_1)", 8.0),
    (["wait(1)", "command(payload, MAV_CMD_USER_1)"], 8.0),
    (["land()", "command(payload, MAV_CMD_USER_1)", "take_off()"], 60.0),
)
"""What a skill executes, and its time limit in seconds."""


def random_flight(seed: int) -> tuple[Data, Data]:
    """A mission and a scenario, as in their files."""
    chance = Random(seed)
    width_m, height_m = chance.choice(((20, 15), (30, 30), (60, 40)))
    walls = _walls(chance, width_m, height_m)
    places = _places(chance, walls, width_m, height_m)
    names = [name for name in places if name != "Home"]
    mission: Data = {
        "version": 1,
        "name": f"random_{seed}",
        "limits": {
            "speed_mps": chance.choice((2.0, 4.0)),
            "up_m": [1, 6],
            "fence": [[-5, -5], [width_m, -5], [width_m, height_m], [-5, height_m]],
        },
        "map": {"walls": walls},
        "places": places,
        "sets": {"Place": [*places], "Site": chance.sample(names, 2)},
        "components": {"payload": 25},
        "skills": {"move": _move(chance), "work": _work(chance)},
        "events": {
            "alarm": {"when": f"COMMAND.{CALLS['alarm']}"},
            "calledHome": {"when": f"COMMAND.{CALLS['calledHome']}", "latch": True},
            "busy": {"when": f"COMMAND.{BUSY}", "until": f"COMMAND.{FREE}"},
        },
        "initially": ["at(Home)"],
        "otherwise": chance.choice(("return_home", "land", {"land_at": ["Home", names[0]]})),
        "patience_s": 5,
    }
    mission["task"] = _task(chance, names, mission["sets"]["Site"])
    scenario: Data = {
        "version": 1,
        "map": {"east_m": [-20, width_m + 20], "north_m": [-20, height_m + 20], "walls": walls},
        "wind": {"east_mps": chance.uniform(-2, 2), "turbulence_mps": chance.uniform(0, 0.2)},
        "payload": _payload(chance, [places[site] for site in mission["sets"]["Site"]]),
        "happens": _happens(chance),
    }
    return mission, scenario


def _walls(chance: Random, width_m: float, height_m: float) -> list[Data]:
    walls = []
    for _ in range(chance.randint(1, 4)):
        east_m, north_m = chance.uniform(3, width_m - 6), chance.uniform(3, height_m - 6)
        long_m, is_along_east = chance.uniform(1, 5), chance.random() < 0.5
        size_m = (long_m, 0.3) if is_along_east else (0.3, long_m)
        wall: Data = {
            "east_m": [round(east_m, 1), round(east_m + size_m[0], 1)],
            "north_m": [round(north_m, 1), round(north_m + size_m[1], 1)],
        }
        walls.append(wall | ({"up_m": 3} if chance.random() < 0.3 else {}))
    return walls


def _places(chance: Random, walls: list[Data], width_m: float, height_m: float) -> Data:
    taken = [HOME]
    while len(taken) < 5:
        spot = chance.uniform(0, width_m - 2), chance.uniform(0, height_m - 2)
        is_apart = all(math.dist(spot, other) > APART_M for other in taken)
        if is_apart and not any(_is_near(wall, spot) for wall in walls):
            taken.append(spot)
    return {
        name: {"east_m": round(east, 1), "north_m": round(north, 1), "up_m": chance.randint(2, 5)}
        for name, (east, north) in zip(("Home", *"ABCD"), taken, strict=True)
    }


def _is_near(wall: Data, spot: tuple[float, float]) -> bool:
    sides = zip((wall["east_m"], wall["north_m"]), spot, strict=True)
    return all(low - OFF_WALLS_M < at < high + OFF_WALLS_M for (low, high), at in sides)


def _move(chance: Random) -> Data:
    return {
        "parameters": {"from": "Place", "to": "Place"},
        "precondition": "at(from)",
        "assumes": "trans_ok(from, to)",
        "effect": "at(to) & !at(from)",
        "cost": "flight_time",
        "execute": "fly(to)",
        "tries": chance.choice((1, 3)),
    }


def _work(chance: Random) -> Data:
    execute, timeout_s = chance.choice(WORKS)
    return {
        "parameters": {"s": "Site"},
        "precondition": "at(s)",
        "assumes": "works(s)",
        "effect": "done(s)",
        "execute": execute,
        "tries": chance.choice((1, 2)),
        "timeout_s": timeout_s,
    }


def _task(chance: Random, names: list[str], sites: list[str]) -> Data:
    def filled(formula: str) -> str:
        a, b = chance.sample(names, 2)
        return formula.format(a=a, b=b)

    task: Data = {"errand": filled(chance.choice(ERRANDS))}
    if chance.random() < 0.7:
        task["work"] = f"F done({chance.choice(sites)})"
    if chance.random() < 0.7:
        task["answer"] = f"G (alarm -> {filled(chance.choice(ANSWERS))})"
    if chance.random() < 0.4:
        task["door"] = {"formula": filled("G (busy -> !at({a}))"), "priority": 2}
    if chance.random() < 0.3:
        task["far"] = {"formula": filled("G F (at({a}) | calledHome)"), "priority": 1}
    return task | {"recall": "delayed_reaction(calledHome, at(Home))"}


def _payload(chance: Random, sites: list[Data]) -> Data:
    circles = [
        {
            "east_m": site["east_m"],
            "north_m": site["north_m"],
            "radius_m": 1.5,
            "result": chance.choice(("ACCEPTED", "ACCEPTED", "DENIED", "TEMPORARILY_REJECTED")),
            "after_s": chance.uniform(0.2, 4),
            "lost": chance.random() < 0.2,
        }
        for site in sites
    ]
    return {"command": "MAV_CMD_USER_1", "answers": circles, "otherwise": "ACCEPTED"}


def _happens(chance: Random) -> list[Data]:
    """The operator's commands; one that is called home late ends what has no end."""
    busy_s = chance.uniform(5, 60)
    given = [(chance.uniform(5, 110), CALLS["alarm"]) for _ in range(chance.randint(0, 4))]
    given += [(busy_s, BUSY), (busy_s + chance.uniform(5, 60), FREE)]
    given.append((chance.uniform(80, 120), CALLS["calledHome"]))
    return [{"at_s": round(at_s, 1), "operator": command} for at_s, command in sorted(given)]
