"""Which fences are ours is remembered from program to program; what is damaged is nothing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from companion.mavlink.item_transfer import StoredItem
from companion.record.flight_memory_files import flight_memory_in
from companion.record.own_upload_file import OWN_FENCES, OWN_RALLY_POINTS
from companion.vehicle.own_uploads import MOST_UPLOADS, OwnItems

POINTS = (StoredItem(5100, 3, 0.0, 473977000, 85455000, 1.5), StoredItem(5100, 3, 0.0, 0, 1))
SQUARE = tuple(StoredItem(5001, 0, 4.0, 473977000 + i, 85455000 - i) for i in range(4))


def fences_in(folder: Path) -> OwnItems:
    return flight_memory_in(folder).fences


def test_rally_points_are_remembered_beside_fences(tmp_path: Path) -> None:
    own = flight_memory_in(tmp_path)
    own.fences.note(SQUARE)
    own.rally_points.note(POINTS)
    own.rally_points.note(())
    again = flight_memory_in(tmp_path)
    assert (again.fences.written, again.rally_points.written) == ((SQUARE,), (POINTS,))
    assert (tmp_path / OWN_RALLY_POINTS).exists()


def test_a_file_of_before_has_no_frames_and_no_altitudes(tmp_path: Path) -> None:
    rows = [[(item.command, item.first, item.x, item.y) for item in SQUARE]]
    (tmp_path / OWN_FENCES).write_text(json.dumps(rows), encoding="utf-8")
    assert fences_in(tmp_path).written == (SQUARE,)


def test_what_was_written_is_remembered(tmp_path: Path) -> None:
    folder = tmp_path / "runs"
    assert fences_in(folder).written == ()
    fences_in(folder).note(SQUARE)
    again = fences_in(folder)
    assert again.written == (SQUARE,)
    assert again.in_force is None, "that is known of one program alone"
    again.note(SQUARE[::-1])
    again.note(SQUARE)
    assert fences_in(folder).written == (SQUARE[::-1], SQUARE)


def test_the_newest_are_remembered(tmp_path: Path) -> None:
    own = fences_in(tmp_path)
    for i in range(MOST_UPLOADS + 3):
        own.note((StoredItem(5003, 0, float(i + 1), 0, 0),))
    kept = fences_in(tmp_path).written
    assert len(kept) == MOST_UPLOADS
    assert kept[-1][0].first == MOST_UPLOADS + 3


@pytest.mark.parametrize(
    "content",
    [
        "",
        "{",
        "5",
        '["a"]',
        "[[[1, 2]]]",
        '[[["x", 1, 2, 3]]]',
        "[[[5001, 4, 1e999, 3]]]",
        "[" * 9999,
    ],
)
def test_a_file_that_is_damaged_is_as_if_it_were_not_there(content: str, tmp_path: Path) -> None:
    (tmp_path / OWN_FENCES).write_text(content, encoding="utf-8")
    own = fences_in(tmp_path)
    assert own.written == ()
    own.note(SQUARE)
    assert fences_in(tmp_path).written == (SQUARE,)


def test_where_nothing_can_be_written_the_flight_goes_on(tmp_path: Path) -> None:
    (tmp_path / "runs").write_text("no folder", encoding="utf-8")
    own = fences_in(tmp_path / "runs")
    own.note(SQUARE)
    assert own.written == (SQUARE,)
