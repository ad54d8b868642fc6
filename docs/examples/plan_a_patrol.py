"""Plans a patrol of two sites around a wall.

once      move(Home, A)
for ever  move(A, B), move(B, A)
a lap     16.2 s, the shortest: True
"""

from companion import Planner, load_mission

MISSION = """
version: 1
name: patrol
map: {east_m: [-2, 14], north_m: [-2, 14], walls: [{east_m: [5, 6], north_m: [-2, 9]}]}
limits: {speed_mps: 2, up_m: [0.5, 4], fence: [[-2, -2], [14, -2], [14, 14], [-2, 14]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2}
  A: {east_m: 2, north_m: 8, up_m: 2}
  B: {east_m: 11, north_m: 2, up_m: 2}
sets: {Place: [Home, A, B]}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    effect: at(to) & !at(from)
    execute: fly(to)
initially: [at(Home)]
task:
  patrol: G F at(A) & G F at(B)
"""

plan = Planner(load_mission(MISSION)).plan()

print("once     ", ", ".join(action.name for action in plan.prefix))
print("for ever ", ", ".join(action.name for action in plan.loop))
print(f"a lap     {plan.lap_cost_s:.1f} s, the shortest: {plan.is_optimal}")
