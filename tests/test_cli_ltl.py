"""`companion ltl` as a user meets it: what it prints, and with which exit code it ends."""

from __future__ import annotations

import csv
import io
import re
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from commands import Companion, Ended

pytestmark = pytest.mark.slow

PAPER = "G ((F at(A) | targetFound) & (F at(B) | targetFound))"


Ltl = Callable[..., Ended]


def names(ended: Ended) -> list[str]:
    """The names of the automata on standard output, as HOA."""
    return re.findall(r'^name: "(.*)"$', ended.out, re.MULTILINE)


def table(ended: Ended) -> list[dict[str, str]]:
    """The rows on standard output, as a program reads them."""
    rows = csv.DictReader(io.StringIO(ended.out), delimiter="\t", quoting=csv.QUOTE_NONE)
    return list(rows)


@pytest.fixture
def ltl(companion: Companion) -> Ltl:
    """Runs `companion ltl ARGUMENTS`."""
    return partial(companion, "ltl")


@pytest.fixture
def batch(tmp_path: Path) -> Path:
    """A file with two formulas that have automata, and three that have not."""
    path = tmp_path / "formulas.txt"
    deep = "X " * 12_000 + "a"
    lines = ["# the task", "G F a & F b", "", "  G (a &", "  # more", "X caf\u00e9", deep, " F c "]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_each_conjunct_gets_its_automaton(ltl: Ltl) -> None:
    ended = ltl(PAPER)
    assert (ended.code, ended.err) == (0, "")
    assert names(ended) == ["G(F at(A) | targetFound)", "G(F at(B) | targetFound)"]
    assert ended.out.count("HOA: v1\n") == ended.out.count("--END--\n") == 2
    assert ended.out.endswith("--END--\n")


def test_monolithic_makes_one(ltl: Ltl) -> None:
    assert names(ltl("F a & F b", "--monolithic")) == ["F a & F b"]


@pytest.mark.parametrize("name", ["patroling", "patrol", "Patrolling"])
def test_a_name_near_to_a_pattern_is_noticed(ltl: Ltl, name: str) -> None:
    ended = ltl(f"{name}(A, B)")
    said = "is read as a proposition. Did you mean patrolling(place, place, ...)?"
    assert (ended.code, ended.err) == (0, f"notice     {name}(A, B) {said}\n")


def test_other_names_are_not_noticed(ltl: Ltl) -> None:
    assert ltl("F (at(A) & uploaded & visible(A))").err == ""


def test_stats_are_a_table(ltl: Ltl) -> None:
    first, second = table(ltl("G F a & X b", "--format", "stats"))
    times = [float(row.pop("milliseconds")) for row in (first, second)]
    assert min(times) > 0
    assert first == {
        "states": "1",
        "transitions": "2",
        "marks": "1",
        "propositions": "1",
        "deterministic": "yes",
        "complete": "yes",
        "formula": "G F a",
    }
    assert (second["states"], second["complete"], second["formula"]) == ("3", "no", "X b")


def test_state_based(ltl: Ltl) -> None:
    by_transitions, by_states = (
        ltl("patrolling(A, B)", "--monolithic", *option) for option in ((), ("--state-based",))
    )
    assert "acc-name: generalized-Buchi 2\n" in by_transitions.out
    assert "acc-name: Buchi\n" in by_states.out
    assert re.search(r"^State: \d+ \{0\}$", by_states.out, re.MULTILINE)
    rows = table(ltl("G F a", "--state-based", "--format", "stats"))
    assert [row["states"] for row in rows] == ["2"]


def test_drawings_follow_each_other(ltl: Ltl) -> None:
    ended = ltl("F a & F b", "--format", "dot")
    assert re.findall(r'^digraph "(.*)" \{$', ended.out, re.MULTILINE) == ["F a", "F b"]


def test_exclusive_propositions_make_smaller_automata(ltl: Ltl) -> None:
    visits = ("visit(A, B, C)", "--monolithic", "--format", "stats")
    plain = table(ltl(*visits))[0]
    exclusive = table(ltl(*visits, "--exclusive", "at(A), at(B), at(C), ok(A, B)"))[0]
    assert int(exclusive["transitions"]) < int(plain["transitions"])
    assert int(exclusive["states"]) <= int(plain["states"])


def test_a_name_that_cannot_be_exclusive(ltl: Ltl) -> None:
    ended = ltl("F a", "--exclusive", "a, F b")
    assert ended.code == 2
    assert "'F b' is not a proposition such as at(A)" in ended.err


@pytest.mark.parametrize("arguments", [(), ("F a", "--batch", "-")])
def test_a_formula_or_a_batch(arguments: tuple[str, ...], ltl: Ltl) -> None:
    ended = ltl(*arguments)
    assert (ended.code, ended.out) == (2, "")
    assert "give either a formula or --batch FILE" in ended.err


@pytest.mark.long
def test_a_formula_that_is_too_large_names_the_limit(ltl: Ltl) -> None:
    ended = ltl("X " * 12_000 + "a")
    assert (ended.code, ended.out) == (2, "")
    assert re.search(r"more than 10,?000 states", ended.err)
    assert "with fewer operators" in ended.err
    assert "split" not in ended.err


def test_a_batch_reports_what_failed_and_prints_the_rest(ltl: Ltl, batch: Path) -> None:
    ended = ltl("--batch", batch)
    assert ended.code == 2
    assert names(ended) == [f"{batch}:2: G F a", f"{batch}:2: F b", f"{batch}:8: F c"]
    assert re.findall(rf"^{batch}:(\d+:\d+): ", ended.err, re.MULTILINE) == ["4:9", "6:6", "7:1"]
    assert ended.err.endswith(f"\n3 of 5 formulas in {batch} have no automaton\n")


def test_a_table_of_a_batch_names_the_lines(ltl: Ltl, batch: Path) -> None:
    rows = table(ltl("--batch", batch, "--format", "stats"))
    found = [(row["line"], row["formula"]) for row in rows]
    assert found == [("2", "G F a"), ("2", "F b"), ("8", "F c")]


def test_a_batch_that_is_not_there(ltl: Ltl, tmp_path: Path) -> None:
    ended = ltl("--batch", tmp_path / "none.txt")
    assert ended.code == 2
    assert "No such file" in ended.err


COMMAND = [sys.executable, "-m", "companion", "ltl"]


def test_a_batch_is_answered_line_by_line() -> None:
    """The answer to a formula comes before the next one is asked."""
    with subprocess.Popen(
        [*COMMAND, "--batch", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin and process.stdout
        for number in (1, 2):
            process.stdin.write(f"F p{number}\n")
            process.stdin.flush()
            answer = list(iter(process.stdout.readline, "--END--\n"))
            assert answer[1] == f'name: "<stdin>:{number}: F p{number}"\n'
        process.stdin.close()
        assert process.wait(timeout=600) == 0


def test_a_reader_that_leaves_is_no_error() -> None:
    with subprocess.Popen(
        [*COMMAND, "--batch", "-"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdin and process.stdout and process.stderr
        process.stdin.write("F a\n")
        process.stdin.flush()
        process.stdout.readline()
        process.stdout.close()
        process.stdin.write("F b\n")
        process.stdin.close()
        assert process.stderr.read() == ""
        assert process.wait(timeout=600) == 1
