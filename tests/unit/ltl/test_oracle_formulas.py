"""Automata of published formulas accept what the oracle says, in every form.

For each formula both verdicts are met, so neither an automaton that accepts too much nor one
that accepts too little goes unnoticed (`test_oracle.py` shows how likely that is).
"""

from __future__ import annotations

import csv
import random
from pathlib import Path

import pytest
from oracle import accepted, satisfying, words_for

from companion.ltl.formula import negate
from companion.ltl.parser import parse
from companion.ltl.translate import state_based, translate

pytestmark = pytest.mark.slow

TABLE = Path(__file__).parents[2] / "data" / "formulas.tsv"

VALID = {"sb-11", "sb-12"}
"""Formulas that every word satisfies."""

LARGE = {"pickup-deliver-4", "pickup-deliver-5"}
"""Formulas whose automaton takes more than a few seconds."""


def published() -> list[object]:
    """Name and text of every formula in the file, the paper's for up to four sites."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.reader(stream, delimiter="\t") if not row[0].startswith("#")]
    return [
        pytest.param(name, text, id=name, marks=[pytest.mark.long] if name in LARGE else [])
        for group, name, text, *_ in rows
        if group != "paper" or int(name.removeprefix("paper-")) <= 4
    ]


@pytest.mark.parametrize(("name", "text"), published())
def test_the_automata_accept_what_satisfies_the_formula(name: str, text: str) -> None:
    formula = parse(text)
    assert parse(str(formula)) is formula
    automaton, opposite = translate(formula), translate(negate(formula))
    sample = words_for(formula, [automaton, opposite], random.Random(name))
    satisfied = satisfying(formula, sample)
    violated = sample.everyone ^ satisfied
    assert satisfied.bit_count() >= 20
    assert violated.bit_count() >= 20 or (name in VALID and not violated)
    by_states = state_based(automaton)
    assert by_states.has_state_acceptance
    for form in (automaton, by_states):
        assert accepted(form, sample) == satisfied
    assert accepted(opposite, sample) == violated
