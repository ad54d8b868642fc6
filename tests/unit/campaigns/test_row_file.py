"""What a campaign keeps on disk: nothing torn, nothing of another campaign."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from varied import SEED, ThisProcess, short_kit

from companion.campaigns.campaign import Campaign
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.row_file import NAME, NotWritten, RowFile, header_in
from companion.campaigns.rows import Row, random_row
from companion.campaigns.table import write_whole
from companion.errors import CompanionError, MissionError

HEADER = {"format": "1", "seed": "3"}


def flown(index: int) -> FlownRow:
    return FlownRow(Row(index, 7, {"a": 1.5}), RowOutcome.SATISFIED, track=((0.0, 1.0),))


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """No file of this process grows beyond so many bytes: as a full disk, for any user."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_rows_are_there_again(tmp_path: Path) -> None:
    file = RowFile(tmp_path, HEADER)
    file.add(flown(2))
    file.add(flown(0))
    file.close()
    again = RowFile(tmp_path, HEADER)
    assert again.rows == {2: flown(2), 0: flown(0)}
    again.close()
    assert header_in(tmp_path, "seed") == HEADER


def test_a_torn_line_is_dropped(tmp_path: Path) -> None:
    file = RowFile(tmp_path, HEADER)
    file.add(flown(0))
    file.add(flown(1))
    file.close()
    path = tmp_path / NAME
    path.write_bytes(path.read_bytes()[:-20])
    again = RowFile(tmp_path, HEADER)
    assert [*again.rows] == [0]
    again.add(flown(1))
    again.close()
    last = RowFile(tmp_path, HEADER)
    assert [*last.rows] == [0, 1]
    last.close()


@pytest.mark.parametrize("damage", [b"\0\0\n", b"[1]\n", b'{"index": \n'])
def test_a_damaged_line_before_the_last_is_refused_and_nothing_is_lost(
    tmp_path: Path, damage: bytes
) -> None:
    with closing(RowFile(tmp_path, HEADER)) as file:
        for index in range(3):
            file.add(flown(index))
    path = tmp_path / NAME
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:2], damage, lines[3]]))
    with pytest.raises(MissionError, match=r"rows\.jsonl:3 is damaged"):
        RowFile(tmp_path, HEADER)
    assert path.read_bytes().endswith(lines[3])
    path.write_bytes(b"".join([*lines[:2], lines[3]]))
    with closing(RowFile(tmp_path, HEADER)) as again:
        assert [*again.rows] == [0, 2]


def test_another_campaign_is_refused_with_what_differs(tmp_path: Path) -> None:
    RowFile(tmp_path, HEADER).close()
    with pytest.raises(MissionError, match="its seed is 3, and is 4 now"):
        RowFile(tmp_path, {**HEADER, "seed": "4"})


def test_of_other_code_it_is_told_whatever_else_that_makes_different(tmp_path: Path) -> None:
    RowFile(tmp_path, {**HEADER, "code": "one"}).close()
    with pytest.raises(MissionError, match="its code is one, and is two now"):
        RowFile(tmp_path, {**HEADER, "seed": "4", "code": "two"})


def test_a_campaign_that_is_under_way_is_left_alone(tmp_path: Path) -> None:
    file = RowFile(tmp_path, HEADER)
    with pytest.raises(CompanionError, match="another campaign is writing"):
        RowFile(tmp_path, HEADER)
    file.close()


def test_a_folder_without_a_campaign_cannot_be_resumed(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="holds no campaign"):
        header_in(tmp_path, "runs")


def test_a_search_is_not_resumed_as_a_campaign(tmp_path: Path) -> None:
    RowFile(tmp_path, HEADER).close()
    with pytest.raises(MissionError, match="has no runs"):
        header_in(tmp_path, "runs")


def test_a_row_that_the_disk_has_no_room_for_costs_no_other(tmp_path: Path) -> None:
    file = RowFile(tmp_path, HEADER)
    file.add(flown(0))
    size = (tmp_path / NAME).stat().st_size
    told = r"rows.jsonl cannot be written: File too large"
    with room_for(size + 20), pytest.raises(NotWritten, match=told):
        file.add(flown(1))
    assert [*file.rows] == [0] and (tmp_path / NAME).stat().st_size == size + 20
    file.close()
    again = RowFile(tmp_path, HEADER)
    again.add(flown(1))
    again.close()
    assert len((tmp_path / NAME).read_bytes().splitlines()) == 3


def test_a_table_that_the_disk_has_no_room_for_leaves_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    write_whole(path, "before")
    with room_for(10), pytest.raises(NotWritten, match=r"table\.csv cannot be written"):
        write_whole(path, "a longer table")
    assert [*tmp_path.iterdir()] == [path] and path.read_text() == "before"


def test_rows_of_another_release_are_another_campaign(tmp_path: Path) -> None:
    """Their fields are other ones, and nothing is lost of them."""
    path = tmp_path / NAME
    path.write_text('{"format": "0", "seed": "3"}\n{"row": {"index": 0}, "ended": "well"}\n')
    before = path.read_bytes()
    with pytest.raises(MissionError, match="holds another campaign: its format is 0"):
        RowFile(tmp_path, HEADER)
    path.write_text(before.decode().replace('"0"', '"1"', 1))
    with pytest.raises(MissionError, match="not a row of a campaign"):
        RowFile(tmp_path, HEADER)
    assert path.read_bytes() == before.replace(b'"0"', b'"1"', 1)


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "worst").write_text("a file")
    with pytest.raises(NotWritten, match=r"worst/0\.sim\.yaml cannot be written"):
        write_whole(tmp_path / "worst" / "0.sim.yaml", "text")


def test_a_row_that_was_edited_is_none_of_the_campaign(tmp_path: Path) -> None:
    kit = short_kit()
    row = random_row(kit.factors, SEED, 0)
    file = RowFile(tmp_path, HEADER)
    file.add(FlownRow(replace(row, values={}), RowOutcome.SATISFIED))
    file.close()
    campaign = Campaign(kit, ThisProcess(kit), tmp_path, HEADER, lambda flown: None)
    with closing(campaign), pytest.raises(MissionError, match=r"row 0 of .* was edited"):
        campaign.flown([row])
