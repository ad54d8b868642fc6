"""Formula progression: the rest of a word satisfies what is left if the word satisfies all."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.parser import parse
from companion.ltl.progression import progressed
from companion.ltl.semantics import holds

FORMULAS = (
    "G (p -> F q)",
    "G F p & (q U p)",
    "F (p & F q)",
    "(p W q) | X !p",
    "(p R q) <-> F G p",
    "G (p -> X (q | F G p))",
)
letters = st.frozensets(st.sampled_from(["p", "q"]))


@given(
    st.sampled_from(FORMULAS),
    st.lists(letters, min_size=1, max_size=5),
    st.lists(letters, min_size=1, max_size=3),
)
def test_what_is_left_says_of_the_rest_what_all_says_of_the_whole(
    text: str, prefix: list[frozenset[str]], loop: list[frozenset[str]]
) -> None:
    formula = parse(text)
    truth = holds(formula, prefix, loop)
    for number, letter in enumerate(prefix, 1):
        formula = progressed(formula, letter)
        assert holds(formula, prefix[number:], loop) == truth
