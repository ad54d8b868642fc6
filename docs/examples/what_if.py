"""Asks a planner for plans from other states, and why there is none.

at the start      (wait)^w
a target          move(Home, North), report(North), move(North, Home), (wait)^w
North refuses     move(Home, South), report(South), move(South, Home), (wait)^w
both refuse       report: reported can never become true
with either of    canReport(North), canReport(South)
"""

from companion import Planner, load_mission

MISSION = """
version: 1
name: report
map: {east_m: [-2, 12], north_m: [-12, 12]}
limits: {speed_mps: 2, up_m: [0.5, 4], fence: [[-2, -12], [12, -12], [12, 12], [-2, 12]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2}
  North: {east_m: 8, north_m: 6, up_m: 2}
  South: {east_m: 8, north_m: -8, up_m: 2}
sets: {Place: [Home, North, South], Antenna: [North, South]}
components: {payload: 25}
events:
  found: {when: "NAMED_VALUE_INT[target].value > 0", latch: true}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    effect: at(to) & !at(from)
    execute: fly(to)
  report:
    parameters: {r: Antenna}
    precondition: at(r) & found
    assumes: canReport(r)
    effect: reported
    execute: command(payload, MAV_CMD_USER_1)
initially: [at(Home)]
task: {report: G (found -> F reported), home: F G at(Home)}
"""

planner = Planner(load_mission(MISSION))
north, south = "canReport(North)", "canReport(South)"

print("at the start     ", planner.plan())
print("a target         ", planner.plan(facts={"found"}))
print("North refuses    ", planner.plan(facts={"found"}, without={north}))

reason = planner.explain(facts={"found"}, without={north, south})
conflict, unreachable = reason.conflict[0], reason.unreachable[0]
print("both refuse      ", f"{conflict.name}: {unreachable.fact} can never become true")
print("with either of   ", ", ".join(reason.restoring))
