"""Facts: one value for each predicate and arguments, and the proposition of its spelling."""

from __future__ import annotations

import copy
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.formula import atoms
from companion.ltl.parser import parse
from companion.mission.facts import Atom, Fact, at

NAMES = st.from_regex(r"[a-z][A-Za-z0-9_]{0,6}", fullmatch=True).filter(
    lambda name: name not in ("true", "false")
)
CALLS = st.tuples(NAMES, st.lists(NAMES, max_size=3).map(tuple))


@given(CALLS)
def test_a_fact_is_the_proposition_that_formulas_read(call: tuple[str, tuple[str, ...]]) -> None:
    fact = Fact(*call)
    (proposition,) = atoms(parse(f"F ({fact})"))
    assert proposition == fact
    assert Fact.parse(proposition) is fact
    assert (fact.predicate, fact.arguments) == call


@given(CALLS, CALLS)
def test_facts_are_equal_just_if_predicate_and_arguments_are(
    one: tuple[str, tuple[str, ...]], other: tuple[str, tuple[str, ...]]
) -> None:
    assert (Fact(*one) is Fact(*other)) == (one == other)
    assert (Fact(*one) == Fact(*other)) == (one == other)


def test_a_copy_is_the_same_fact() -> None:
    fact = at("A")
    assert copy.deepcopy(fact) is fact
    assert pickle.loads(pickle.dumps(fact)) is fact


def test_a_fact_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        at("A").predicate = "in"


def test_an_atom_becomes_a_fact_where_its_variables_are_bound() -> None:
    atom = Atom.parse("trans_ok(from, to)")
    assert atom.instantiate({"from": "A", "to": "B"}) is Fact("trans_ok", ("A", "B"))
    assert atom.instantiate({"from": "A"}).arguments == ("A", "to")
    assert str(atom) == "trans_ok(from, to)"
