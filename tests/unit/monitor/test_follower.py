"""A run folder as it is read for the page: what was recorded, whenever and however it is read."""

from __future__ import annotations

import base64
import itertools
import json
import math
import random
import zlib
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from pymavlink import mavutil

from companion import simulate
from companion.app import Companion
from companion.errors import MissionError
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.fence import FenceKept
from companion.flight_events.reading import read_line
from companion.flight_events.sortie import RunEnded
from companion.flight_events.word import PositionLeft
from companion.flight_events.writing import line_of
from companion.flights.simulated_world import lockstep, world_of
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.monitor.follower import Follower
from companion.monitor.page_events import (
    AutomataDrawn,
    AutomataMoved,
    CellsChanged,
    DerivedEvent,
    RoutePlanned,
)
from companion.monitor.scene import read_scene
from companion.record.run_folder import RunFolder
from companion.run_sources.only_run import OnlyRun

MISSIONS = Path(__file__).parents[3] / "missions"
SEEN_TICKS = 600
"""Of the inspection mission until walls have been seen that its map does not show."""


def read_whole(folder: Path) -> Follower:
    run = Follower(folder, is_live=False)
    while run.read():
        pass
    return run


@pytest.fixture(scope="module")
def whole(surveillance_run: Path) -> Follower:
    return read_whole(surveillance_run)


def recorded(folder: Path) -> list[Stamped]:
    text = (folder / "events.jsonl").read_text(encoding="utf-8")
    return [read_line(line) for line in text.splitlines()]


E = TypeVar("E", bound=FlightEvent)


def of(run: Follower, kind: type[E]) -> list[E]:
    return [stamped.event for stamped in run.events if isinstance(stamped.event, kind)]


def test_every_recorded_event_comes_once_and_in_order(
    whole: Follower, surveillance_run: Path
) -> None:
    told = [stamped for stamped in whole.events if not isinstance(stamped.event, DerivedEvent)]
    assert told == recorded(surveillance_run)
    times = [stamped.time_s for stamped in whole.events]
    assert times == sorted(times)


def test_snapshots_are_what_pymavlink_reads_in_the_log(
    whole: Follower, surveillance_run: Path
) -> None:
    log = mavutil.mavlink_connection(str(surveillance_run / "flight.tlog"))
    heard: dict[str, list[tuple[float, Any]]] = {
        "LOCAL_POSITION_NED": [],
        "SET_POSITION_TARGET_LOCAL_NED": [],
        "BATTERY_STATUS": [],
    }
    while (message := log.recv_match(type=list(heard))) is not None:
        heard[message.get_type()].append((message._timestamp - 1_700_000_000.0, message))
    log.close()

    def newest(kind: str, time_s: float) -> Any:
        return next((m for t, m in reversed(heard[kind]) if t <= time_s + 1e-3), None)

    assert len(whole.snapshots) > 300
    gaps = np.diff([snapshot.time_s for snapshot in whole.snapshots])
    assert np.all(gaps[1:] > 0.19) and np.all(gaps < 0.26)
    for snapshot in whole.snapshots[10::25]:
        position = newest("LOCAL_POSITION_NED", snapshot.time_s)
        assert snapshot.position == pytest.approx((position.x, position.y, position.z), abs=1e-6)
        cells_mv = newest("BATTERY_STATUS", snapshot.time_s).voltages
        volts = sum(each for each in cells_mv if each != 65535) / 1000
        assert snapshot.voltage_v == pytest.approx(volts) and 14 < volts < 17
        if snapshot.setpoint is not None:
            sent = newest("SET_POSITION_TARGET_LOCAL_NED", snapshot.time_s)
            assert snapshot.setpoint == pytest.approx((sent.x, sent.y, sent.z), abs=1e-6)
    assert {"OFFBOARD", "AUTO.TAKEOFF", "AUTO.LAND"} <= {s.mode for s in whole.snapshots}
    assert whole.snapshots[0].battery_percent == 100


