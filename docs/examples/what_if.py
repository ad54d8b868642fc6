"""Asks for plans from other states, and why there is none.

a target       move(Home, North), report(North), move(North, Home), (wait)^w
North refuses  move(Home, South), report(South), move(South, Home), (wait)^w
South as well  no plan: report cannot hold from here.
with either    canReport(North) or canReport(South)
"""

from companion import Planner, load_mission

MISSION = """
version: 1
name: report
map: {east_m: [-2, 10], north_m: [-10, 10]}
limits: {speed_mps: 2, up_m: [0.5, 4], fence: [[-2, -10], [10, -10], [10, 10], [-2, 10]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2}
  North: {east_m: 8, north_m: 6, up_m: 2}
  South: {east_m: 8, north_m: -8, up_m: 2}
sets: {Place: [Home, North, South], Antenna: [North, South]}
components: {payload: 25}
events: {found: {when: "NAMED_VALUE_INT[target].value > 0", latch: true}}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         effect: at(to) & !at(from), execute: fly(to)}
  report: {parameters: {r: Antenna}, precondition: at(r) & found, assumes: canReport(r),
           effect: reported, execute: "command(payload, MAV_CMD_USER_1)"}
initially: [at(Home)]
task: {report: G (found -> F reported), home: F G at(Home)}
"""

planner = Planner(load_mission(MISSION))
north, south = "canReport(North)", "canReport(South)"
print("a target      ", planner.plan(facts={"found"}))
print("North refuses ", planner.plan(facts={"found"}, without={north}))

reason = planner.explain(facts={"found"}, without={north, south})
print("South as well ", str(reason).splitlines()[0])
print("with either   ", " or ".join(reason.restoring))
