"""The paper's mission (Section V), from take-off to landing, in lockstep.

The sequence of events is stored in tests/data/surveillance.events.txt: kind and text of each
event that people are told, without times. What is said of the vehicle here is the
simulator's truth, never what telemetry or the companion believe.
"""

from __future__ import annotations

import json
import math
import os
import struct
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from happened import Happened
from lockstep import SETPOINT, World
from notes import Notes
from pictures import truly_drawn
from pymavlink import mavutil

from companion.acting.journal import NoJournal
from companion.app import Companion
from companion.errors import LinkTimeout
from companion.flight_events.event import Stamped
from companion.flight_events.facts import BeliefWithdrawn, MissionEventChanged
from companion.flight_events.fence import FenceWritten
from companion.flight_events.plans import LapCompleted, PlanMade, PlanReplaced
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.flight_events.sortie import Phase, PhaseEntered, TaskSatisfied
from companion.flights.simulated_world import lockstep
from companion.geometry import Ned, horizontal_distance, is_in_polygon
from companion.mission.model import Mission
from companion.record.run_folder import RunFolder
from companion.run_sources.only_run import OnlyRun
from companion.vehicle.run_clocks import ClockReading
from companion.vehicle_profile import VehicleProfile
from sitl.flight.physics import FlightState
from sitl.harness import LockstepFlight
from sitl.link.routing import LinkName
from sitl.simulation import Simulation

QUAD = VehicleProfile()

SURVEILLANCE = Path(__file__).parents[2] / "missions" / "surveillance.yaml"
STORED = Path(__file__).parents[1] / "data" / "surveillance.events.txt"
START_UNIX_S = 1_700_000_000.0


@dataclass
class Flown(Happened):
    """A flight: its run folder, and the vehicle's true state at each tick."""

    folder: Path
    simulation: Simulation
    exit_code: int = -1
    truth: list[tuple[float, FlightState]] = field(default_factory=list)

    @property
    def reports(self) -> list[Stamped]:  # type: ignore[override]
        """As they are recorded."""
        text = (self.folder / "events.jsonl").read_text(encoding="utf-8")
        return [read_line(line) for line in text.splitlines()]

    @property
    def sequence(self) -> str:
        return "".join(f"{event.kind} {event.text}\n" for event in self.events)

    @property
    def task_s(self) -> tuple[float, float]:
        """When the task began, and when the landing did."""
        return (
            self.time_of(PhaseEntered, phase=Phase.TASK),
            self.time_of(PhaseEntered, phase=Phase.LANDING),
        )

    def between(self, start_s: float, end_s: float) -> list[FlightState]:
        return [state for now_s, state in self.truth if start_s <= now_s <= end_s]


class Witness:
    """A recorder that keeps the run folder, and what was true at each tick."""

    flown: Flown

    journal = NoJournal()
    name = ""

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder

    def report(self, stamped: Stamped) -> None:
        self._folder.report(stamped)

    def clocks(self, reading: ClockReading) -> None:
        self._folder.clocks(reading)

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        self._folder.packets(now_s, datagrams)

    def position(self, now_s: float, position: Ned) -> None:
        self._folder.position(now_s, position)
        self.flown.truth.append((now_s, self.flown.simulation.flight))


def fly(mission: Mission, hall: World, seed: int, path: Path) -> Flown:
    folder = RunFolder(path, mission, START_UNIX_S, lambda stamped: None)
    witness = Witness(folder)
    flight = lockstep(Companion(OnlyRun(mission, witness)), hall, seed=seed)
    flown = witness.flown = Flown(path, flight.simulation)
    flight.fly()
    with truly_drawn():
        folder.close()
    companion = flight.companion
    flown.exit_code = companion.failure.exit_code if companion.failure else 0
    return flown


@pytest.fixture(scope="session")
def flown(surveillance: Mission, hall: World, tmp_path_factory: pytest.TempPathFactory) -> Flown:
    return fly(surveillance, hall, seed=0, path=tmp_path_factory.mktemp("seed0"))


# -- what happens ----------------------------------------------------------------------------------


def test_the_sequence_of_events_is_the_stored_one(flown: Flown) -> None:
    assert flown.sequence == STORED.read_text(encoding="utf-8")


