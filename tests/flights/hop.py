"""A mission of two near places, for tests of what happens around a flight and not in it.

It takes half a minute where the paper's takes more than a minute, and is planned at once.
"""

from __future__ import annotations

from pathlib import Path

HOP = """\
version: 1
name: hop
map: {east_m: [-5, 15], north_m: [-5, 10]}
limits: {speed_mps: 2, up_m: [0.5, 4], fence: [[-4, -4], [14, -4], [14, 9], [-4, 9]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 1.5}
  A: {east_m: 0, north_m: 5, up_m: 1.5}
  B: {east_m: 8, north_m: 0, up_m: 1.5}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    effect: at(to) & !at(from)
    execute: fly(to)
sets: {Place: [Home, A, B]}
initially: [at(Home)]
task: {go: F (at(A) & F at(B)) & F G at(Home)}
"""


def hop_in(folder: Path) -> Path:
    """The mission's file."""
    path = folder / "hop.yaml"
    path.write_text(HOP, encoding="utf-8")
    return path
