"""What a flight depends on besides its row: code, libraries, and the machine.

Where these are the same, equal rows give equal flights. The last of them is a fingerprint: the hash
of all datagrams and events of a short flight through gusts with a noisy lidar. It differs on
machines whose mathematical functions differ in their last bits.
mathematical functions differ in their last bits have another one.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib import metadata
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path

from companion.api.results import Recording
from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flights.simulated_world import lockstep, world_of
from companion.mission.installed_calls import functions_of
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.run_sources.only_run import OnlyRun
from companion.skills.loading import entries, source_of

LIBRARIES = ("jsbsim", "numpy", "pymavlink", "ruckig", "scipy")
FINGERPRINT_TICKS = 180
"""9 s: the start, the climb, and a part of the route."""
PACKAGES = ("companion", "sitl")
SHORT = """
version: 1
name: fingerprint
map: {east_m: [-6, 8], north_m: [-6, 8], walls: [{east_m: [4, 5], north_m: [-3, -2]}]}
limits: {speed_mps: 4, up_m: [0.5, 4], fence: [[-5, -5], [7, -5], [7, 7], [-5, 7]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 1}
  Far: {east_m: 4, north_m: 1, up_m: 1}
sets: {Place: [Home, Far]}
skills:
  move: {parameters: {from: Place, to: Place}, precondition: at(from),
         effect: at(to) & !at(from), execute: fly(to)}
initially: [at(Home)]
goal: at(Far)
"""
GUSTY = {
    "version": 1,
    "wind": {"east_mps": 3.0, "north_mps": 1.0, "turbulence_mps": 0.5},
    "lidar": {"noise_m": 0.02},
    "wander": {},
}


class Hashing(Recording):
    """A recorder that hashes all datagrams and events."""

    def __init__(self) -> None:
        super().__init__()
        self.hash = hashlib.sha256()

    def report(self, stamped: Stamped) -> None:
        """Adds an event to the hash."""
        self.hash.update(f"{stamped.time_s!r} {stamped.event.text}\n".encode())

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Adds datagrams of the link to the hash."""
        for datagram in datagrams:
            self.hash.update(datagram)


@cache
def environment() -> Mapping[str, str]:
    """The environment of this process, as lines of a table's header."""
    return {
        "code": _hash_of_code(),
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
        "fingerprint": fingerprint(),
    }


def environment_of(mission: Mission) -> Mapping[str, str]:
    """The same for a mission, with the packages whose functions it calls."""
    functions = functions_of(mission)
    claimed = (entry for function, entry in entries() if function in functions) if functions else ()
    return {**environment(), **dict(map(_package_line, claimed))}


def _package_line(entry: EntryPoint) -> tuple[str, str]:
    name = entry.module.partition(".")[0]
    return f"package {name}", f"{source_of(entry)} {_hash_of_package(name)}"


def fingerprint() -> str:
    """The hash of the short flight on this machine."""
    mission, recorder = load_mission(SHORT), Hashing()
    flight = lockstep(Companion(OnlyRun(mission, recorder)), world_of(mission, GUSTY), seed=17)
    for _ in range(FINGERPRINT_TICKS):
        flight.tick()
    return recorder.hash.hexdigest()[:16]


def _hash_of_code() -> str:
    root = Path(__file__).parents[2]
    paths = (path for package in PACKAGES for path in sorted((root / package).rglob("*.py")))
    return _hash_of_files(root, paths)


def _hash_of_package(name: str) -> str:
    """The hash of all files of a package, or of a module's file; it is not imported."""
    spec = find_spec(name)
    if spec is None:
        return "not found"
    roots = [Path(root) for root in spec.submodule_search_locations or ()]
    if not roots and spec.origin is not None:
        return _hash_of_files(Path(spec.origin).parent, [Path(spec.origin)])
    return " ".join(_hash_of_files(root, sorted(_sources(root))) for root in roots)


def _sources(root: Path) -> Iterator[Path]:
    return (p for p in root.rglob("*") if p.is_file() and p.parent.name != "__pycache__")


def _hash_of_files(root: Path, paths: Iterable[Path]) -> str:
    hashed = hashlib.sha256()
    for path in paths:
        hashed.update(str(path.relative_to(root)).encode() + path.read_bytes())
    return hashed.hexdigest()[:16]
