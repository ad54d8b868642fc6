"""The table of a campaign, as other programs read it."""

from __future__ import annotations

import csv
import io
import re

from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row
from companion.campaigns.table import MARK, table_text

QUOTED = re.compile(r'"(?:[^"]|"")*"')
CRATE = "obstacles.crate #1.circle.east_m"


def test_a_sign_of_comments_stands_in_quotes_where_it_is_part_of_a_name() -> None:
    """`comment="#"` of pandas cuts a line at each `#` that does not."""
    reason = 'a "wall", #3\nand more'
    flown = FlownRow(Row(0, 7, {CRATE: 2.5}), RowOutcome.VIOLATED, "upload #2", reason=reason)
    text = table_text({"mission": "hall #1"}, [CRATE], [flown])
    rows = text.removeprefix(f"{MARK}mission: hall #1\n")
    assert "#" not in QUOTED.sub("", rows)
    (read,) = csv.DictReader(io.StringIO(rows))
    assert read[CRATE] == "2.5" and read["conjunct"] == "upload #2" and read["reason"] == reason
