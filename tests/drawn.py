"""How many examples a property draws.

The same ones are drawn in each run, so what a run finds another would have found: the broad look is
that of EXPLORE=1, which draws new ones, and all of them.
"""

from __future__ import annotations

import os

from hypothesis import settings

EXPLORES = "EXPLORE" in os.environ
SHARE = 0.4
"""Of the examples, in a run that does not explore."""
FEW = 10


def drawn(examples: int) -> settings:
    """A property's settings: so many examples, or a share of them."""
    return settings(max_examples=number(examples))


def number(examples: int) -> int:
    """As many, or a share of them; few are drawn in every run."""
    return examples if EXPLORES else max(min(examples, FEW), round(SHARE * examples))
