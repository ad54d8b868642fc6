"""Writes a mission of nine sites as Python data; a mistake in it is told with its keys.

s01 -> s02 -> s11 -> s12 -> s22 -> s21 -> s20 -> s10 -> s00
44.0 s a lap, the shortest: True
task.patrol: unknown fact at(s33)
"""

from companion import MissionError, Planner, load_mission

SITES = {f"s{row}{column}": (10 * row, 10 * column) for row in range(3) for column in range(3)}
MOVE = {
    "parameters": {"from": "Place", "to": "Place"},
    "precondition": "at(from)",
    "effect": "at(to) & !at(from)",
    "execute": "fly(to)",
}
mission = {
    "version": 1,
    "name": "nine-sites",
    "map": {"east_m": [-5, 25], "north_m": [-5, 25], "cell_m": 0.25},
    "limits": {"speed_mps": 5, "up_m": [1, 20], "fence": [[-4, -4], [24, -4], [24, 24], [-4, 24]]},
    "places": {
        name: {"east_m": east_m, "north_m": north_m, "up_m": 10}
        for name, (north_m, east_m) in SITES.items()
    },
    "sets": {"Place": list(SITES)},
    "skills": {"move": MOVE},
    "initially": ["at(s00)"],
    "task": {"patrol": " & ".join(f"G F at({name})" for name in SITES)},
}

plan = Planner(load_mission(mission)).plan()
print(" -> ".join(str(action.destination) for action in plan.loop))
print(f"{plan.lap_cost_s:.1f} s a lap, the shortest: {plan.is_optimal}")

try:
    load_mission({**mission, "task": {"patrol": "G F at(s33)"}})
except MissionError as error:
    print(str(error).splitlines()[0])
