"""A campaign in a few lines."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row
from companion.campaigns.summary import SAME, earlier_table, failures_in, why_invalid
from companion.campaigns.table import table_text
from companion.errors import MissionError


@pytest.mark.parametrize(
    ("reasons", "told"),
    [
        (["a wall"], "of no account; a wall"),
        (["a wall", "a crate", "a wall"], "of no account; most: a wall"),
    ],
)
def test_rows_of_no_account_say_why(reasons: list[str], told: str) -> None:
    rows = [
        FlownRow(Row(i, i, {}), RowOutcome.INVALID, reason=why) for i, why in enumerate(reasons)
    ]
    flown = FlownRow(Row(9, 9, {}), RowOutcome.SATISFIED)
    assert why_invalid([flown, *rows]) == told


def test_a_table_is_read_whatever_its_factors_are_called(tmp_path: Path) -> None:
    same = dict.fromkeys(SAME, "1")
    header = {**same, "vary obstacles.crate: #1": "0 to 1", "vary arming": "a: b\n# index (50%)"}
    flown = [FlownRow(Row(0, 0, {"arming": "a: b\n# index"}), RowOutcome.CRASH)]
    table = tmp_path / "table.csv"
    table.write_text(table_text(header, ["arming"], flown))
    assert failures_in(earlier_table(table, header)) == [(0, True)]
    with pytest.raises(MissionError, match="its vary arming is a: b"):
        earlier_table(table, {**header, "vary arming": "b"})
