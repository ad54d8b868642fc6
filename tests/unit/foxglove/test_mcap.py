"""A run as an MCAP file, read back by the library, and each message held against its schema."""

from __future__ import annotations

import io
import json
import math
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from mcap.reader import make_reader

from companion.api.drawings import home_of_run
from companion.flight_events.fence import FenceKept
from companion.foxglove.mcap_file import write_mcap
from companion.foxglove.messages import LogMessage, heading, pose_in_map, stamp
from companion.foxglove.recording import RecordedRun
from companion.foxglove.scenery import PRIMITIVES, blocks, entity, kept, world
from companion.foxglove.schemas import SCHEMAS
from companion.geometry import NorthEast
from companion.monitor.follower import Follower
from companion.monitor.scene import read_scene
from companion.record.events import read_events

START_NS = 1_700_000_000 * 10**9
"""Of `surveillance_run`."""


class Read:
    """What a reader finds in a file: messages by topic, schemas by topic, attachments by name."""

    def __init__(self, data: bytes) -> None:
        reader = make_reader(io.BytesIO(data))
        self.messages: dict[str, list[tuple[int, Any]]] = defaultdict(list)
        self.schemas: dict[str, Any] = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None and schema.encoding == "jsonschema"
            assert channel.message_encoding == "json"
            self.schemas[channel.topic] = (schema.name, json.loads(schema.data))
            self.messages[channel.topic].append((message.log_time, json.loads(message.data)))
        self.attachments = {a.name: a.data for a in reader.iter_attachments()}


@pytest.fixture(scope="module")
def read(surveillance_run: Path) -> Read:
    stream = io.BytesIO()
    told: list[Any] = []
    zero = home_of_run(surveillance_run)
    run = RecordedRun(surveillance_run, zero, '{"type": "FeatureCollection"}', told.append)
    count = write_mcap(stream, run.start_unix_ns, run.messages(), {"clocks.json": b"{}"})
    found = Read(stream.getvalue())
    assert count == sum(map(len, found.messages.values()))
    return found


def test_each_message_is_as_its_schema_says(read: Read) -> None:
    assert {name for name, _ in read.schemas.values()} == set(SCHEMAS)
    for topic, messages in read.messages.items():
        name, schema = read.schemas[topic]
        assert schema == SCHEMAS[name]
        jsonschema.Draft202012Validator.check_schema(schema)
        validator = jsonschema.Draft202012Validator(schema)
        for _, message in messages:
            validator.validate(message)
            assert set(message) == set(schema["properties"])


def test_a_message_that_lacks_a_field_would_be_found() -> None:
    """The schemas demand something."""
    for name, schema in SCHEMAS.items():
        validator = jsonschema.Draft202012Validator(schema)
        assert not validator.is_valid({}), name
    pose = {"timestamp": {"sec": 1, "nsec": 0}, **pose_in_map((1.0, 2.0, -3.0))}
    jsonschema.validate(pose, SCHEMAS["foxglove.PoseInFrame"])
    del pose["pose"]["orientation"]["w"]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(pose, SCHEMAS["foxglove.PoseInFrame"])


def test_times_are_those_of_the_flight(read: Read) -> None:
    """Of the file and of the messages, from the first to the last second."""
    for _, message in read.messages["/vehicle/pose"][::50]:
        assert message["timestamp"]["sec"] >= START_NS // 10**9
    for topic, messages in read.messages.items():
        times = [time_ns for time_ns, _ in messages]
        assert times == sorted(times), topic
        assert times[0] >= START_NS
        for time_ns, message in messages:
            if "timestamp" in message:
                stamp = message["timestamp"]
                assert stamp["sec"] * 10**9 + stamp["nsec"] == time_ns


def test_the_vehicle_is_where_the_run_has_it(read: Read, surveillance_run: Path) -> None:
    run = Follower(surveillance_run, is_live=False)
    while run.read():
        pass
    poses = [message["pose"] for _, message in read.messages["/vehicle/pose"]]
    assert len(poses) == len(run.snapshots) > 200
    for snapshot, pose in zip(run.snapshots, poses, strict=True):
        north, east, down = snapshot.position
        at = pose["position"]
        assert (at["x"], at["y"], at["z"]) == pytest.approx((east, north, -down), abs=1e-3)
        forward = 2 * math.atan2(pose["orientation"]["z"], pose["orientation"]["w"])
        bearing = math.remainder(math.pi / 2 - forward - snapshot.yaw_rad, 2 * math.pi)
        assert bearing == pytest.approx(0.0, abs=1e-4)
    frames = [message for _, message in read.messages["/tf"]]
    assert [f["translation"] for f in frames] == [p["position"] for p in poses]
    assert {(f["parent_frame_id"], f["child_frame_id"]) for f in frames} == {("map", "base_link")}