def test_the_sequence_is_that_of_the_paper(flown: Flown) -> None:
    """Section V, step by step; the stored file could be replaced by mistake, the paper not."""
    first, second = flown.of(PlanReplaced)
    assert (first.number, second.number) == (1, 2)
    besides = (PhaseEntered, PlanMade, LapCompleted, FenceWritten)
    assert [event for event in flown.events if not isinstance(event, besides)] == [
        PlaceReached("A", "move(Home, A)"),
        PlaceReached("B", "move(A, B)"),
        PlaceReached("C", "move(B, C)"),
        PlaceReached("A", "move(C, A)"),
        MissionEventChanged("targetFound", holds=True),
        first,
        PlaceReached("r1", "move(here, r1)"),
        SkillFailed("upload(r1)", "denied"),
        BeliefWithdrawn("canUpload(r1)"),
        second,
        PlaceReached("r2", "move(r1, r2)"),
        SkillCompleted("upload(r2)"),
        PlaceReached("Home", "move(r2, Home)"),
        TaskSatisfied(),
    ]


def test_each_of_the_two_replans_has_its_reason_and_its_plan(flown: Flown) -> None:
    made = flown.one(PlanMade)
    assert str(made.plan) == "move(Home, A), (move(A, B), move(B, C), move(C, A))^w"
    assert [(replaced.reason, str(replaced.plan)) for replaced in flown.of(PlanReplaced)] == [
        ("target found", "move(here, r1), upload(r1), move(r1, Home), (wait)^w"),
        ("upload(r1) failed: denied", "move(r1, r2), upload(r2), move(r2, Home), (wait)^w"),
    ]


def test_the_target_is_found_on_the_second_way_from_a_to_b(
    flown: Flown, surveillance: Mission
) -> None:
    found_s = flown.time_of(MissionEventChanged, event="targetFound", holds=True)
    before = [s.event for s in flown.reports if s.time_s < found_s]
    places = [event.place for event in before if isinstance(event, PlaceReached)]
    assert places == ["A", "B", "C", "A"]
    found = flown.between(found_s, math.inf)[0].position
    for place in surveillance.places.values():
        assert horizontal_distance(found, place.position) > place.inner_m


def test_nothing_lies_between_the_upload_and_home(flown: Flown, surveillance: Mission) -> None:
    """Not in the events, and not on the way: no region of another place is crossed."""
    uploaded, home = SkillCompleted("upload(r2)"), PlaceReached("Home", "move(r2, Home)")
    assert flown.events[flown.events.index(uploaded) + 1] == home
    way = flown.between(flown.time_of(SkillCompleted), flown.time_of(PlaceReached, place="Home"))
    for name in surveillance.places.keys() - {"r2", "Home"}:
        place = surveillance.places[name]
        nearest_m = min(horizontal_distance(s.position, place.position) for s in way)
        assert nearest_m > place.inner_m, name


def test_it_lands_at_home_with_the_motors_off(flown: Flown, surveillance: Mission) -> None:
    assert flown.exit_code == 0
    assert flown.events[-1] == TaskSatisfied()
    _, last = flown.truth[-1]
    assert horizontal_distance(last.position, surveillance.places["Home"].position) < 0.5
    assert -last.position[2] < 0.05
    assert not flown.simulation.is_armed


# -- how it flies ----------------------------------------------------------------------------------


def test_it_never_comes_near_a_wall(flown: Flown, hall: World) -> None:
    _, grid = hall
    assert grid is not None
    assert flown.simulation.collisions == 0
    clearance_m = min(grid.clearance_m(s.position[:2]) for _, s in flown.truth)
    assert clearance_m >= QUAD.radius_m


def test_it_stays_within_the_limits(flown: Flown, surveillance: Mission) -> None:
    limits = surveillance.limits
    task = flown.between(*flown.task_s)
    low_m, high_m = limits.up_m
    assert all(low_m <= -s.position[2] <= high_m for s in task)
    assert all(is_in_polygon(s.position, limits.fence) for s in task)


def test_it_follows_its_setpoints(flown: Flown) -> None:
    """Distance from the line through the setpoints, the replan at full speed included."""
    line = setpoints(flown.folder / "flight.tlog")
    gaps = [distance_to_line(s.position, line) for s in flown.between(*flown.task_s)]
    assert max(gaps) < 0.15
    assert math.sqrt(sum(g * g for g in gaps) / len(gaps)) < 0.05


