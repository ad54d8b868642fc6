"""Automata of published formulas: they accept what the semantics says, and they are small."""

from __future__ import annotations

import csv
import random
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.formula import negate
from companion.ltl.parser import parse
from companion.ltl.semantics import Letter, accepts, holds
from companion.ltl.translate import TranslationLimit, translate

FORMULAS = Path(__file__).parents[2] / "data" / "formulas.tsv"
WORDS = 24
"""Lasso words a formula, before mutations."""


@pytest.mark.parametrize(
    ("text", "states", "marks"),
    [
        ("G(F at(A) | targetFound)", 2, 1),
        ("G((targetFound | targetReported) -> F targetReported)", 2, 1),
        ("G(targetReported -> X at(Home))", 2, 0),
        ("G F p", 1, 1),
        ("G F p & G F q", 1, 2),
        ("F p", 2, 1),
        ("p U q", 2, 1),
        ("F G p", 2, 1),
        ("X p", 3, 0),
        ("true", 1, 0),
    ],
)
def test_size(text: str, states: int, marks: int) -> None:
    automaton = translate(parse(text))
    assert (automaton.states, automaton.marks) == (states, marks)
    assert automaton.initial == {0}


@pytest.mark.parametrize("text", ["false", "F a & G !a", "X(a & !a)", "G F a & F G !a"])
def test_what_cannot_hold_has_no_transition(text: str) -> None:
    automaton = translate(parse(text))
    assert (automaton.states, automaton.transitions) == (1, ())


@pytest.mark.parametrize(
    "text",
    [
        "G(F at(A) | targetFound)",
        "G((targetFound | targetReported) -> F targetReported)",
        "G(targetReported -> X at(Home))",
    ],
)
def test_conjuncts_of_the_paper_are_deterministic(text: str) -> None:
    automaton = translate(parse(text))
    names = automaton.propositions
    for bits in range(1 << len(names)):
        letter = frozenset(name for i, name in enumerate(names) if bits >> i & 1)
        for leaving in automaton.outgoing:
            assert sum(transition.label.matches(letter) for transition in leaving) <= 1


def test_limit() -> None:
    memory = parse("G(a -> " + "X " * 8 + "b)")  # the last eight values of a
    with pytest.raises(TranslationLimit, match="more than 100 states"):
        translate(memory, max_states=100)
    choices = parse(" & ".join(f"(a{i} | b{i})" for i in range(12)))
    with pytest.raises(TranslationLimit, match="more than 1000 transitions"):
        translate(choices, max_states=1000)


def published() -> list[tuple[str, str]]:
    """Name and text of every formula in the file."""
    with FORMULAS.open(encoding="utf-8") as file:
        rows = [row for row in csv.reader(file, delimiter="\t") if not row[0].startswith("#")]
    return [(row[1], row[2]) for row in rows]


@pytest.mark.parametrize(("name", "text"), published())
def test_published_formula(name: str, text: str) -> None:
    formula = parse(text)
    automaton, opposite = translate(formula), translate(negate(formula))
    verdicts = set()
    for prefix, loop in words(automaton, opposite, random.Random(name)):
        verdict = holds(formula, prefix, loop)
        verdicts.add(verdict)
        assert accepts(automaton, prefix, loop) is verdict
        assert accepts(opposite, prefix, loop) is not verdict
    is_open = bool(automaton.transitions) + bool(opposite.transitions)
    assert len(verdicts) == is_open  # both are met, unless the formula is valid


def words(
    automaton: BuchiAutomaton, opposite: BuchiAutomaton, rng: random.Random
) -> Iterator[tuple[list[Letter], list[Letter]]]:
    """Lasso words along the edges of either automaton, and each with one bit changed."""
    names = sorted({*automaton.propositions, *opposite.propositions})
    for _ in range(WORDS):
        for source in (automaton, opposite):
            if not source.transitions:
                continue
            prefix, loop = walk(source, names, rng)
            yield prefix, loop
            changed = rng.randrange(len(prefix) + len(loop))
            word = prefix + loop
            word[changed] = word[changed] ^ {rng.choice(names)}
            yield word[: len(prefix)], word[len(prefix) :]


def walk(
    automaton: BuchiAutomaton, names: list[str], rng: random.Random
) -> tuple[list[Letter], list[Letter]]:
    """A word along random edges; the loop is closed at a state that was met before."""
    visited = [0]
    word: list[Letter] = []
    density = rng.random()
    while True:
        transition = rng.choice(automaton.outgoing[visited[-1]])
        noise = frozenset(name for name in names if rng.random() < density)
        word.append((noise | transition.label.positive) - transition.label.negative)
        if transition.target in visited and rng.random() < 0.5:
            starts = [i for i, state in enumerate(visited) if state == transition.target]
            start = rng.choice(starts)
            return word[:start], word[start:]
        visited.append(transition.target)
