"""The oracle can be trusted, and it can fail: it notices automata with a single mistake."""

from __future__ import annotations

import csv
import random
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracle import LOOPS, PREFIX, Lasso, Sample, accepted, satisfying, words_for

from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.formula import Formula, negate
from companion.ltl.parser import parse
from companion.ltl.semantics import accepts
from companion.ltl.translate import translate

pytestmark = pytest.mark.slow

TABLE = Path(__file__).parents[2] / "data" / "formulas.tsv"
EMPTY, P = frozenset[str](), frozenset({"p"})


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("p", 8),
        ("X X X !p", 8),
        ("X X X X p", 8),  # the loop begins again
        ("F p", 15),
        ("G p", 1),
        ("G F p", 15),
        ("F G p", 1),
        ("p U !p", 15),
        ("p W !p", 16),
        ("p R !p", 1),
        ("p & X !p R p", 8),  # the same as p: it may be released at once
        ("p -> X p", 12),
        ("p <-> X p", 8),
        ("G(p <-> X X p)", 4),
        ("G(p -> X !p)", 7),  # subsets of a circle of four without neighbours
        ("p | X p | false", 12),
        ("p & true & !X p", 4),
    ],
)
def test_how_many_of_the_loops_of_length_four(text: str, count: int) -> None:
    letters = (EMPTY, P)
    loops = [((), (a, b, c, d)) for a in letters for b in letters for c in letters for d in letters]
    formula = parse(text)
    sample = Sample(loops)
    assert len(sample.words) == 16
    assert satisfying(formula, sample).bit_count() == count
    assert accepted(translate(formula), sample) == satisfying(formula, sample)


def test_a_word_of_another_shape_is_refused() -> None:
    for prefix, loop in ((PREFIX + 1, 1), (0, 0), (0, 5)):
        with pytest.raises(ValueError, match="not a shape"):
            satisfying(parse("p"), Sample([((P,) * prefix, (P,) * loop)]))


NAMES = ("p", "q")
LETTERS = st.frozensets(st.sampled_from(NAMES))


@st.composite
def lassos(draw: st.DrawFn) -> Lasso:
    """A word of a shape that samples can have."""
    loop = draw(st.sampled_from(LOOPS))
    prefix = draw(st.integers(0, PREFIX))
    word = draw(st.lists(LETTERS, min_size=prefix + loop, max_size=prefix + loop))
    return tuple(word[:prefix]), tuple(word[prefix:])


@st.composite
def automata(draw: st.DrawFn) -> BuchiAutomaton:
    """Any automaton of few states, not only those that formulas have."""
    states, marks = draw(st.integers(1, 4)), draw(st.integers(0, 3))
    numbers = st.integers(0, states - 1)
    labels = st.builds(
        lambda signs: Label(
            frozenset(name for name, sign in zip(NAMES, signs, strict=True) if sign == 1),
            frozenset(name for name, sign in zip(NAMES, signs, strict=True) if sign == 2),
        ),
        st.tuples(st.integers(0, 2), st.integers(0, 2)),
    )
    some_marks = (
        st.frozensets(st.sampled_from(range(marks))) if marks else st.just(frozenset[int]())
    )
    edges = st.builds(Transition, numbers, labels, numbers, some_marks)
    initial = draw(st.frozensets(numbers, min_size=1))
    return BuchiAutomaton(states, initial, tuple(draw(st.lists(edges, max_size=9))), marks)


@pytest.mark.long
@given(automata(), st.lists(lassos(), min_size=5, max_size=20, unique=True))
def test_acceptance_is_a_component_with_all_marks(
    automaton: BuchiAutomaton, words: list[Lasso]
) -> None:
    """A nested fixpoint here, strong components there."""
    verdicts = accepted(automaton, Sample(words))
    for i, (prefix, loop) in enumerate(words):
        assert bool(verdicts >> i & 1) is accepts(automaton, prefix, loop)


def mutants(automaton: BuchiAutomaton) -> Iterator[BuchiAutomaton]:
    """All automata that differ in one edge: dropped, led elsewhere, marked, relabelled."""
    for i, edge in enumerate(automaton.transitions):
        changed = [replace(edge, target=s) for s in range(automaton.states) if s != edge.target]
        changed += [replace(edge, marks=edge.marks ^ {mark}) for mark in range(automaton.marks)]
        positive, negative = edge.label.positive, edge.label.negative
        weaker = [Label(positive - {name}, negative) for name in sorted(positive)]
        weaker += [Label(positive, negative - {name}) for name in sorted(negative)]
        changed += [replace(edge, label=label) for label in weaker]
        before, after = automaton.transitions[:i], automaton.transitions[i + 1 :]
        for edges in ((), *((edge,) for edge in changed)):
            yield replace(automaton, transitions=(*before, *edges, *after))


def some_published() -> list[tuple[str, str]]:
    """Name and text of formulas from all groups of the file but the paper's."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.reader(stream, delimiter="\t") if not row[0].startswith("#")]
    small = [r for r in rows if r[0] in ("dac", "eh", "sb") or r[1].endswith("-3")]
    return [(row[1], row[2]) for row in small[::12] if row[0] != "paper"]


@pytest.mark.long
def test_mutants_are_caught() -> None:
    """At least 95 of 100 automata with one mistake fail where they are checked as all others.

    A mutant counts if it errs on any word of its own sample or of a larger one.
    """
    caught, missed = 0, []
    for name, text in some_published():
        rng, formula = random.Random(name), parse(text)
        automaton, opposite = translate(formula), translate(negate(formula))
        every = list(mutants(automaton))
        unnoticed = []
        for mutant in rng.sample(every, min(len(every), 4)):
            if errs(mutant, formula, words_for(formula, [mutant, opposite], rng)):
                caught += 1
            else:
                unnoticed.append(mutant)
        larger = words_for(formula, [automaton, opposite, *unnoticed], rng, effort=4)
        missed += [name for mutant in unnoticed if errs(mutant, formula, larger)]
    assert caught > 30
    assert len(missed) < 0.05 * (caught + len(missed)), missed


def errs(automaton: BuchiAutomaton, formula: Formula, sample: Sample) -> bool:
    """Whether an automaton is wrong about a word."""
    return accepted(automaton, sample) != satisfying(formula, sample)
