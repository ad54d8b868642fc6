"""What other conjuncts imply is left out, and the lap of a patrol stays the shortest."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from problems import Legs, asking, histories, problem, random_legs, unit_legs

from companion.ltl.semantics import accepts
from companion.planning.builtin.fact_bits import FactBits
from companion.planning.builtin.implied import is_implied
from companion.planning.builtin.masked_automaton import RestrictedConjunct
from companion.planning.builtin.restrictions import Restrictions
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import IN_FLIGHT
from companion.planning.lasso import Problem, Solution

PATROL = "G F at(A) & G F at(B) & G F at(C)"
IMPLIED = [
    "G (at(A) -> F at(B))",
    "G (at(A) -> X F at(B))",
    "G (at(A) -> F (at(B) & F at(C)))",
    "G (at(A) -> F at(B) & F at(C))",
    "F at(A)",
    "F (at(A) & F (at(B) & F at(C)))",
    "G F at(A) -> G F at(B)",
    "F at(B) | G at(H)",
]
NOT_IMPLIED = [
    "G (at(A) -> X at(B))",
    "G (at(A) -> X (!at(A) U at(B)))",
    "F (at(A) & X at(B))",
    "F G !at(H)",
    "(!at(B)) U at(A)",
    "G (at(A) -> F at(H))",
]


def read(asked: Problem) -> list[str]:
    """The formulas whose automata are in the product."""
    graph = Search().product(asked).to_networkx()
    return sorted(graph.graph["conjuncts"])


@pytest.mark.parametrize("line", IMPLIED)
def test_a_line_that_the_patrol_implies_is_not_read(line: str) -> None:
    legs = unit_legs("HABC")
    with_line = problem("HABC", legs, f"{PATROL} & ({line})")
    assert read(with_line) == read(problem("HABC", legs, PATROL))


@pytest.mark.parametrize("line", NOT_IMPLIED)
def test_a_line_that_says_something_is_read(line: str) -> None:
    asked = problem("HABC", unit_legs("HABC"), f"{PATROL} & ({line})")
    assert len(read(asked)) == len(asked.conjuncts)


def test_of_lines_that_imply_each_other_one_is_read() -> None:
    asked = problem("HAB", unit_legs("HAB"), "F (at(A) & F at(B)) & F (at(A) & (F at(B) | false))")
    assert len(asked.conjuncts) == 2 and len(read(asked)) == 1


def test_what_is_implied_depends_on_what_was_read() -> None:
    """The wait for B has no end before C; only once B has come it says nothing more."""
    legs, task = unit_legs("HABC"), f"{PATROL} & ((!at(C)) U at(B))"
    moves = problem("HABC", legs, task).actions
    begun = asking(task, moves, [{"at(H)"}, {"at(A)"}])
    done = asking(task, moves, [{"at(H)"}, {"at(B)"}])
    assert (len(read(begun)), len(read(done))) == (4, 3)


def lap(sites: int, legs: Legs, lines: list[str]) -> tuple[Problem, Solution]:
    places = [f"s{i}" for i in range(sites)]
    task = " & ".join([*(f"G F at({place})" for place in places), *lines])
    asked = problem(["H", *places], legs, task)
    *_, found = Search(asked.actions).solutions(asked)
    return asked, found


@pytest.mark.parametrize(
    "seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 12))]
)
def test_implied_lines_cost_nothing(seed: int) -> None:
    chance = random.Random(seed)
    sites = 5 + seed % 6
    places = [f"s{i}" for i in range(sites)]
    legs = random_legs(chance, ["H", *places], is_symmetric=seed % 2 == 0)
    lines = []
    for line in chance.sample(IMPLIED[:6], 1 + seed % 3):
        for letter, place in zip("ABC", chance.sample(places, 3), strict=True):
            line = line.replace(f"at({letter})", f"at({place})")
        lines.append(f"({line})")
    _, best = lap(sites, legs, [])
    asked, found = lap(sites, legs, lines)
    assert (found.cost_ms, found.bound_ms) == (best.cost_ms, best.bound_ms)
    assert found.is_optimal and best.is_optimal
    assert fault(asked, found.lasso, histories(asked)) is None  # of all lines


def test_in_flight_they_cost_nothing_either() -> None:
    places = [f"s{i}" for i in range(12)]
    legs = random_legs(random.Random(1), ["H", *places])
    task = " & ".join(f"G F at({place})" for place in places)
    lines = "G (at(s0) -> F (at(s1) & F at(s2))) & G (at(s3) -> X F at(s4))"
    found = [
        next(Search().solutions(problem(["H", *places], legs, asked), effort=IN_FLIGHT))
        for asked in (task, f"{task} & {lines}")
    ]
    assert found[0].cost_ms == found[1].cost_ms and found[1].is_optimal


LINES = [*IMPLIED, *NOT_IMPLIED, *PATROL.split(" & "), "G F (at(A) & X at(B))", "F G at(A)"]
LETTERS = ["at(H)", "at(A)", "at(B)", "at(C)"]


@pytest.mark.slow
@drawn(150)
@given(
    st.lists(st.sampled_from(LINES), min_size=2, max_size=4, unique=True),
    st.lists(st.sampled_from(LETTERS), max_size=3),
    st.lists(st.sampled_from(LETTERS), min_size=1, max_size=4),
    st.lists(st.sampled_from(LETTERS), max_size=3),
)
def test_no_word_that_the_others_accept_is_rejected(
    lines: list[str], prefix: list[str], loop: list[str], history: list[str]
) -> None:
    """Soundness: a line that is found to be implied holds wherever the others do."""
    bits, restrictions = FactBits(), Restrictions()
    letters = [bits.bit(name) for name in LETTERS]
    task = " & ".join(f"({line})" for line in lines)
    asked = asking(task, (), [{name} for name in (*history, "at(H)")])
    parts = [
        RestrictedConjunct.of(conjunct, restrictions.of(conjunct, lambda name: None), states)
        for conjunct, states in zip(asked.conjuncts, asked.automaton_states, strict=True)
    ]
    part, *others = parts
    if not others or not is_implied(part, others, letters, bits):
        return
    word = [frozenset({name}) for name in prefix], [frozenset({name}) for name in loop]
    held = [
        accepts(replace(c.automaton, initial=states), *word)
        for c, states in zip(asked.conjuncts, asked.automaton_states, strict=True)
    ]
    assert held[0] or not all(held[1:])


def test_states_of_many_automata_together_are_not_listed() -> None:
    """Forty automata, each in one of 200 states, are in one of 200 ** 40 together."""
    bits = FactBits()
    asked = problem("HABC", unit_legs("HABC"), "F at(B) & G F at(A)")
    other, part = (
        RestrictedConjunct.of(conjunct, Restrictions().of(conjunct, lambda name: None), states)
        for conjunct, states in zip(asked.conjuncts, asked.automaton_states, strict=True)
    )
    letters = [bits.bit(name) for name in LETTERS]
    assert not is_implied(part, [replace(other, states=other.states * 200)] * 40, letters, bits)
