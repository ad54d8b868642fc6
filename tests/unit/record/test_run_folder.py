"""What a run leaves behind, read back by others: json, pymavlink and Pillow."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from threading import Thread

import pytest
from autopilot import Autopilot
from patience import comes_true
from PIL import Image
from pymavlink import mavutil
from synthetic import mission

from companion.flight_events.event import Stamped
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.hosting import RecordingFailed
from companion.flight_events.plans import (
    NoPlanFound,
    PlanMade,
    PlannedAction,
    PlannedLasso,
    PlanReplaced,
    TaskRecalled,
)
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import Phase, PhaseEntered, RunFailed, StoppedAsAsked
from companion.flight_events.word import PositionLeft
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.monitor.tailing import TlogFrames
from companion.record import run_folder
from companion.record.backdrop import backdrop_of
from companion.record.drawing import draw_here, draw_in_child
from companion.record.events import read_events
from companion.record.figure import draw_flight
from companion.record.run_folder import RunFolder
from companion.record.trail import PARTS_MAX, POSITIONS_MAX, Trail

START_UNIX_S = 1_700_000_000.0
REST = PlannedLasso((), (PlannedAction("wait", "wait", (), 1.0),), 0.0, 1.0)
"""As a plan, and as it is written."""
REST_AS_JSON = {
    "prefix": [],
    "loop": [{"action": "wait", "skill": "wait", "arguments": [], "cost_s": 1.0}],
    "prefix_cost_s": 0.0,
    "lap_cost_s": 1.0,
}


@pytest.fixture
def told() -> list[Stamped]:
    return []


@pytest.fixture
def run(tmp_path: Path, told: list[Stamped]) -> Iterator[RunFolder]:
    folder = RunFolder(tmp_path / "runs" / "one", mission("F at(A)"), START_UNIX_S, told.append)
    yield folder
    folder.close()


def lines(run: RunFolder) -> list[dict[str, object]]:
    text = (run.folder / "events.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


def has_lines(run: RunFolder, number: int) -> bool:
    return len(lines(run)) == number


def value(number: int) -> bytes:
    message = dialect.MAVLink_named_value_int_message(number, b"target", number)
    return MavlinkCodec(1, 26).pack(message)


def test_the_mission_is_kept_as_it_was_written(run: RunFolder) -> None:
    assert (run.folder / "mission.yaml").read_text(encoding="utf-8") == "name: synthetic\n"


def test_each_report_is_a_line_at_once(run: RunFolder, told: list[Stamped]) -> None:
    reports = [
        Stamped(0.05, PhaseEntered(Phase.ARMING)),
        Stamped(1.25, MissionEventChanged("lowBattery", holds=True)),
        Stamped(2.0, PlaceReached("Böschung “é”", "move(H, A)")),
    ]
    for number, report in enumerate(reports, start=1):
        run.report(report)
        assert comes_true(partial(has_lines, run, number))
    assert lines(run) == [
        {
            "t_s": 0.05,
            "type": "PhaseEntered",
            "kind": "phase",
            "text": "arming",
            "phase": "arming",
        },
        {
            "t_s": 1.25,
            "type": "MissionEventChanged",
            "kind": "event",
            "text": "low battery",
            "event": "lowBattery",
            "holds": True,
        },
        {
            "t_s": 2.0,
            "type": "PlaceReached",
            "kind": "at",
            "text": "at Böschung “é”",
            "place": "Böschung “é”",
            "action": "move(H, A)",
        },
    ]
    assert told == reports


def test_a_text_of_many_lines_is_one_line_of_the_file(run: RunFolder) -> None:
    run.report(Stamped(0.0, RunFailed("no plan: task\n  task: F at(A)", exit_code=3)))
    run.close()
    (line,) = lines(run)
    assert line["text"] == "no plan: task\n  task: F at(A)"


def test_each_plan_is_a_file_by_its_number(run: RunFolder) -> None:
    task = {"visit": "F at(A)", "look": "F at(B)"}
    run.report(Stamped(0.0, PlanMade(task, REST, {"look": 2}, ("look",))))
    run.report(Stamped(9.0, PlanReplaced(1, "target found", REST)))
    run.close()
    about: list[dict[str, object]] = [
        {"number": 0, "task": task, "priorities": {"look": 2}, "dropped": ["look"]},
        {"number": 1, "reason": "target found", "dropped": []},
    ]
    for number, known in enumerate(about):
        text = (run.folder / f"plan-{number}.json").read_text(encoding="utf-8")
        assert json.loads(text) == known | {"plan": REST_AS_JSON}


def test_a_replan_without_a_plan_leaves_no_file(run: RunFolder) -> None:
    run.report(Stamped(0.0, NoPlanFound(1, "denied", "no plan")))
    run.close()
    assert list(run.folder.glob("plan-*.json")) == []
    assert len(lines(run)) == 1


def test_equal_runs_give_equal_events(tmp_path: Path) -> None:
    """The wall clock stamps flight.tlog alone."""
    contents = []
    for name, start_s in (("a", 1.7e9), ("b", 1.8e9)):
        folder = RunFolder(tmp_path / name, mission("F at(A)"), start_s, lambda report: None)
        folder.report(Stamped(0.0, PlanMade({}, REST)))
        folder.report(Stamped(1.0, StoppedAsAsked()))
        folder.close()
        contents.append((tmp_path / name / "events.jsonl").read_bytes())
    assert contents[0] == contents[1]


def test_pymavlink_reads_the_frames_back_in_order_with_their_times(run: RunFolder) -> None:
    stray = b"\xfd\xff\x00"
    run.packets(0.0, [value(1) + value(2), b"junk", value(3)])
    run.packets(0.05, [])
    run.packets(2.5, [value(4), stray])
    run.packets(2.55, [value(5)])
    run.close()
    log = mavutil.mavlink_connection(str(run.folder / "flight.tlog"))
    read = []
    while (message := log.recv_match(type="NAMED_VALUE_INT")) is not None:
        read.append((message.value, round(message._timestamp - START_UNIX_S, 3)))
    log.close()
    assert read == [(1, 0.0), (2, 0.0), (3, 0.0), (4, 2.5), (5, 2.55)]


def test_a_signing_key_is_not_recorded(run: RunFolder) -> None:
    setup = dialect.MAVLink_setup_signing_message(1, 1, [7] * 32, 0)
    run.packets(0.0, [value(1), MavlinkCodec(255, 190).pack(setup) + value(2)])
    run.close()
    recorded = (run.folder / "flight.tlog").read_bytes()
    assert bytes([7] * 32) not in recorded and value(1) in recorded and value(2) in recorded


def size_of(path: Path) -> tuple[int, int]:
    with Image.open(path) as image:
        assert image.format == "PNG"
        image.load()
        return image.size


@pytest.mark.long
@pytest.mark.usefixtures("drawn")
def test_the_flight_is_drawn_with_a_panel_for_each_plan(run: RunFolder) -> None:
    for number in range(3):
        event = PlanReplaced(number, "denied", REST) if number else PlanMade({}, REST)
        run.report(Stamped(0.0, event))
        for step in range(20):
            run.position(0.0, (0.3 * step, 1.0 * number, -2.0))
    run.close()
    width, height = size_of(run.folder / "flight.png")
    assert 1000 < width < 2500
    assert 300 < height < 700


@pytest.mark.usefixtures("drawn")
def test_a_run_without_a_plan_is_drawn_as_well(run: RunFolder) -> None:
    run.position(0.0, (0.0, 0.0, 0.0))
    run.close()
    width, height = size_of(run.folder / "flight.png")
    assert 400 < width < 1000 and 300 < height < 700


def test_the_trail_has_a_part_for_each_plan() -> None:
    trail = Trail()
    trail.add((9.0, 9.0, 9.0))  # before the first plan there is nothing to show
    trail.begin("first plan")
    trail.add((0.0, 0.0, -2.0))
    trail.begin("replan 1: denied")
    trail.begin("replan 2: denied")
    trail.add((1.0, 0.0, -2.0))
    assert trail.parts == [
        ("first plan", [(0.0, 0.0, -2.0)]),
        ("replan 1: denied", []),
        ("replan 2: denied", [(1.0, 0.0, -2.0)]),
    ]


def test_the_trail_of_a_long_flight_stays_small_and_whole(tmp_path: Path) -> None:
    """Hours with a new plan every minute: from the first position to the newest, evenly."""
    trail = Trail()
    for plan in range(500):
        trail.begin(f"replan {plan}")
        for i in range(POSITIONS_MAX // 4):
            trail.add((float(plan), float(i), -2.0))
    sizes = [len(positions) for _, positions in trail.parts]
    assert len(sizes) == PARTS_MAX
    assert max(sizes) <= POSITIONS_MAX
    title, last = trail.parts[-1]
    assert title == f"replan {PARTS_MAX - 1} and all later plans"
    assert last[0] == (PARTS_MAX - 1.0, 0.0, -2.0)
    assert last[-1][0] == 499.0
    draw_flight(backdrop_of(mission("F at(A)")), trail, tmp_path / "flight.png")
    assert max(size_of(tmp_path / "flight.png")) < 4000


@pytest.mark.parametrize("times", [1, 2, 10])
def test_a_long_part_keeps_every_so_many_positions(times: int) -> None:
    trail = Trail()
    trail.begin("first plan")
    for i in range(times * POSITIONS_MAX):
        trail.add((float(i), 0.0, -2.0))
    north = [position[0] for position in trail.parts[0][1]]
    assert POSITIONS_MAX / 2 <= len(north) <= POSITIONS_MAX
    (step,) = {b - a for a, b in pairwise(north)}
    assert north[0] == 0.0
    assert north[-1] > times * POSITIONS_MAX - 1 - step


def test_what_was_flown_can_be_seen(tmp_path: Path) -> None:
    """Two flights to opposite corners give two pictures, and the same flight the same one."""
    pictures = []
    for goal in ((6.0, 0.0), (0.0, 6.0), (6.0, 0.0)):
        trail = Trail()
        trail.begin("first plan")
        for share in (0.0, 0.5, 1.0):
            trail.add((goal[0] * share, goal[1] * share, -2.0))
        draw_flight(backdrop_of(mission("F at(A)")), trail, tmp_path / "flight.png")
        with Image.open(tmp_path / "flight.png") as image:
            pictures.append(image.convert("RGB").tobytes())
    assert pictures[0] != pictures[1]
    assert pictures[0] == pictures[2]


def test_a_full_disk_ends_no_flight(tmp_path: Path) -> None:
    (tmp_path / "flight.tlog").symlink_to("/dev/full")
    told: list[Stamped] = []
    folder = RunFolder(tmp_path, mission("F at(A)"), 0.0, told.append)
    for i in range(100):
        folder.packets(0.05 * i, Autopilot().telemetry() * 20)
    folder.report(Stamped(1.0, PlaceReached("A", "move(H, A)")))
    folder.close()
    assert Stamped(0.0, RecordingFailed("No space left on device")) in told
    assert len(told) == 2
    assert (tmp_path / "events.jsonl").read_text().count("\n") == 1


@pytest.fixture
def still(tmp_path: Path) -> Iterator[int]:
    """A tlog that takes no more than a pipe does until somebody reads it: the file of its end."""
    os.mkfifo(tmp_path / "flight.tlog")
    end = os.open(tmp_path / "flight.tlog", os.O_RDONLY | os.O_NONBLOCK)
    yield end
    os.close(end)


def recorded_on(folder: RunFolder, end: int) -> bytes:
    """Reads what comes until the folder is closed."""
    os.set_blocking(end, True)
    closing = Thread(target=folder.close)
    closing.start()
    data = b"".join(iter(lambda: os.read(end, 1 << 16), b""))
    closing.join()
    return data


def test_a_disk_that_stands_still_stops_nobody(tmp_path: Path, still: int) -> None:
    """What waits for it is written when it goes on."""
    folder = RunFolder(tmp_path, mission("F at(A)"), 0.0, lambda stamped: None)
    for number in range(10_000):
        folder.packets(0.05 * number, [value(number)])
    folder.report(Stamped(500.0, PlaceReached("A", "move(H, A)")))
    record_bytes = 8 + len(value(0))
    assert 1 << 16 < 10_000 * record_bytes == len(recorded_on(folder, still))
    assert len(lines(folder)) == 1


def test_packets_that_no_disk_takes_do_not_fill_the_memory(
    tmp_path: Path, still: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_folder, "MOST_WAITING_BYTES", 200_000)
    told: list[Stamped] = []
    folder = RunFolder(tmp_path, mission("F at(A)"), 0.0, told.append)
    for number in range(10_000):
        folder.packets(0.05 * number, [value(number)])
    folder.report(Stamped(500.0, PlaceReached("A", "move(H, A)")))
    assert [stamped.event.text for stamped in told] == [
        "the run folder cannot be written; the flight continues: the disk takes nothing any more",
        "at A",
    ]
    record_bytes = 8 + len(value(0))
    whole, torn = divmod(len(recorded_on(folder, still)), record_bytes)
    assert 200_000 <= whole * record_bytes < 10_000 * record_bytes and torn == 0
    assert len(lines(folder)) == 1


def test_positions_are_kept_and_not_told(run: RunFolder, told: list[Stamped]) -> None:
    run.report(Stamped(1.0, PositionLeft(0, ("at(H)",), (), 0.0, (), (), for_ever=False)))
    run.close()
    assert told == []
    (line,) = lines(run)
    assert (line["kind"], line["number"], line["facts"]) == ("position", 0, ["at(H)"])


def position(number: int) -> PositionLeft:
    return PositionLeft(number, ("at(A)",), (), 0.0, (), (), for_ever=False)


TORN = '{"t_s": 1.2, "ki'


@pytest.mark.parametrize(
    ("recorded", "torn"),
    [
        (1, ""),
        (2, TORN),
        *(pytest.param(*each, marks=pytest.mark.long) for each in [(1, TORN), (2, "")]),
        (3, ""),
        pytest.param(3, TORN, marks=pytest.mark.long),
    ],
)
def test_a_run_that_was_cut_off_is_gone_on_with(
    run: RunFolder, told: list[Stamped], recorded: int, torn: str
) -> None:
    """Record and journal do not end at the same moment: the journal says what was."""
    run.report(Stamped(0.0, PlanMade({"task": "F at(A)"}, REST)))
    for number in range(recorded):
        run.report(Stamped(1.0 + number, position(number)))
    run.close()
    with (run.folder / "events.jsonl").open("a", encoding="utf-8") as file:
        file.write(torn)
    scene = (run.folder / "scene.json").read_bytes()
    again = RunFolder(run.folder, mission("F at(A)"), START_UNIX_S, told.append, False, 2)
    for number in range(2):  # as the journal has them
        again.report(Stamped(9.0, position(number)))
    again.report(Stamped(9.5, position(2)))
    again.close()
    assert [line.get("number") for line in lines(again)] == [0, 0, 1, 2]
    assert (run.folder / "scene.json").read_bytes() == scene


NOTHING = b""
ZEROS = bytes(4096)


@pytest.mark.parametrize("left", [None, NOTHING, ZEROS])
def test_what_a_power_failure_took_is_written_again(
    run: RunFolder, told: list[Stamped], left: bytes | None
) -> None:
    """The journal alone was on the disk: task and word come from it, the rest from the mission."""
    run.report(Stamped(0.0, PlanMade({"task": "F at(A)"}, REST)))
    run.report(Stamped(1.0, position(0)))
    run.close()
    written = {name: (run.folder / name).read_bytes() for name in ("mission.yaml", "scene.json")}
    for name in (*written, "events.jsonl"):
        (run.folder / name).unlink()
        if left is not None:
            (run.folder / name).write_bytes(left)
    again = RunFolder(run.folder, mission("F at(A)"), START_UNIX_S, told.append, False, 1)
    again.report(Stamped(0.0, TaskRecalled({"task": "F at(A)"})))
    again.report(Stamped(1.0, position(0)))
    again.close()
    record = read_events(run.folder)
    assert record.is_headless and list(record.task) == ["task"] and len(record.positions) == 1
    assert {name: (run.folder / name).read_bytes() for name in written} == written


def test_a_task_that_is_in_the_record_is_not_recalled(run: RunFolder, told: list[Stamped]) -> None:
    run.report(Stamped(0.0, PlanMade({"task": "F at(A)"}, REST)))
    run.close()
    again = RunFolder(run.folder, mission("F at(A)"), START_UNIX_S, told.append, False, 0)
    again.report(Stamped(0.0, TaskRecalled({"task": "F at(A)"})))
    again.close()
    assert [line["kind"] for line in lines(again)] == ["plan"]
    assert not read_events(run.folder).is_headless


def test_a_line_without_its_end_is_written_again(run: RunFolder, told: list[Stamped]) -> None:
    run.report(Stamped(0.0, PlanMade({"task": "F at(A)"}, REST)))
    run.report(Stamped(1.0, position(0)))
    run.close()
    path = run.folder / "events.jsonl"
    os.truncate(path, path.stat().st_size - 1)
    again = RunFolder(run.folder, mission("F at(A)"), START_UNIX_S, told.append, False, 1)
    for number in range(2):
        again.report(Stamped(1.0 + number, position(number)))
    again.close()
    assert [line.get("number") for line in lines(again)] == [0, 0, 1]


@pytest.mark.parametrize("torn", [0, 1, 7, 12])
def test_frames_behind_a_torn_one_are_read(run: RunFolder, told: list[Stamped], torn: int) -> None:
    path = run.folder / "flight.tlog"
    for number in range(5):
        run.packets(float(number), [value(number)])
    run.close()
    size = path.stat().st_size
    os.truncate(path, size - torn)
    again = RunFolder(run.folder, mission("F at(A)"), START_UNIX_S, told.append, False, 0)
    for number in range(5, 8):
        again.packets(float(number), [value(number)])
    again.close()
    batches, _ = TlogFrames(path).news()
    times_s = [time_s - START_UNIX_S for time_s, _ in batches]
    whole = [0.0, 1.0, 2.0, 3.0] if torn else [0.0, 1.0, 2.0, 3.0, 4.0]
    assert times_s == [*whole, 5.0, 6.0]  # the newest waits for a later one


@pytest.mark.usefixtures("drawn")
def test_a_child_draws_the_same(tmp_path: Path) -> None:
    trail = Trail()
    trail.begin("first plan")
    trail.add((1.0, 2.0, -2.0))
    draw_here(mission("F at(A)"), trail, tmp_path / "here.png")
    draw_in_child(mission("F at(A)"), trail, tmp_path / "child.png")
    here, child = (Image.open(tmp_path / name).tobytes() for name in ("here.png", "child.png"))
    assert here == child
    with pytest.raises(OSError, match="cannot be drawn"):
        draw_in_child(mission("F at(A)"), trail, tmp_path / "nowhere" / "flight.png")