def test_the_fix_is_where_the_pose_is(read: Read, surveillance_run: Path) -> None:
    zero = home_of_run(surveillance_run)
    assert zero is not None
    for (_, pose), (_, fix) in zip(
        read.messages["/vehicle/pose"], read.messages["/vehicle/location"], strict=True
    ):
        north, east, down = zero.to_local(fix["latitude"], fix["longitude"], fix["altitude"])
        at = pose["pose"]["position"]
        assert (at["x"], at["y"], at["z"]) == pytest.approx((east, north, -down), abs=2e-3)


def test_the_log_tells_what_people_are_told(read: Read, surveillance_run: Path) -> None:
    lines = (surveillance_run / "events.jsonl").read_text(encoding="utf-8").splitlines()
    logs = [message for _, message in read.messages["/log"]]
    assert len(logs) > 20
    for log in logs:
        line = json.loads(lines[log["line"] - 1])
        assert (log["message"], log["name"], log["file"]) == (
            line["text"],
            line["kind"],
            "events.jsonl",
        )
    ending = read_events(surveillance_run).ending
    assert ending is not None and logs[-1]["message"] == ending.text
    failed = [log["level"] for log in logs if log["name"] == "failed"]
    assert failed and set(failed) == {3}


def test_a_new_plan_has_a_new_way(read: Read) -> None:
    plans = [message["poses"] for _, message in read.messages["/plan"]]
    assert len(plans) == 3
    assert all(len(poses) > 1 for poses in plans)
    assert {pose["position"]["z"] for poses in plans for pose in poses} != {0.0}


def test_the_scene_has_all_that_the_mission_names(read: Read, surveillance_run: Path) -> None:
    (_, first), *_ = read.messages["/scene"]
    entities = {each["id"]: each for each in first["entities"]}
    scene = json.loads((surveillance_run / "scene.json").read_text(encoding="utf-8"))
    assert {f"place_{place['name']}" for place in scene["places"]} < set(entities)
    fence = [(p["x"], p["y"]) for p in entities["fence"]["lines"][0]["points"]]
    assert fence == [tuple(corner) for corner in scene["fence"]]
    assert len(entities["walls"]["cubes"]) > 3
    assert len({each["id"] for each in first["entities"]}) == len(first["entities"])


def test_a_fence_that_is_kept_is_in_the_scene(surveillance_run: Path) -> None:
    square = ((0.0, 0.0), (0.0, 9.0), (9.0, 9.0), (9.0, 0.0))
    bed = ((2.0, 2.0), (2.0, 4.0), (4.0, 4.0))
    update = kept(read_scene(surveillance_run), FenceKept("7 points, 2 areas", (square,), (bed,)))
    fence, zone = update["entities"]
    assert [(p["y"], p["x"]) for p in fence["lines"][0]["points"]] == [*square]
    assert [(p["y"], p["x"]) for p in zone["lines"][1]["points"]] == [*bed]
    content = {"deletions": [], "entities": [{"timestamp": stamp(0), **e} for e in (fence, zone)]}
    jsonschema.validate(content, SCHEMAS["foxglove.SceneUpdate"])


def test_blocks_are_the_cells_and_no_others() -> None:
    random = np.random.default_rng(7)
    for _ in range(50):
        cells = random.random((random.integers(1, 12), random.integers(1, 12))) < 0.4
        drawn = np.zeros(cells.shape, dtype=int)
        for block in blocks(cells):
            rows = slice(block.row, block.row + block.rows)
            drawn[rows, block.col : block.col + block.cols] += 1
        assert (drawn == cells).all()


def test_a_run_that_is_nowhere_on_the_earth_has_no_fix(surveillance_run: Path) -> None:
    run = RecordedRun(surveillance_run, None, None, lambda read: None)
    topics = {message.topic for message in run.messages()}
    assert {"/vehicle/location", "/map"}.isdisjoint(topics)
    assert {"/vehicle/pose", "/scene", "/log", "/plan"} <= topics


def test_an_entity_has_every_list_of_primitives() -> None:
    assert set(PRIMITIVES) < set(entity("nothing"))
    message = LogMessage(0.0, "/scene", "foxglove.SceneUpdate", {})
    assert message.schema in SCHEMAS


@pytest.mark.parametrize("yaw_deg", [0, 90, 180, -90, 37])
def test_a_heading_is_clockwise_from_north_and_a_rotation_is_not(yaw_deg: int) -> None:
    q = heading(math.radians(yaw_deg))
    turned = 2 * math.degrees(math.atan2(q["z"], q["w"]))
    assert math.remainder(turned - (90 - yaw_deg), 360) == pytest.approx(0.0, abs=1e-3)


def test_a_zone_has_its_name(surveillance_run: Path) -> None:
    """It stands above the zone's middle, as that of a place above the place."""
    beds: dict[str, tuple[NorthEast, ...]] = {
        "beds": ((4.0, 8.0), (4.0, 12.0), (6.0, 12.0), (6.0, 8.0))
    }
    entities = world(replace(read_scene(surveillance_run), keep_out=beds))["entities"]
    [zone] = (each for each in entities if each["id"] == "keep_out_beds")
    [label] = zone["texts"]
    assert label["text"] == "beds"
    assert (label["pose"]["position"]["x"], label["pose"]["position"]["y"]) == (10.0, 5.0)
