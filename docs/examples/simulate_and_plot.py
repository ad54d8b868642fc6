"""Flies a patrol in the simulator until a target is seen, and draws the flight to flight.png.

24.6 s  found
31.2 s  at A
35.8 s  at Home
43.1 s  task satisfied, landed
"""

from matplotlib.figure import Figure

from companion import load_mission, simulate
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import RunEnded

MISSION = """
version: 1
name: search
map: {east_m: [-2, 14], north_m: [-2, 14], walls: [{east_m: [5, 6], north_m: [-2, 9]}]}
limits: {speed_mps: 3, up_m: [0.5, 4], fence: [[-2, -2], [14, -2], [14, 14], [-2, 14]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2}
  A: {east_m: 2, north_m: 8, up_m: 2}
  B: {east_m: 11, north_m: 2, up_m: 2}
sets: {Place: [Home, A, B]}
events: {found: {when: "NAMED_VALUE_INT[target].value > 0", latch: true}}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         effect: at(to) & !at(from), execute: fly(to)}
initially: [at(Home)]
task: {search: G (F at(A) | found) & G (F at(B) | found), home: G (found -> F G at(Home))}
"""
SEEN = {"east_m": 8, "north_m": 10, "radius_m": 2, "visit": 2}  # at the second visit
WORLD = {"version": 1, "wind": {"east_mps": 2, "north_mps": 1}, "target": {"seen": SEEN}}
TOLD = (MissionEventChanged, PlaceReached, RunEnded)

run = simulate(load_mission(MISSION), WORLD, seed=7)
for stamped in run.events:
    if isinstance(stamped.event, TOLD) and stamped.time_s > 23:
        print(f"{stamped.time_s:5.1f} s  {stamped.event.text}")

axes = Figure().subplots()
axes.plot(run.trajectory.east_m, run.trajectory.north_m)
axes.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
axes.figure.savefig("flight.png")
