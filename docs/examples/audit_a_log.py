"""Leaves a run folder, as each flight does, and holds it against the task afterwards.

watch  F at(Gate)    unfulfilled
calm   G !intruder   violated at position 1
home   F G at(Home)  satisfied
the flight satisfies its task: False
"""

from companion import audit, load_mission, simulate

MISSION = """
version: 1
name: watch
map: {east_m: [-2, 12], north_m: [-2, 12]}
limits: {speed_mps: 3, up_m: [0.5, 4], fence: [[-2, -2], [12, -2], [12, 12], [-2, 12]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2}
  Gate: {east_m: 10, north_m: 0, up_m: 2}
sets: {Place: [Home, Gate]}
events: {intruder: {when: "NAMED_VALUE_INT[target].value > 0", latch: true}}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         effect: at(to) & !at(from), execute: fly(to)}
initially: [at(Home)]
task:
  watch: F at(Gate)
  calm: G !intruder
  home: F G at(Home)
"""
INTRUDER = {"version": 1, "target": {"seen": {"east_m": 8, "north_m": 0, "radius_m": 1}}}

simulate(load_mission(MISSION), INTRUDER, folder="run")

verdicts = audit("run")  # a folder of `companion sim` and `companion run` is the same
for finding in verdicts.findings:
    since = "" if finding.position is None else f" at position {finding.position}"
    print(f"{finding.name:<6} {finding.formula!s:<13} {finding.outcome.value}{since}")
print("the flight satisfies its task:", not verdicts.is_failure)
