"""The report follows from the rows alone, and says what is in them."""

from __future__ import annotations

import re

import pytest
from reported import EVENT, ROWS, WIND, source
from varied import short_kit

from companion.campaigns.factor_effects import effects
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.report import report_html
from companion.campaigns.rows import Row


def test_the_report_needs_nothing_from_outside_and_has_no_date() -> None:
    page = report_html(source(ROWS))
    assert page == report_html(source(ROWS))
    assert not re.search(r"https?:|<script|@import|url\(|src=", page)
    assert not re.search(r"20[2-9]\d-\d\d-\d\d", page)


def test_what_came_from_outside_is_text() -> None:
    page = report_html(source(ROWS))
    assert "the &lt;reason&gt;" in page and "<reason>" not in page


def test_failures_are_counted_by_kind_phase_and_place() -> None:
    page = report_html(source(ROWS))
    crashes = sum(each.outcome is RowOutcome.CRASH for each in ROWS)
    violated = sum(each.outcome is RowOutcome.VIOLATED for each in ROWS)
    assert crashes and violated
    for what, count in (
        ("crash", crashes),
        ("violated: patrol", violated),
        ("flying the task", crashes + violated),
        ("Gate", crashes + violated),
    ):
        assert f'<td>{what}</td><td class="number">{count}</td>' in page


def test_what_matters_most_comes_first() -> None:
    found = effects(short_kit().factors, ROWS)
    assert found[0].path == WIND and (found[0].correlation or 0.0) < -0.8
    assert [total for _, _, total in found[0].groups] == [10] * 4
    assert found[0].groups[0][1] == 0 < found[0].groups[3][1]
    event = next(each for each in found if each.path == EVENT)
    assert [name for name, _, _ in event.groups] == ["false", "true"]


def test_a_search_tells_no_rates() -> None:
    assert "exact 95 % intervals" in report_html(source(ROWS))
    page = report_html(source(ROWS, is_search=True))
    assert "exact 95 % intervals" not in page and "say nothing of how often" in page


@pytest.mark.parametrize(
    "rows",
    [
        [FlownRow(Row(0, 1, ROWS[0].row.values), RowOutcome.INVALID, reason="unfair")],
        [FlownRow(ROWS[0].row, RowOutcome.DIED)],
        [ROWS[0], *(FlownRow(each.row, RowOutcome.INVALID) for each in ROWS[1:3])],
        ROWS[:1],
    ],
)
def test_few_rows_make_a_report(rows: list[FlownRow]) -> None:
    for is_search in (False, True):
        assert report_html(source(rows, is_search)).endswith("</html>\n")
