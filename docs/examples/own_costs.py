"""Plans a round with costs of one's own: a function, or a table of seconds.

on the map  B -> C -> A       20.3 s
a road      B -> A -> C -> A  24.1 s
a table     C -> B -> A       13.0 s
"""

import math

from companion import Planner, load_mission

MISSION = """
version: 1
name: round
map: {east_m: [-2, 12], north_m: [-2, 12]}
limits: {speed_mps: 2, up_m: [0.5, 4], fence: [[-2, -2], [12, -2], [12, 12], [-2, 12]]}
places:
  A: {east_m: 0, north_m: 0, up_m: 2}
  B: {east_m: 10, north_m: 0, up_m: 2}
  C: {east_m: 10, north_m: 10, up_m: 2}
sets: {Place: [A, B, C]}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         effect: at(to) & !at(from), execute: fly(to)}
initially: [at(A)]
task: {round: G F at(A) & G F at(B) & G F at(C)}
"""
mission = load_mission(MISSION)
table = {("A", "C"): 6.0, ("C", "B"): 3.0, ("B", "A"): 4.0}  # there are no other ways


def with_a_road(origin: str, goal: str) -> float:
    """Seconds at 2 m/s; the road between B and C costs half a minute more."""
    seconds = math.dist(mission.places[origin].position, mission.places[goal].position) / 2
    return seconds + 30 * ({origin, goal} == {"B", "C"})


for name, costs in [("on the map", None), ("a road", with_a_road), ("a table", table)]:
    plan = Planner(mission, costs).plan()
    lap = " -> ".join(str(action.destination) for action in plan.loop)
    print(f"{name:<11} {lap:<17} {plan.lap_cost_s:.1f} s")
