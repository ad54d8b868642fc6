"""Flies one mission in rough air with several seeds, in as many processes as there are cores.

seed 0: exit code 0, 5 cm off the line
seed 1: exit code 0, 4 cm off the line
seed 2: exit code 0, 5 cm off the line
"""

from concurrent.futures import ProcessPoolExecutor

import numpy as np

from companion import load_mission, simulate

MISSION = """
version: 1
name: round
map: {east_m: [-2, 12], north_m: [-2, 12]}
limits: {speed_mps: 3, up_m: [0.5, 4], fence: [[-2, -2], [12, -2], [12, 12], [-2, 12]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2}
  A: {east_m: 10, north_m: 10, up_m: 2}
sets: {Place: [Home, A]}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         effect: at(to) & !at(from), execute: fly(to)}
initially: [at(Home)]
goal: at(A)
"""
WORLD = {"version": 1, "wind": {"east_mps": 4, "turbulence_mps": 0.5}}


def fly(seed: int) -> tuple[int, float]:
    """The exit code, and how far the vehicle was off the straight line at worst, metres."""
    run = simulate(load_mission(MISSION), WORLD, seed=seed)
    off_m = (run.trajectory.east_m - run.trajectory.north_m) / np.sqrt(2)
    return run.exit_code, float(np.abs(off_m).max())


if __name__ == "__main__":
    with ProcessPoolExecutor() as pool:
        for seed, (exit_code, off_m) in enumerate(pool.map(fly, range(3))):
            print(f"seed {seed}: exit code {exit_code}, {100 * off_m:.0f} cm off the line")
