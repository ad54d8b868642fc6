"""How many labels a search may make: counted, not timed, so that equal flights plan alike."""

from __future__ import annotations

from companion.errors import SearchLimit
from companion.slices import spent

LABEL_US = 6.0
_COMPARISON_US = 0.05
ADVICE = "none was found, which is no proof; allow more time somewhere"
COMPARISONS = 100
"""So many are counted as a label."""


class LabelBudget:
    """Labels that are left to a search.

    Attributes:
        most: how many there were.
        left: how many there are.
    """

    def __init__(self, labels: int) -> None:
        self.most = self.left = labels

    def take(self, labels: int, comparisons: int = 0) -> None:
        """Labels are made, and others are compared with one.

        Raises:
            SearchLimit: there are not so many left.
        """
        spent(LABEL_US * labels + _COMPARISON_US * comparisons)
        self.left -= labels + comparisons // COMPARISONS
        if self.left < 0:
            limit = f"{self.most:,} labels of plans with bounds in time"
            raise SearchLimit(limit, ADVICE)

    def share(self, part: int) -> LabelBudget:
        """A budget of its own: one part of what is left."""
        return LabelBudget(max(0, self.left) // part)
