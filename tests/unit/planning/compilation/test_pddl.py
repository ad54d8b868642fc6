"""PDDL as text: another project's reader finds in it what was meant, whatever the names are."""

from __future__ import annotations

import re

import pytest
from compiled import action, history, problem, unit_costs
from hypothesis import given
from hypothesis import strategies as st

from companion.planning.compilation.classical import ClassicalProblem
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.compilation.pddl import RESERVED, identifiers, naming, to_pddl
from companion.planning.objective import Encoding

TASK = "G F at(A) & F G (at(A) | at(B)) & (!at(B)) U at(A)"


def classical(encoding: Encoding) -> ClassicalProblem:
    odd = action("at(A)", adds={"At(a)", "either"}, deletes={"at(A)"})
    asked = problem("HAB", unit_costs("HAB"), TASK, extra=(odd,))
    return encode(monolithic(asked, history(asked)) if encoding is Encoding.V1 else asked, encoding)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", Encoding)
def test_another_reader_finds_what_was_meant(encoding: Encoding) -> None:
    reader = pytest.importorskip("unified_planning.io").PDDLReader()
    meant = classical(encoding)
    names = naming(meant)
    read = reader.parse_problem_string(*to_pddl(meant))
    assert [f.name for f in read.fluents if f.name != "total-cost"] == [
        names.fluents[fluent].lower() for fluent in meant.fluents
    ]
    true = {str(f) for f, value in read.explicit_initial_values.items() if value.is_true()}
    assert true == {names.fluents[fluent].lower() for fluent in meant.init}
    costs = read.quality_metrics[0].costs
    assert len(read.actions) == len(meant.actions)
    for theirs, ours in zip(read.actions, meant.actions, strict=True):
        assert theirs.name == names.actions[ours.name].lower()
        assert costs[theirs].constant_value() == ours.cost
        conditional = sum(e.is_conditional() for e in theirs.effects)
        assert conditional == sum(len(e.adds) + len(e.deletes) for e in ours.conditional)
        assert len(theirs.effects) - conditional == len(ours.adds | ours.deletes)


@pytest.mark.parametrize("encoding", Encoding)
def test_requirements_are_what_the_encoding_needs(encoding: Encoding) -> None:
    domain, text = to_pddl(classical(encoding))
    assert (":conditional-effects" in domain) == (encoding is not Encoding.V5)
    assert (":negative-preconditions" in domain) == (encoding is not Encoding.V5)
    assert domain.startswith(f"; A temporal task as classical planning, encoding {encoding}:")
    assert "(:metric minimize (total-cost))" in text


@pytest.mark.parametrize("encoding", Encoding)
def test_text_depends_on_nothing_but_the_problem(encoding: Encoding) -> None:
    assert to_pddl(classical(encoding)) == to_pddl(classical(encoding))


@given(st.lists(st.text("aAbZ09()-_, .", max_size=6) | st.sampled_from(sorted(RESERVED))))
def test_identifiers_are_legal_and_no_two_alike(names: list[str]) -> None:
    words = identifiers(names)
    assert len({word.lower() for word in words}) == len(names)
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", word) for word in words)
    assert not RESERVED & {word.lower() for word in words}
