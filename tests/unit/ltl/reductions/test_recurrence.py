"""Automata of G F a that start again accept G F a, whether or not they guess where `a` begins."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from drawn_graphs import ALPHABET, by_letters
from oracle import Sample, accepted, satisfying, small_words

from companion.ltl.budget import Budget
from companion.ltl.formula import negation_normal_form
from companion.ltl.graph import (
    LabelledGraph,
    automaton_of,
    graph_of,
    is_deterministic,
    with_cubes,
)
from companion.ltl.labels import LetterSet
from companion.ltl.parser import parse
from companion.ltl.reductions.recurrence import restarted
from companion.ltl.reductions.strategy import reduced
from companion.ltl.tableau import unfolded_by_letters
from companion.ltl.translate import MAX_STATES, translate

SAMPLE = Sample(small_words("ab", 600))


def unfolded(text: str) -> LabelledGraph[LetterSet]:
    formula = negation_normal_form(parse(text))
    graph = unfolded_by_letters(formula, ALPHABET, MAX_STATES, Budget())
    return reduced(graph, Budget())


def translated(text: str) -> LabelledGraph[LetterSet]:
    return by_letters(graph_of(translate(parse(text)), ALPHABET))


@pytest.mark.parametrize("overlapping", [False, True])
@pytest.mark.parametrize("text", ["a & X b", "a & X X !a", "a U (b & X a)", "X(a & X b) | b & X b"])
@pytest.mark.parametrize("made", [translated, unfolded])
def test_it_accepts_the_recurrence(
    text: str, made: Callable[[str], LabelledGraph[LetterSet]], overlapping: bool
) -> None:
    graph = restarted(made(f"F({text})"), ALPHABET.every, overlapping)
    assert graph is not None
    found = automaton_of(with_cubes(graph, ALPHABET, Budget()), ALPHABET, "")
    assert accepted(found, SAMPLE) == satisfying(parse(f"G F({text})"), SAMPLE)


def test_some_of_them_guess() -> None:
    assert not is_deterministic(unfolded("F(a & X b)"))
    assert is_deterministic(translated("F(a & X b)"))


@pytest.mark.parametrize("text", ["F G a", "F a & G b", "G a", "G F a", "true", "false"])
def test_what_does_not_end_is_not_restarted(text: str) -> None:
    assert restarted(translated(text), ALPHABET.every, False) is None
