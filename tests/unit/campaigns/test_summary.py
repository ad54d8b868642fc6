"""A campaign in a few lines."""

from __future__ import annotations

import pytest

from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row
from companion.campaigns.summary import why_invalid


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
