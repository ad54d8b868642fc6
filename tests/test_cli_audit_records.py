"""`companion audit` of records that were written by hand, cut off or damaged."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from audited import outcomes
from commands import Companion

from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.plans import WrittenTreeAdopted
from companion.flight_events.sortie import TaskSatisfied
from companion.flight_events.word import PositionLeft
from companion.flight_events.writing import line_of
from companion.ltl.conjuncts import conjuncts
from companion.ltl.parser import parse


@pytest.fixture(scope="module")
def good(surveillance_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return shutil.copytree(surveillance_run, tmp_path_factory.mktemp("good") / "run")


# -- hand-made records -----------------------------------------------------------------------------

Write = Callable[..., Path]


class Begun(NamedTuple):
    """A position with which conjuncts begin anew, or at which they are dropped."""

    facts: str
    restarted: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()


@pytest.fixture
def write(tmp_path: Path) -> Iterator[Write]:
    """Writes the record of a flight; its positions are given by their facts in one text."""

    def written(
        task: dict[str, str],
        *positions: str | Begun,
        rests: bool = False,
        priorities: dict[str, int] | None = None,
    ) -> Path:
        happened: list[FlightEvent] = [WrittenTreeAdopted(task, priorities or {})]
        for number, given in enumerate(positions):
            begun = given if isinstance(given, Begun) else Begun(given)
            is_last = number == len(positions) - 1
            left = PositionLeft(
                number,
                facts=tuple(begun.facts.split()),
                risen=(),
                reached_s=0.0,
                withdrawn=(),
                restarted=begun.restarted,
                for_ever=rests and is_last,
                dropped=begun.dropped,
            )
            happened.append(left)
        happened.append(TaskSatisfied())
        lines = [line_of(Stamped(1.0 * i, event)) for i, event in enumerate(happened)]
        text = "".join(json.dumps(line) + "\n" for line in lines)
        (tmp_path / "events.jsonl").write_text(text, encoding="utf-8")
        return tmp_path

    yield written


@pytest.mark.parametrize(
    ("formula", "word", "rests", "outcome", "code"),
    [
        ("F p", ["", "p", ""], False, ("fulfilled", 1), 0),
        ("F p", ["", ""], False, ("open", None), 0),
        ("F p", ["", ""], True, ("unfulfilled", None), 6),
        ("G !p", ["", "q"], False, ("open", None), 0),
        ("G !p", ["", "q"], True, ("satisfied", None), 0),
        ("G !p", ["", "q p", ""], True, ("violated", 1), 6),
        ("G F p", ["p", ""], True, ("unfulfilled", None), 6),
        ("G F p", ["", "p"], True, ("satisfied", None), 0),
        ("G (p -> X q)", ["p", ""], False, ("violated", 1), 6),
        ("p", [], False, ("open", None), 0),
    ],
)
def test_the_outcome_of_a_word(
    formula: str,
    word: list[str],
    rests: bool,
    outcome: tuple[str, int | None],
    code: int,
    companion: Companion,
    write: Write,
) -> None:
    assert len(conjuncts(parse(formula))) == 1
    assert outcomes(companion, write({"it": formula}, *word, rests=rests)) == (
        code,
        {"it": outcome},
    )


def test_a_conjunct_that_begins_anew_forgets_what_it_read(
    companion: Companion, write: Write
) -> None:
    anew = Begun("q", ("it",))
    task = {"it": "F p", "other": "F p"}
    _, found = outcomes(companion, write(task, "p", anew, rests=True))
    assert found == {"it": ("unfulfilled", None), "other": ("fulfilled", 0)}


@pytest.mark.parametrize(
    ("formula", "before", "anew", "rests", "told"),
    [
        ("G F p", "", "p", True, "satisfied over the whole flight; satisfied"),
        ("G (F p | q)", "", "q", True, "violated over the whole flight; satisfied"),
        ("p U q", "r", "q", False, "violated over the whole flight; violated"),
        ("F p", "p", "q", False, "satisfied over the whole flight; holds so far"),
        ("G (F p | q)", "", "q", False, "holds so far over the whole flight; holds so far"),
    ],
)
def test_both_verdicts_are_told_of_a_conjunct_that_began_anew(
    formula: str,
    before: str,
    anew: str,
    rests: bool,
    told: str,
    companion: Companion,
    write: Write,
) -> None:
    run = write({"it": formula}, before, Begun(anew, ("it",)), rests=rests)
    ended = companion("audit", run)
    assert f"\n           {told} since position 1\n" in ended.out
    (conjunct,) = json.loads(companion("audit", run, "--json").out)["conjuncts"]
    assert conjunct["since"] == 1
    is_whole_failure = conjunct["whole"] in ("violated", "unfulfilled")
    assert is_whole_failure is told.startswith("violated")


def test_one_verdict_is_told_of_a_conjunct_that_did_not(companion: Companion, write: Write) -> None:
    run = write({"it": "F p"}, "", Begun("p", ("other",)))
    assert "over the whole flight" not in companion("audit", run).out
    (conjunct,) = json.loads(companion("audit", run, "--json").out)["conjuncts"]
    assert (conjunct["since"], conjunct["whole"]) == (0, conjunct["outcome"])


def test_a_violation_stays_one_when_its_conjunct_begins_anew(
    companion: Companion, write: Write
) -> None:
    anew = Begun("", ("it",))
    assert outcomes(companion, write({"it": "G !p"}, "p", anew))[1] == {"it": ("violated", 0)}


DROPPED = [Begun("", dropped=("it",)), Begun("q", dropped=("it",))]


@pytest.mark.parametrize(
    ("formula", "positions", "outcome", "told"),
    [
        ("G F p", ["p", *DROPPED], "unfulfilled", "priority 2, dropped at positions 1 to 2"),
        ("G !q", ["", *DROPPED], "violated", "priority 2, dropped at positions 1 to 2"),
        ("G !p", ["p", DROPPED[0]], "violated", "priority 2, dropped at position 1"),
        ("F p", ["", DROPPED[0], ""], "unfulfilled", "priority 2, dropped at position 1"),
        ("G p", [*DROPPED, "p"], "violated", "priority 2, dropped at positions 0 to 1"),
        ("F q", [DROPPED[0], "", DROPPED[1]], "fulfilled", "priority 2, dropped at positions 0, 2"),
        ("F p", ["p"], "fulfilled", "priority 2, never dropped"),
    ],
)
def test_a_line_that_may_be_dropped_is_told_and_is_no_failure(
    formula: str,
    positions: list[str | Begun],
    outcome: str,
    told: str,
    companion: Companion,
    write: Write,
) -> None:
    run = write({"it": formula}, *positions, rests=True, priorities={"it": 2})
    code, found = outcomes(companion, run)
    assert (code, found["it"][0]) == (0, outcome)
    assert f"\n           {told}\n" in companion("audit", run).out


def test_a_line_that_was_violated_is_judged_from_where_it_was_taken_up(
    companion: Companion, write: Write
) -> None:
    positions = ["p", Begun("", dropped=("it",)), Begun("", ("it",)), ""]
    run = write({"it": "G !p"}, *positions, rests=True, priorities={"it": 1})
    (conjunct,) = json.loads(companion("audit", run, "--json").out)["conjuncts"]
    assert (conjunct["outcome"], conjunct["whole"]) == ("satisfied", "violated")
    assert (conjunct["priority"], conjunct["dropped"]) == (1, [[1, 1]])
    told = companion("audit", run).out
    assert "violated over the whole flight; satisfied since position 2" in told
    assert "it is dropped" in told


def test_a_record_that_told_of_no_violation_is_noticed(companion: Companion, write: Write) -> None:
    ended = companion("audit", write({"it": "G !p"}, "p"))
    assert ended.code == 6
    assert "not the same in flight: it at position 0" in ended.out


def test_a_flight_without_a_task_shows_its_word(companion: Companion, write: Write) -> None:
    """As of a mission that brings its own tree."""
    ended = companion("audit", write({}, "p"))
    assert ended.code == 0
    assert "the mission has no task" in ended.out
    assert re.search(r"^ +0  00:01\.0 +p$", ended.out, re.M)


# -- cut off, or damaged ---------------------------------------------------------------------------


def test_a_run_that_was_cut_off_anywhere_is_audited_as_far_as_it_goes(
    companion: Companion, good: Path, tmp_path: Path
) -> None:
    whole = (good / "events.jsonl").read_bytes()
    first = whole.index(b"\n") + 1
    torn = 0
    for size in range(first, len(whole) - 1, len(whole) // 20):
        (tmp_path / "events.jsonl").write_bytes(whole[:size])
        ended = companion("audit", tmp_path)
        assert ended.code == 0, ended.err
        assert "none: the run was cut off" in ended.out
        is_torn = "the last line of events.jsonl is not whole" in ended.out
        torn += is_torn
        assert is_torn is (whole[size - 1 : size] != b"\n" and whole[size : size + 1] != b"\n")
    assert torn > 15


def damaged(good: Path, folder: Path, change: Callable[[list[str]], object]) -> Path:
    lines = (good / "events.jsonl").read_text(encoding="utf-8").splitlines()
    change(lines)
    (folder / "events.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


NO_FORMULA = Stamped(0.0, WrittenTreeAdopted({"it": "G ("}))


def replaced(number: int, text: str) -> Callable[[list[str]], object]:
    return lambda lines: lines.__setitem__(number, text)


def edited(**change: object) -> Callable[[list[str]], object]:
    """The first position with other values."""

    def edit(lines: list[str]) -> None:
        number = next(i for i, line in enumerate(lines) if '"position"' in line)
        lines[number] = json.dumps(json.loads(lines[number]) | change)

    return edit


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (replaced(2, '{"t_s": 1'), r"events\.jsonl:3:1: this line is not JSON\n"),
        (replaced(2, "[1]"), r"events\.jsonl:3:1: this line is not a JSON object"),
        (replaced(2, "{}"), r"events\.jsonl:3:1: t_s is missing"),
        (edited(number=4), "position 4 stands where 0 is due"),
        (edited(number=True), "number is not of its type here"),
        (edited(facts="at(A)"), "facts is not of its type here"),
        (edited(facts=[1]), "facts is not of its type here"),
        (edited(mood="good"), "mood has no place here"),
        (
            replaced(2, '{"t_s": 1, "type": "?"}'),
            r"3:1: \? is not a type of event",
        ),
        (edited(t_s=float("nan")), "t_s is not a time in seconds"),
        (lambda lines: lines.pop(0), "no plan was made in this run"),
        (replaced(0, json.dumps(line_of(NO_FORMULA))), r"events\.jsonl:1:1: .*\n.*\^"),
    ],
)
def test_a_damaged_record_is_refused_with_its_place(
    change: Callable[[list[str]], object],
    message: str,
    companion: Companion,
    good: Path,
    tmp_path: Path,
) -> None:
    ended = companion("audit", damaged(good, tmp_path, change))
    assert ended.code == 2
    assert re.search(message, ended.err, re.S), ended.err


def test_a_folder_that_is_none_is_refused(companion: Companion, tmp_path: Path) -> None:
    ended = companion("audit", tmp_path / "nowhere")
    assert ended.code == 2
    assert "there is no run folder" in ended.err
