"""What `companion campaign` and `falsify` refuse before their first flight."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import Companion

HEADER = "# format: 1\n# scenario: {scenario}\n# seed: 0\n# limit_s: 1800\nindex,outcome,score\n"


@pytest.mark.parametrize(
    ("earlier", "why"),
    [
        (None, "cannot be read: [Errno 2] No such file or directory"),
        ("index,outcome\n", "is no table of a campaign"),
        (HEADER.format(scenario="another"), "has other rows: its scenario is another, and is "),
    ],
)
def test_a_table_that_cannot_be_compared_is_refused_before_a_flight(
    tmp_path: Path, companion: Companion, earlier: str | None, why: str
) -> None:
    table, folder = tmp_path / "earlier.csv", tmp_path / "flown"
    if earlier is not None:
        table.write_text(earlier, encoding="utf-8")
    ended = companion("campaign", "return_home", "--out", folder, "--against", table)
    assert ended.code == 2
    assert why in ended.err
    assert not folder.exists()


def test_a_search_in_which_nothing_varies_is_refused(tmp_path: Path, companion: Companion) -> None:
    ended = companion("falsify", "return_home", "--out", tmp_path / "flown")
    assert ended.code == 2
    assert ended.err.startswith("there is nothing to search: the scenario has no key vary")
    assert not (tmp_path / "flown").exists()
