"""What a run leaves behind, read back by others: json, pymavlink and Pillow."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from autopilot import Autopilot
from PIL import Image
from pymavlink import mavutil
from synthetic import mission

from companion.acting.report import Report
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.record.figure import Trail, draw_flight
from companion.record.run_folder import RunFolder

START_UNIX_S = 1_700_000_000.0
PLAN = {"number": 0, "prefix": [], "loop": [{"action": "wait", "cost_s": 1.0}], "lap_cost_s": 1.0}


@pytest.fixture
def told() -> list[Report]:
    return []


@pytest.fixture
def run(tmp_path: Path, told: list[Report]) -> Iterator[RunFolder]:
    folder = RunFolder(tmp_path / "runs" / "one", mission("F at(A)"), START_UNIX_S, told.append)
    yield folder
    folder.close()


def lines(run: RunFolder) -> list[dict[str, object]]:
    text = (run.folder / "events.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


def value(number: int) -> bytes:
    message = dialect.MAVLink_named_value_int_message(number, b"target", number)
    return MavlinkCodec(1, 26).pack(message)


def test_the_mission_is_kept_as_it_was_written(run: RunFolder) -> None:
    assert (run.folder / "mission.yaml").read_text(encoding="utf-8") == "name: synthetic\n"


def test_each_report_is_a_line_at_once(run: RunFolder, told: list[Report]) -> None:
    reports = [
        Report(0.05, "phase", "arming"),
        Report(1.25, "event", "low battery", {"event": "lowBattery", "holds": True}),
        Report(2.0, "at", "at Böschung “é”", {"action": "move(H, A)"}),
    ]
    for number, report in enumerate(reports, start=1):
        run.report(report)
        assert len(lines(run)) == number
    assert lines(run) == [
        {"t_s": 0.05, "kind": "phase", "text": "arming"},
        {
            "t_s": 1.25,
            "kind": "event",
            "text": "low battery",
            "event": "lowBattery",
            "holds": True,
        },
        {"t_s": 2.0, "kind": "at", "text": "at Böschung “é”", "action": "move(H, A)"},
    ]
    assert told == reports


def test_a_text_of_many_lines_is_one_line_of_the_file(run: RunFolder) -> None:
    run.report(Report(0.0, "end", "no plan: task\n  task: F at(A)", {"exit_code": 3}))
    (line,) = lines(run)
    assert line["text"] == "no plan: task\n  task: F at(A)"


def test_each_plan_is_a_file_by_its_number(run: RunFolder) -> None:
    run.report(Report(0.0, "plan", "plan: (wait)^w", PLAN))
    later = {**PLAN, "number": 1, "reason": "target found"}
    run.report(Report(9.0, "replan", "replan 1: target found -> (wait)^w", later))
    for number, plan in enumerate([PLAN, later]):
        text = (run.folder / f"plan-{number}.json").read_text(encoding="utf-8")
        assert json.loads(text) == plan


def test_a_replan_without_a_plan_leaves_no_file(run: RunFolder) -> None:
    run.report(Report(0.0, "replan", "replan 1: denied: no plan", {"reason": "denied"}))
    assert list(run.folder.glob("plan-*.json")) == []
    assert len(lines(run)) == 1


def test_equal_runs_give_equal_events(tmp_path: Path) -> None:
    """The wall clock stamps flight.tlog alone."""
    contents = []
    for name, start_s in (("a", 1.7e9), ("b", 1.8e9)):
        folder = RunFolder(tmp_path / name, mission("F at(A)"), start_s, lambda report: None)
        folder.report(Report(0.0, "plan", "plan: (wait)^w", PLAN))
        folder.report(Report(1.0, "end", "stopped as asked", {"exit_code": 0}))
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


def size_of(path: Path) -> tuple[int, int]:
    with Image.open(path) as image:
        assert image.format == "PNG"
        image.load()
        return image.size


def test_the_flight_is_drawn_with_a_panel_for_each_plan(run: RunFolder) -> None:
    for number in range(3):
        plan = {**PLAN, "number": number, **({"reason": "denied"} if number else {})}
        run.report(Report(0.0, "replan" if number else "plan", "text", plan))
        for step in range(20):
            run.position(0.0, (0.3 * step, 1.0 * number, -2.0))
    run.close()
    width, height = size_of(run.folder / "flight.png")
    assert 1000 < width < 2500
    assert 300 < height < 700


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


def test_what_was_flown_can_be_seen(tmp_path: Path) -> None:
    """Two flights to opposite corners give two pictures, and the same flight the same one."""
    pictures = []
    for goal in ((6.0, 0.0), (0.0, 6.0), (6.0, 0.0)):
        trail = Trail()
        trail.begin("first plan")
        for share in (0.0, 0.5, 1.0):
            trail.add((goal[0] * share, goal[1] * share, -2.0))
        draw_flight(mission("F at(A)"), trail, tmp_path / "flight.png")
        with Image.open(tmp_path / "flight.png") as image:
            pictures.append(image.convert("RGB").tobytes())
    assert pictures[0] != pictures[1]
    assert pictures[0] == pictures[2]


def test_a_full_disk_ends_no_flight(tmp_path: Path) -> None:
    (tmp_path / "flight.tlog").symlink_to("/dev/full")
    told: list[Report] = []
    folder = RunFolder(tmp_path, mission("F at(A)"), 0.0, told.append)
    for i in range(100):
        folder.packets(0.05 * i, Autopilot().telemetry() * 20)
    folder.report(Report(1.0, "at", "at A"))
    folder.close()
    assert [r.kind for r in told] == ["record", "at"]
    assert "No space left" in told[0].text
    assert (tmp_path / "events.jsonl").read_text().count("\n") == 1


def test_positions_are_kept_and_not_told(run: RunFolder, told: list[Report]) -> None:
    run.report(Report(1.0, "position", "position 0: at(H)", {"number": 0, "facts": ["at(H)"]}))
    assert told == []
    (line,) = lines(run)
    assert (line["kind"], line["number"], line["facts"]) == ("position", 0, ["at(H)"])
