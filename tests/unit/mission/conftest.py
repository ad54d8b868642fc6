"""A small good mission on a small map, for tests that spoil it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from companion.mission.loader import load_mission
from companion.mission.model import Mission

GOOD = """\
version: 1
name: patrol
frame: enu
map: room.yaml
limits:
  speed_mps: 2.0
  up_m: [0.5, 4.0]
  fence: [[0, 0], [10, 0], [10, 8.5], [0, 8.5]]
places:
  Home: {east_m: 2, north_m: 2, up_m: 1.5}
  A: {east_m: 5, north_m: 7, up_m: 1.5}
  no: {east_m: 8, north_m: 2, up_m: 1.5, radius_m: 0.4}
sets:
  Place: [Home, A, no]
  Site: [A, no]
components: {payload: 25}
events:
  found:
    when: NAMED_VALUE_INT[target].value > 0
    latch: true
  low:
    when: BATTERY_STATUS.battery_remaining < 30
    until: BATTERY_STATUS.battery_remaining > 80
    for_s: 2
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    assumes: trans_ok(from, to)
    effect: at(to) & !at(from)
    cost: flight_time
    execute: fly(to)
    tries: 3
  upload:
    parameters: {r: Site}
    precondition: at(r) & found & !low
    assumes: [canUpload(r)]
    effect: reported
    cost: 10
    execute: command(payload, MAV_CMD_USER_1, 1.5, -2)
    timeout_s: 15
initially: [at(Home)]
task:
  search: G (F at(A) | found)
  upload: >
    G (found ->
       F reported)
  avoid: 'G !(at(no) & low)'
otherwise: land
"""

MAP = """\
image: room.pgm
resolution: 0.5
origin: [0, 0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
EDGE = 20
"""Cells; the room is 10 m x 10 m, with a wall of one cell around it."""


@pytest.fixture(scope="session")
def good() -> str:
    """The text of the good mission."""
    return GOOD


@pytest.fixture(scope="session")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the map."""
    folder = tmp_path_factory.mktemp("room")
    (folder / "room.yaml").write_text(MAP)
    inner = range(1, EDGE - 1)
    pixels = bytes(255 * (r in inner and c in inner) for r in range(EDGE) for c in range(EDGE))
    (folder / "room.pgm").write_bytes(b"P5 %d %d 255\n" % (EDGE, EDGE) + pixels)
    return folder


@pytest.fixture(scope="session")
def load(room: Path) -> Callable[[str | bytes], Mission]:
    """Loads a mission from its text."""

    def load_text(content: str | bytes) -> Mission:
        path = room / "mission.yaml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return load_mission(path)

    return load_text
