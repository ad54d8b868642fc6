"""What `companion campaign` and `falsify` refuse before their first flight."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import pytest
from commands import Companion
from rich.progress import Progress

from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.row_file import RowFile
from companion.campaigns.rows import Row, random_row
from companion.campaigns.table import read_table
from companion.cli.campaigns import LIMIT_S, Tell, begun, kit_of, tell_outcomes
from companion.errors import CompanionError

if TYPE_CHECKING:
    from companion.campaigns.campaign import Campaign

HEADER = "# format: 1\n# scenario: {scenario}\n# seed: 0\n# limit_s: 1800\nindex,outcome,score\n"


@pytest.mark.parametrize(
    ("earlier", "why"),
    [
        (None, "cannot be read: [Errno 2] No such file or directory"),
        ("index,outcome\n", "is not the table of a campaign"),
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


RETURN_HOME = Path(__file__).parents[1] / "missions" / "return_home.yaml"


@pytest.fixture(scope="module")
def header() -> str:
    """The head of a table of return_home as it is flown here."""
    lines = kit_of(RETURN_HOME, None, LIMIT_S).header(0, runs=1)
    return "".join(f"# {key}: {value}\n" for key, value in lines.items())


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ("index,outcome,score\n0,crash,abc\n", "has a row that does not belong to a campaign"),
        ("index,outcome,score\n0,cra", "has a row that does not belong to a campaign"),
        ("index,outcome\n0,crash\n", "has a row that does not belong to a campaign"),
        ("index,outcome,score\n0,invalid,1.0\n", "has no row that counts"),
        ("", "has no row that counts"),
    ],
)
def test_a_table_whose_rows_were_edited_is_refused_before_a_flight(
    tmp_path: Path, companion: Companion, header: str, rows: str, why: str
) -> None:
    (tmp_path / "earlier.csv").write_text(header + rows)
    against = ("--out", tmp_path / "flown", "--against", tmp_path / "earlier.csv")
    ended = companion("campaign", "return_home", "--runs", 1, *against)
    assert ended.code == 2 and why in ended.err
    assert not (tmp_path / "flown").exists()


@pytest.mark.parametrize(
    ("before", "now", "code", "told"),
    [
        ("satisfied", "satisfied", 0, ""),
        ("crash", "satisfied", 0, ""),
        ("crash", "violated", 0, ""),
        ("satisfied", "crash", 6, "rows that fail and did not before: 1\n"),
        ("crash", "invalid", 2, "no row counts in both "),
    ],
)
def test_rows_that_fail_and_did_not_before_are_an_exit_code(
    tmp_path: Path, companion: Companion, header: str, before: str, now: str, code: int, told: str
) -> None:
    score = -1 if RowOutcome(before).is_failure else 1
    (tmp_path / "earlier.csv").write_text(f"{header}index,outcome,score\n0,{before},{score}\n")
    kit = kit_of(RETURN_HOME, None, LIMIT_S)
    rows = RowFile(tmp_path / "flown", kit.header(0, runs=1))
    rows.add(FlownRow(random_row(kit.factors, 0, 0), RowOutcome(now)))
    rows.close()
    against = ("--resume", tmp_path / "flown", "--against", tmp_path / "earlier.csv")
    ended = companion("campaign", "return_home", *against)
    assert ended.code == code and told in ended.err
    assert "McNemar" in ended.out and "report" in ended.out


def test_the_table_of_a_search_is_nothing_to_compare_with(
    tmp_path: Path, companion: Companion, header: str
) -> None:
    (tmp_path / "earlier.csv").write_text(header.replace("# runs: 1", "# budget: 16"))
    ended = companion("campaign", "return_home", "--against", tmp_path / "earlier.csv")
    assert ended.code == 2 and "is the table of a search" in ended.err


def test_a_table_that_a_spreadsheet_has_saved_is_the_same(tmp_path: Path, header: str) -> None:
    text = header + "index,outcome,score\n0,crash,-1.0\n"
    saved = tmp_path / "saved.csv"
    saved.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    plain = tmp_path / "plain.csv"
    plain.write_text(text)
    assert read_table(saved) == read_table(plain)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--runs", 50], "--runs 50 does not go with --resume: the campaign in "),
        (["--seed", 1], "has 0"),
        (["--limit-s", 60], "has 1800"),
        (["--out", "elsewhere"], "--out elsewhere does not go with --resume"),
    ],
)
def test_other_options_than_those_of_the_campaign_to_resume_are_refused(
    tmp_path: Path, companion: Companion, options: list[object], why: str
) -> None:
    begun = {"format": "1", "seed": "0", "limit_s": "1800", "runs": "24"}
    (tmp_path / "rows.jsonl").write_text(json.dumps(begun) + "\n")
    ended = companion("campaign", "return_home", "--resume", tmp_path, *options)
    assert ended.code == 2 and why in ended.err


def test_a_header_without_numbers_is_none_of_a_campaign(
    tmp_path: Path, companion: Companion
) -> None:
    (tmp_path / "rows.jsonl").write_text('{"runs": "many", "seed": "0", "limit_s": "9"}\n')
    ended = companion("campaign", "return_home", "--resume", tmp_path)
    assert ended.code == 2 and "is not that of a campaign" in ended.err


def test_a_limit_is_what_the_header_says() -> None:
    assert kit_of(RETURN_HOME, None, 1234567.8).limit_s == 1234570.0


def test_an_address_without_a_port_is_none_of_a_scheduler(
    tmp_path: Path, companion: Companion
) -> None:
    pytest.importorskip("distributed")
    ended = companion("campaign", "return_home", "--out", tmp_path / "f", "--dask", "host")
    assert ended.code == 2 and "write tcp://HOST:8786" in ended.err


def test_a_search_in_which_nothing_varies_is_refused(tmp_path: Path, companion: Companion) -> None:
    ended = companion("falsify", "return_home", "--out", tmp_path / "flown")
    assert ended.code == 2
    world, refusal = ended.err.splitlines()[:2]
    assert re.fullmatch(r"world      .*return_home\.sim\.yaml", world)
    assert refusal == "there is nothing to search: the scenario has no key vary"
    assert not (tmp_path / "flown").exists()


def test_rows_that_were_there_already_make_no_campaign_quicker(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter((100.0, 102.0))
    fake = SimpleNamespace(monotonic=lambda: next(clock))
    monkeypatch.setattr("companion.cli.campaigns.time", fake)
    tell = Tell(Progress(disable=True), 10)
    flown = FlownRow(Row(0, 0, {}), RowOutcome.SATISFIED)
    for _ in range(9):
        tell.kept(flown)
    tell(flown)
    assert capsys.readouterr().err == "flown      10 of 10, 0 failed, 0.50 flights/s\n"


@pytest.mark.parametrize(
    ("is_search", "told"),
    [(False, "FAILED      1  crash                        50.0 % (1.3 to 98.7 %)"),
     (True, "FAILED      1  crash")],
)  # fmt: skip
def test_rows_of_a_search_have_no_rates(
    capsys: pytest.CaptureFixture[str], is_search: bool, told: str
) -> None:
    rows = [
        FlownRow(Row(0, 0, {}), RowOutcome.CRASH),
        FlownRow(Row(1, 1, {}), RowOutcome.SATISFIED),
    ]
    tell_outcomes(cast("Campaign", SimpleNamespace(rows=rows)), is_search)
    assert told in capsys.readouterr().out.splitlines()


def test_ctrl_c_beside_a_flight_says_how_to_go_on(tmp_path: Path) -> None:
    kit = kit_of(RETURN_HOME, None, LIMIT_S)
    with (
        pytest.raises(CompanionError, match="stopped\n    0 rows are kept\n    to go on: again"),
        begun(kit, tmp_path, {"seed": "0"}, 1, 1, None, "again"),
    ):
        raise KeyboardInterrupt


@pytest.mark.parametrize("is_search", [False, True])
def test_more_rows_may_be_unfair_than_count(
    capsys: pytest.CaptureFixture[str], is_search: bool
) -> None:
    unfair = [FlownRow(Row(i, i, {}), RowOutcome.INVALID, reason="a wall") for i in (1, 2)]
    rows = [FlownRow(Row(0, 0, {}), RowOutcome.CRASH), *unfair]
    tell_outcomes(cast("Campaign", SimpleNamespace(rows=rows)), is_search)
    assert "2  invalid                      of no account; a wall" in capsys.readouterr().out


def test_the_folder_of_a_search_is_told_as_it_is(companion: Companion) -> None:
    assert "falsify-NAME" in companion("falsify", "--help").out
    assert "campaign-NAME" in companion("campaign", "--help").out


def test_rows_of_which_nobody_knows_the_number_are_told_ten_by_ten(
    capsys: pytest.CaptureFixture[str],
) -> None:
    tell = Tell(Progress(disable=True), 20)
    flown = FlownRow(Row(0, 0, {}), RowOutcome.SATISFIED)
    for _ in range(20):
        tell(flown)
    tell.begin("simpler", None)
    for _ in range(25):
        tell(flown)
    lines = [line.partition(",")[0] for line in capsys.readouterr().err.splitlines()]
    assert lines[0] == "flown      2 of 20" and lines[9] == "flown      20 of 20"
    assert lines[10:] == ["simpler    10 flights", "simpler    20 flights"]