def test_it_hardly_exceeds_its_speed(flown: Flown, surveillance: Mission) -> None:
    """The setpoints never do; the vehicle does for a moment, when it makes up a lag."""
    task = flown.between(*flown.task_s)
    assert max(math.hypot(*s.velocity) for s in task) < 1.05 * surveillance.limits.speed_mps


def setpoints(tlog: Path) -> np.ndarray[Any, np.dtype[np.float64]]:
    """(n, 3) the positions in a recorded flight's setpoints, NED."""
    log = mavutil.mavlink_connection(str(tlog))
    found = []
    while message := log.recv_match(type=SETPOINT):
        found.append((message.x, message.y, message.z))
    return np.array(found)


def distance_to_line(point: Ned, line: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    """From a point to the nearest point of a polyline."""
    start, leg = line[:-1], np.diff(line, axis=0)
    length2 = np.maximum((leg**2).sum(axis=1), 1e-12)
    share = np.clip(((np.array(point) - start) * leg).sum(axis=1) / length2, 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, None] * leg - point, axis=1).min())


# -- what remains ----------------------------------------------------------------------------------


def test_the_run_folder_is_complete(flown: Flown, surveillance: Mission) -> None:
    folder = flown.folder
    assert {path.name for path in folder.iterdir()} == {
        *("mission.yaml", "scene.json", "events.jsonl", "flight.tlog", "flight.png"),
        *("plan-0.json", "plan-1.json", "plan-2.json", "clocks.json"),
    }
    assert (folder / "mission.yaml").read_text(encoding="utf-8") == surveillance.text
    plans = [json.loads((folder / f"plan-{n}.json").read_text()) for n in range(3)]
    assert [plan["number"] for plan in plans] == [0, 1, 2]
    assert (folder / "flight.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_the_recording_covers_the_flight(flown: Flown) -> None:
    """Read by pymavlink; each frame stands behind its time, big-endian microseconds."""
    tlog = flown.folder / "flight.tlog"
    (first_us,) = struct.unpack(">Q", tlog.read_bytes()[:8])
    assert first_us == pytest.approx((START_UNIX_S + flown.reports[0].time_s) * 1e6, abs=1e3)
    log = mavutil.mavlink_connection(str(tlog))
    senders, last_s = set(), 0.0
    while message := log.recv_match(type="HEARTBEAT"):
        senders.add((message.get_srcSystem(), message.get_srcComponent()))
        last_s = message._timestamp - START_UNIX_S
    assert senders == {(1, 1), (1, 25), (1, 26), (1, 191), (1, 196)}
    assert flown.reports[-1].time_s - last_s < 1.0


# -- again -----------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_other_gusts_change_nothing_but_times(
    seed: int, flown: Flown, surveillance: Mission, hall: World, tmp_path: Path
) -> None:
    again = fly(surveillance, hall, seed, tmp_path)
    assert again.exit_code == 0
    assert again.simulation.collisions == 0
    assert again.sequence == flown.sequence
    assert again.truth[-1] != flown.truth[-1]


@pytest.mark.long
def test_equal_seeds_give_equal_bytes_in_every_process(flown: Flown, tmp_path: Path) -> None:
    """As a command, with other hashes of strings; and in this process."""
    log_dir = tmp_path / "there"
    child = start_command(log_dir, hash_seed="1")
    printed, _ = child.communicate(timeout=600)
    assert child.returncode == 0, printed
    (there,) = log_dir.iterdir()
    assert (there / "events.jsonl").read_bytes() == (flown.folder / "events.jsonl").read_bytes()


def start_command(log_dir: Path, hash_seed: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "companion", "sim", str(SURVEILLANCE), "--speed", "max"]
    return subprocess.Popen(
        [*command, "--seed", "0", "--log-dir", str(log_dir)],
        env=os.environ | {"PYTHONHASHSEED": hash_seed},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_a_vehicle_that_says_nothing_ends_the_wait(surveillance: Mission, hall: World) -> None:
    elsewhere = Simulation(*hall, seed=0, links=frozenset({LinkName.GCS}))
    with pytest.raises(LinkTimeout, match="no HEARTBEAT of an autopilot in 3 s") as caught:
        LockstepFlight(Companion(OnlyRun(surveillance, Notes())), elsewhere).fly(timeout_s=3.0)
    assert caught.value.exit_code == 4
    assert elsewhere.flight.time_s == pytest.approx(3.0, abs=0.1)
