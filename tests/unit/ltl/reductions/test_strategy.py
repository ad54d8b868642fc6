"""Every reduction keeps the language, on graphs drawn at random."""

from __future__ import annotations

import random

import pytest
from drawn_graphs import ALPHABET, by_letters, graphs_of_cubes
from hypothesis import given
from oracle import Sample, accepted, random_words, small_words

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledGraph, automaton_of, graph_of, with_cubes
from companion.ltl.intersection import intersection
from companion.ltl.labels import Cube, LetterSet
from companion.ltl.parser import parse
from companion.ltl.reductions.degeneralisation import degeneralised
from companion.ltl.reductions.quotient import merged_cubes
from companion.ltl.reductions.sharpening import sharpened
from companion.ltl.reductions.strategy import (
    reduced,
    reduced_by_states,
    reduced_cubes,
    reduced_cubes_by_states,
)
from companion.ltl.reductions.trimming import Departures, trimmed, trimmed_by_states
from companion.ltl.translate import translate

SAMPLE = Sample([*small_words("ab", 200), *random_words("ab", random.Random(8), 100)])


def language(graph: LabelledGraph[Cube]) -> int:
    """The words of the sample (bits) that a graph accepts."""
    return accepted(automaton_of(graph, ALPHABET, ""), SAMPLE)


def as_cubes(graph: LabelledGraph[LetterSet]) -> LabelledGraph[Cube]:
    return with_cubes(graph, ALPHABET, Budget())


@given(graphs_of_cubes())
def test_graphs_with_cubes(graph: LabelledGraph[Cube]) -> None:
    words = language(graph)
    assert language(trimmed(graph)) == words
    for technique in (merged_cubes, sharpened, reduced_cubes):
        assert language(technique(graph, Budget())) == words, technique
    assert reduced_cubes(graph, Budget()).size[0] <= graph.size[0]


@given(graphs_of_cubes())
def test_graphs_with_sets_of_letters(graph: LabelledGraph[Cube]) -> None:
    words = language(graph)
    assert language(as_cubes(by_letters(graph))) == words
    for departures in Departures:
        assert language(as_cubes(trimmed(by_letters(graph), departures))) == words
    smaller = reduced(by_letters(graph), Budget())
    assert language(as_cubes(smaller)) == words
    assert smaller.size[0] <= graph.size[0]


@pytest.mark.slow
@given(graphs_of_cubes())
def test_graphs_with_marks_on_states(graph: LabelledGraph[Cube]) -> None:
    words = language(graph)
    by_cubes = degeneralised(graph, Budget())
    candidates = degeneralised(by_letters(graph), Budget())
    several = [*by_cubes, *map(as_cubes, candidates)]
    several += [trimmed_by_states(by_cubes[0], side) for side in (False, True)]
    several += [
        reduced_cubes_by_states(by_cubes[0], Budget()),
        as_cubes(reduced_by_states(candidates, Budget())),
    ]
    for found in several:
        assert language(found) == words
        assert automaton_of(found, ALPHABET, "").has_state_acceptance


@given(graphs_of_cubes(3), graphs_of_cubes(3))
def test_an_intersection(one: LabelledGraph[Cube], other: LabelledGraph[Cube]) -> None:
    both = intersection(by_letters(one), by_letters(other), Budget())
    assert language(as_cubes(both)) == language(one) & language(other)


@given(graphs_of_cubes(3))
def test_a_suspended_intersection(graph: LabelledGraph[Cube]) -> None:
    """G F(a & X b), which no finite prefix matters to, is read where the other one can accept."""
    recurring = graph_of(translate(parse("G F(a & X b)")), ALPHABET)
    both = intersection(by_letters(graph), by_letters(recurring), Budget(), suspending=True)
    assert language(as_cubes(both)) == language(graph) & language(recurring)
