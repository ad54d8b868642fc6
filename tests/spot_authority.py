"""Spot decides exactly whether an automaton accepts what a formula says: an outside authority.

Spot (Duret-Lutz et al., From Spot 2.0 to Spot 2.10, CAV 2022) comes with the extra `test` where it
has a wheel: `spottl`, for Linux on x86-64. Elsewhere tests that need it are skipped; where it can
be installed they are not, and fail if it is missing.
"""

from __future__ import annotations

import platform
import re
import sys
from typing import Any

import pytest
from benches.spot_peer import spot_text

from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.formula import Formula
from companion.ltl.hoa import to_hoa
from companion.ltl.parser import parse

IS_INSTALLABLE = (
    sys.platform == "linux" and platform.machine() == "x86_64" and sys.version_info < (3, 14)
)
"""The environment marker of `spottl` in pyproject.toml."""

needs_spot = pytest.mark.skipif(
    not IS_INSTALLABLE, reason="Spot has wheels for Linux on x86-64 alone"
)


def spot() -> Any:
    """The library; it takes a tenth of a second to load."""
    import spot

    return spot


def is_exact(automaton: BuchiAutomaton, formula: Formula, among: str = "true") -> bool:
    """Whether an automaton accepts exactly the words that satisfy a formula.

    Args:
        among: a formula in Spot's syntax; only words that satisfy it count.
    """
    library = spot()
    given = library.automaton(to_hoa(automaton))
    right, wrong = (
        library.translate(f"{sign}({spot_text(formula)}) & ({among})") for sign in ("", "!")
    )
    return not (given.intersects(wrong) or right.intersects(library.complement(given)))


def at_most_one(names: frozenset[str]) -> str:
    """No letter has two of the propositions; in Spot's syntax."""
    pairs = [f'!("{a}" & "{b}")' for a in sorted(names) for b in sorted(names) if a < b]
    return f"G({' & '.join(pairs) or 'true'})"


def random_formulas(
    count: int, seed: int, *, propositions: int, size: int, **weights: int
) -> list[Formula]:
    """Formulas drawn by Spot.

    Args:
        size: nodes of a formula before Spot makes it trivially shorter.
        weights: of operators other than 1.
    """
    weights = {"M": 0, "xor": 0, "true": 0, "false": 0, **weights}
    drawn = spot().randltl(
        propositions,
        count,
        seed=seed,
        tree_size=size,
        simplify=0,
        ltl_priorities=",".join(f"{operator}={weight}" for operator, weight in weights.items()),
    )
    words = {"0": "false", "1": "true"}
    texts = [re.sub(r"\b[01]\b", lambda x: words[x.group()], f"{f:p}") for f in drawn]
    return [parse(text) for text in texts]
