"""Compares plans of random missions with the reference planner of the tests."""

from __future__ import annotations

import random
import sys

from benches import ROOT
from companion.planning.builtin.search import Search
from companion.planning.objective import Objective

sys.path.append(str(ROOT / "tests"))  # missions and reference come from the tests


def share_of_best(missions: int) -> float:
    """The share of plans, for both objectives, that no lasso surpasses."""
    from random_missions import random_mission
    from reference_lassos import Reference, TooLarge

    best = plans = 0
    for seed in range(missions):
        asked, letters = random_mission(random.Random(seed))
        try:
            reference = Reference(asked, letters)
            lap_and_prefix, least = reference.best_lap_and_prefix(), reference.best_sum()
        except TooLarge:
            continue
        if lap_and_prefix is None:
            continue
        search = Search(asked.actions)
        *_, by_lap = search.solutions(asked)
        *_, by_sum = search.solutions(asked, Objective.SUM)
        lasso = by_lap.lasso
        best += (lasso.lap_cost_ms, lasso.prefix_cost_ms) == lap_and_prefix
        best += by_sum.cost_ms == least
        plans += 2
    return best / plans
