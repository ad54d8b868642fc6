"""Automata accept exactly the words that satisfy their formula: Spot decides it.

Published formulas and random ones, with marks on transitions and on states, with sets of letters
and with cubes as labels, among letters with at most one place, and restricted by constants. Where
Spot is missing, samples of words answer the same (`tests/properties/test_ltl.py`).
"""

from __future__ import annotations

import csv
import random
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from spot_authority import at_most_one, is_exact, needs_spot, random_formulas

from companion.ltl import labels
from companion.ltl.formula import Formula, always, atoms, disjoin, eventually, negate
from companion.ltl.parser import parse
from companion.ltl.restriction import restricted
from companion.ltl.translate import state_based, translate

pytestmark = [pytest.mark.slow, needs_spot]

TABLE = Path(__file__).parents[2] / "data" / "formulas.tsv"

LARGE = {
    "pickup-deliver-4",
    "pickup-deliver-5",
    "assume-guarantee-5",
    "fair-patrolling-5",
    "patrol-notwice-5",
    "paper-4",
    "fair-visit-5",
    "visit-until-alarm-5",
    "strict-ordered-patrolling-5",
    "assume-guarantee-4",
}
"""Formulas that take more than half a second; most of it is Spot's complement."""


def published() -> Iterator[object]:
    """Every formula in the file, the paper's for up to four sites; every eighth one in each run."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.reader(stream, delimiter="\t") if not row[0].startswith("#")]
    for count, (group, name, text, *_) in enumerate(rows):
        if group != "paper" or int(name.removeprefix("paper-")) <= 4:
            marks = [pytest.mark.long] if name in LARGE or count % 8 else []
            yield pytest.param(parse(text), id=name, marks=marks)


def check(formula: Formula, among: frozenset[str] = frozenset()) -> None:
    """Both forms of the automaton are exact, and that of the negation is."""
    automaton, opposite = translate(formula, exclusive=among), translate(negate(formula))
    by_states = state_based(automaton)
    assert by_states.has_state_acceptance
    letters = at_most_one(among)
    assert is_exact(automaton, formula, letters), str(formula)
    assert is_exact(by_states, formula, letters), str(formula)
    assert is_exact(opposite, negate(formula)), str(formula)


@pytest.mark.parametrize("formula", [*published()])
def test_published_formulas(formula: Formula) -> None:
    check(formula)


@pytest.mark.parametrize(
    "text",
    [
        "G F(a & X X X b) & F G c",
        "G F(a & X b) & F c",
        "G F((p0 W X(!p0 | F p1)) R (p0 | X X p3))",
        "F b & F c & G(a -> X(!a W b)) & G(b -> X(!b W c)) & G F a & G F c & G(c -> X(!c U a))",
        "(a U b | G F c) & (c R a | F G b)",
        "G(a | b U c | X F d)",
    ],
)
def test_what_is_suspended_restarted_or_left_out(text: str) -> None:
    check(parse(text))


SHAPES = {
    "small": {"propositions": 3, "size": 10},
    "large": {"propositions": 4, "size": 18},
    "recurring": {"propositions": 3, "size": 14, "F": 4, "G": 4},
    "nested U and R": {"propositions": 3, "size": 14, "U": 4, "R": 4, "F": 0, "G": 0},
    "with X": {"propositions": 2, "size": 14, "X": 4},
}
"""Of random formulas: propositions, nodes, and weights of operators other than 1."""


def seeds(few: int, many: int) -> list[object]:
    """The first ones, and more of them for sweeps."""
    return [
        *range(few),
        *(pytest.param(seed, marks=pytest.mark.long) for seed in range(few, many)),
    ]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", seeds(1, 60))
def test_random_formulas(shape: str, seed: int) -> None:
    for formula in random_formulas(10, seed, **SHAPES[shape]):
        check(formula)


@pytest.mark.parametrize("seed", seeds(1, 40))
def test_an_obligation_or_something_else(seed: int) -> None:
    """Where both are followed at once; the second half recurs, and is suspended."""
    ends = random_formulas(10, seed, propositions=3, size=6, G=0, R=0, W=0)
    others = random_formulas(10, seed + 1_000, propositions=3, size=8, F=4, G=4)
    for count, (end, other) in enumerate(zip(ends, others, strict=True)):
        recurring = other if count % 2 else always(eventually(other))
        check(disjoin(negate(end) if seed % 2 else end, recurring))


@pytest.mark.parametrize("seed", seeds(1, 10))
def test_with_cubes_as_labels(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if the propositions were many."""
    monkeypatch.setattr(labels, "MAX_LETTERS", 0)
    for formula in random_formulas(30, seed, propositions=3, size=10):
        check(formula)


@pytest.mark.parametrize("seed", seeds(1, 10))
def test_at_most_one_place_at_a_time(seed: int) -> None:
    for formula in random_formulas(30, seed, propositions=4, size=12):
        check(formula, frozenset(sorted(atoms(formula))[:3]))


@pytest.mark.parametrize("seed", seeds(1, 10))
def test_restricted_by_constants(seed: int) -> None:
    rng = random.Random(seed)
    for formula in random_formulas(30, seed, propositions=4, size=14):
        whole = translate(formula)
        constants = {name: rng.random() < 0.5 for name in atoms(formula) if rng.random() < 0.5}
        part = restricted(whole, constants)
        initial = frozenset(part.states(whole.initial))
        values = [f'G {"" if holds else "!"}"{name}"' for name, holds in constants.items()]
        left = replace(part.automaton, initial=initial)
        assert not constants.keys() & set(left.propositions)
        assert is_exact(left, formula, " & ".join(values) or "true"), (str(formula), constants)


@pytest.mark.slow
def test_an_automaton_that_is_wrong_is_noticed() -> None:
    assert not is_exact(translate(parse("F a")), parse("G F a"))
    assert not is_exact(translate(parse("G F a")), parse("F a"))
    assert is_exact(translate(parse("F at(A)")), parse("at(A) | F at(A)"))
