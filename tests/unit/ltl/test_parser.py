"""Texts that are too long are refused, deep ones are not; a formula is one object."""

from __future__ import annotations

import pytest

from companion.errors import FormulaError
from companion.ltl.formula import subformulas
from companion.ltl.parser import MAX_ARGUMENTS, MAX_CHARACTERS, parse

DEPTH = 2_000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "nodes"),
    [
        ("X " * DEPTH + "a", DEPTH + 1),
        ("!" * DEPTH + "a", DEPTH + 1),
        ("(" * DEPTH + "a" + ")" * DEPTH, 1),
        ("a U " * DEPTH + "b", DEPTH + 2),
        ("(" * DEPTH + "a" + " U b)" * DEPTH, DEPTH + 2),
        ("a <-> " * DEPTH + "b", DEPTH + 2),
        ("a & (b | " * DEPTH + "c" + ")" * DEPTH, 2 * DEPTH + 3),
        (" & ".join(f"F p{i}" for i in range(DEPTH)), 2 * DEPTH + 1),
        (f"visit({', '.join(f'p{i}' for i in range(DEPTH))})", 2 * DEPTH + 1),
    ],
)
def test_what_is_written_is_read_back(text: str, nodes: int) -> None:
    formula = parse(text)
    assert sum(1 for _ in subformulas(formula)) == nodes
    assert parse(str(formula)) is formula


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("F " * (MAX_CHARACTERS // 2) + "a", "at most 250,000 characters, this one has 250,001"),
        (f"visit(A{', B' * (MAX_ARGUMENTS + 1)})", "at most 10,000 arguments, this one has 10,001"),
    ],
)
def test_a_text_that_is_too_long(text: str, message: str) -> None:
    with pytest.raises(FormulaError, match=message) as refused:
        parse(text)
    assert len(str(refused.value)) < 300


def test_a_mistake_far_down_is_found() -> None:
    text = "(" * DEPTH + "a" + ")" * (DEPTH - 1)
    with pytest.raises(FormulaError, match="ends too early") as refused:
        parse(text)
    assert refused.value.offset == len(text)