def test_zones_have_their_names_on_the_page(surveillance_run: Path, tmp_path: Path) -> None:
    scene = json.loads((surveillance_run / "scene.json").read_text(encoding="utf-8"))
    scene["keep_out"] = {"pond": [[1, 2], [3, 2], [3, 4]]}
    (tmp_path / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
    (zone,) = Follower(tmp_path, is_live=False).mission["keep_out"]
    assert zone == {"name": "pond", "corners": [[1.0, 2.0], [3.0, 2.0], [3.0, 4.0]]}


def test_the_clearance_is_that_of_the_map(whole: Follower, surveillance_run: Path) -> None:
    grid = read_scene(surveillance_run).grid
    for snapshot in whole.snapshots[::25]:
        north, east, _ = snapshot.position
        assert snapshot.clearance_m == grid.clearance_m((north, east)) > 0.2


def test_a_folder_that_grows_is_read_as_one_that_is_whole(
    whole: Follower, surveillance_run: Path, tmp_path: Path
) -> None:
    names = ("events.jsonl", "flight.tlog")
    data = {name: (surveillance_run / name).read_bytes() for name in names}
    (tmp_path / "scene.json").write_bytes((surveillance_run / "scene.json").read_bytes())
    run, chance = Follower(tmp_path, is_live=True), random.Random(5)
    sizes = dict.fromkeys(names, 0)
    while any(sizes[name] < len(data[name]) for name in names):
        for name in names:
            sizes[name] += chance.randrange(len(data[name]) // 20)
            (tmp_path / name).write_bytes(data[name][: sizes[name]])
        run.read()
    run.read()
    assert run.snapshots == whole.snapshots
    for kind in {type(stamped.event) for stamped in whole.events} - {RoutePlanned}:
        assert of(run, kind) == of(whole, kind), kind  # a way begins at the vehicle


def test_events_wait_for_the_frames_of_their_time_but_not_for_long(
    whole: Follower, surveillance_run: Path, tmp_path: Path
) -> None:
    for name in ("scene.json", "events.jsonl"):
        (tmp_path / name).write_bytes((surveillance_run / name).read_bytes())
    alone, late = Follower(tmp_path, is_live=True), Follower(tmp_path, is_live=True)
    alone.read()
    late.read()
    assert alone.events == late.events == []
    alone.read()
    assert of(alone, RunEnded)
    (tmp_path / "flight.tlog").write_bytes((surveillance_run / "flight.tlog").read_bytes())
    while late.read():
        pass
    late.read()
    assert late.events == whole.events


def test_the_way_of_each_plan_leads_from_the_vehicle_through_its_places(
    whole: Follower, surveillance: Mission
) -> None:
    first, second, third = (planned.legs for planned in of(whole, RoutePlanned))
    for legs, names in ((first, "ABCA"), (second, ["r1", "Home"]), (third, ["r2", "Home"])):
        for leg, name in zip(legs, names, strict=True):
            north, east, _ = surveillance.places[name].position
            assert leg[-1] == pytest.approx([east, north], abs=0.01)
        for leg, onward in itertools.pairwise(legs):
            assert leg[-1] == onward[0]
    grid = surveillance.grid
    for legs in (first, second, third):
        for leg in legs:
            assert len(leg) >= 2
            for (e0, n0), (e1, n1) in itertools.pairwise(leg):
                for share in np.linspace(0.0, 1.0, 50):
                    point = (n0 + share * (n1 - n0), e0 + share * (e1 - e0))
                    assert grid.clearance_m(point) > 0.4, "through a wall"


def test_the_automata_stand_as_the_word_says(whole: Follower) -> None:
    (drawn,) = of(whole, AutomataDrawn)
    names = [automaton.conjunct for automaton in drawn.automata]
    assert names == ["search", "search", "search", "upload", "return"]
    moves = of(whole, AutomataMoved)
    assert len(moves) == 1 + len(of(whole, PositionLeft))
    assert all(all(moved.states) for moved in moves), "nothing was violated"
    at_end = moves[-1].states
    rings = [automaton.accepting for automaton in drawn.automata]
    for ring, nodes in zip(rings, at_end, strict=True):
        assert any(ring[node] for node in nodes), "home at rest satisfies the task"


@pytest.mark.long
def test_a_flight_in_degrees_is_seen_from_its_beginning_on(tmp_path: Path) -> None:
    """It begins when the origin was heard, which no autopilot tells twice."""
    simulate(
        load_mission(MISSIONS / "field.yaml"), {"version": 1}, folder=tmp_path / "run", limit_s=1
    )
    run = read_whole(tmp_path / "run")
    assert abs(run.snapshots[0].time_s) < 0.06
    assert of(run, RoutePlanned)[0].legs


def test_the_map_comes_with_its_distance_field(whole: Follower, surveillance: Mission) -> None:
    about, grid = whole.mission["map"], surveillance.grid
    shade = np.frombuffer(base64.b64decode(about["shade"]), dtype=np.uint8)
    shade = shade.reshape(about["rows"], about["cols"])[::-1]
    assert np.array_equal(shade == 0, grid.occupied)
    far = grid.distance_m >= 3.0
    assert np.all(shade[far] == 255) and np.all(shade[~far] < 255)
    assert {place["name"] for place in whole.mission["places"]} == set(surveillance.places)


def test_cells_that_were_seen_are_those_of_the_companions_own_map(tmp_path: Path) -> None:
    mission = load_mission(MISSIONS / "inspection.yaml")
    folder = RunFolder(tmp_path / "run", mission, 1.7e9, lambda stamped: None)
    flight = lockstep(Companion(OnlyRun(mission, folder)), world_of(mission))
    for _ in itertools.islice(flight.ticks(30.0), SEEN_TICKS):
        pass
    folder.close()
    occupied = mission.grid.occupied.copy()
    for changed in of(read_whole(tmp_path / "run"), CellsChanged):
        for row, col, is_occupied in changed.cells:
            assert occupied[row, col] != is_occupied
            occupied[row, col] = is_occupied
    assert flight.companion._run is not None
    assert np.array_equal(occupied, flight.companion._run._surroundings.grid.occupied)
    assert np.any(occupied != mission.grid.occupied)


# -- the scene -------------------------------------------------------------------------------------


def test_the_scene_is_as_documented(surveillance_run: Path, surveillance: Mission) -> None:
    scene = json.loads((surveillance_run / "scene.json").read_text(encoding="utf-8"))
    about = scene["map"]
    bits = zlib.decompress(base64.b64decode(about["occupied"]))
    cells = [byte >> 7 - i & 1 for byte in bits for i in range(8)]
    occupied = np.array(cells[: about["rows"] * about["cols"]]).reshape(about["rows"], -1)
    assert np.array_equal(occupied, surveillance.grid.occupied)
    places = {place["name"]: place for place in scene["places"]}
    assert places["A"]["enu"] == [3, 11, 2] and places["A"]["in_task"]
    assert not places["r3"]["in_task"]
    assert scene["fence"][0] == [-1.5, -1.5]
    assert math.isclose(scene["start_unix_s"], 1_700_000_000.0)


@pytest.mark.parametrize("number", ["NaN", "1e999", "1" + 400 * "0"])
@pytest.mark.parametrize("key", ['"rows": ', '"cell_m": ', '"start_unix_s": '])
def test_a_scene_with_a_number_that_is_none_is_refused(
    surveillance_run: Path, tmp_path: Path, key: str, number: str
) -> None:
    scene = (surveillance_run / "scene.json").read_text(encoding="utf-8")
    (tmp_path / "scene.json").write_text(scene.replace(key, f'{key}{number}, "before": '))
    with pytest.raises(MissionError, match=r"scene\.json: "):
        read_scene(tmp_path)


def test_a_scene_that_was_written_before_zones_and_low_walls_is_read(
    surveillance_run: Path, tmp_path: Path
) -> None:
    scene = json.loads((surveillance_run / "scene.json").read_bytes())
    for key in ("keep_out", "low_walls", "speed_limits", "clearance_m", "up_m"):
        del scene[key]
    del scene["map"]["open"]
    (tmp_path / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
    assert read_scene(tmp_path).keep_out == {}
    assert not read_scene(tmp_path).grid.is_open


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: scene.pop("map"),
        lambda scene: scene["map"].update(rows=-1),
        lambda scene: scene["map"].update(rows=10**6, cols=10**6),
        lambda scene: scene["map"].update(rows=161),
        lambda scene: scene["map"].update(occupied="AAAA"),
        lambda scene: scene["map"].update(occupied=3),
        lambda scene: scene["places"][0].update(enu=[1, 2]),
        lambda scene: scene.update(start_unix_s="now"),
        lambda scene: scene.update(fence=[[1]]),
        lambda scene: scene.update(places=7),
        lambda scene: scene.update(keep_out=[1]),
        lambda scene: scene.update(low_walls=[1]),
        lambda scene: scene.update(speed_limits=7),
        lambda scene: scene.update(up_m=[1]),
    ],
)
def test_a_damaged_scene_is_refused(surveillance_run: Path, tmp_path: Path, change: Any) -> None:
    scene = json.loads((surveillance_run / "scene.json").read_bytes())
    change(scene)
    (tmp_path / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
    with pytest.raises(MissionError, match=r"scene\.json"):
        Follower(tmp_path, is_live=False)


UNDOCUMENTED: list[dict[str, Any]] = [
    {"type": "WrittenTreeAdopted", "number": 0, "task": {"it": "G ("}, "priorities": {}},
    {"type": "PlanMade"},
    {"type": "PositionLeft", "facts": 3, "restarted": []},
    {"type": "SymbolMoved", "place": "nowhere", "position": [0, 0, 0], "source": "a test"},
    {"type": "SymbolMoved", "place": "A", "position": ["x", 0, 0], "source": "a test"},
    {"type": "TreeBuilt", "nodes": [7]},
    {"type": "FenceKept", "fence": "2", "within": [[[0, 0], [1, 0]], []], "keep_out": [[]]},
]


def test_lines_that_are_not_as_documented_stop_nothing(
    surveillance_run: Path, tmp_path: Path
) -> None:
    for name in ("scene.json", "flight.tlog"):
        (tmp_path / name).write_bytes((surveillance_run / name).read_bytes())
    first, rest = (surveillance_run / "events.jsonl").read_text(encoding="utf-8").split("\n", 1)
    damaged = [json.dumps({"t_s": 0.05, "kind": "", "text": "", **line}) for line in UNDOCUMENTED]
    (tmp_path / "events.jsonl").write_text("\n".join([first, *damaged, rest]), encoding="utf-8")
    run = read_whole(tmp_path)
    assert of(run, RunEnded)


def test_ways_keep_to_a_fence_of_the_autopilots_own(surveillance_run: Path, tmp_path: Path) -> None:
    """As the flight's own routes do: the zone lies on the way from Home to A."""
    for name in ("scene.json", "flight.tlog"):
        (tmp_path / name).write_bytes((surveillance_run / name).read_bytes())
    whole = read_whole(surveillance_run)
    (first, *_), *_ = of(whole, RoutePlanned)[0].legs
    (east, north), *_ = [leg[-1] for leg in of(whole, RoutePlanned)[0].legs]
    middle = ((first[1] + north) / 2, (first[0] + east) / 2)
    corners = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    zone = tuple((middle[0] + n, middle[1] + e) for n, e in corners)
    kept = line_of(Stamped(0.0, FenceKept("4 points, 1 area", keep_out=(zone,))))
    events = (surveillance_run / "events.jsonl").read_text(encoding="utf-8")
    (tmp_path / "events.jsonl").write_text(f"{json.dumps(kept)}\n{events}", encoding="utf-8")
    ways = of(read_whole(tmp_path), RoutePlanned)
    before = of(whole, RoutePlanned)[0].legs[0]
    assert len(ways[0].legs) == len(of(whole, RoutePlanned)[0].legs)
    assert len(ways[0].legs[0]) > len(before), "it leads round the zone"
