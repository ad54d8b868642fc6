"""The number of labels a search may make; counted, not timed, so equal flights give equal plans."""

from __future__ import annotations

from companion.errors import SearchLimit
from companion.slices import spent

LABEL_US = 6.0
_COMPARISON_US = 0.05
ADVICE = "none was found, which is no proof; allow more time somewhere"
COMPARISONS = 100
"""This many comparisons count as one label."""


class LabelBudget:
    """The labels that a search may still make.

    Attributes:
        most: the number at the beginning.
        left: the number that is left.
    """

    def __init__(self, labels: int) -> None:
        self.most = self.left = labels

    def take(self, labels: int, comparisons: int = 0) -> None:
        """Counts new labels, and comparisons with others.

        Raises:
            SearchLimit: too few labels are left.
        """
        spent(LABEL_US * labels + _COMPARISON_US * comparisons)
        self.left -= labels + comparisons // COMPARISONS
        if self.left < 0:
            raise self.limit

    @property
    def limit(self) -> SearchLimit:
        """What is raised where it does not suffice."""
        return SearchLimit(f"{self.most:,} labels of plans with bounds in time", ADVICE)

    def share(self, part: int) -> LabelBudget:
        """A separate budget: a part of what is left."""
        return LabelBudget(max(0, self.left) // part)
