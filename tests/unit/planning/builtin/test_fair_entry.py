"""In flight a loop is entered so that the oldest mark is the youngest, whatever it costs first."""

from __future__ import annotations

from dataclasses import replace
from itertools import accumulate, pairwise

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from synthetic import POSITIONS, mission

from companion.geometry import distance
from companion.mission.facts import Fact
from companion.planning.lasso import Lasso, Problem
from companion.planning.objective import Objective
from companion.planning.planner import Planner

SITES = "ABC"


def planner(cost: dict[tuple[str, str], float]) -> Planner:
    task = {site: f"G F at({site})" for site in SITES}
    return Planner(mission(task, places="HABC"), lambda origin, goal: cost[origin, goal])


def straight(origin: str, goal: str) -> float:
    return distance(POSITIONS[origin], POSITIONS[goal])


def waiting(patrol: Planner, since_s: dict[str, float]) -> Problem:
    problem, _ = patrol.initial_problem()
    since = tuple(round(1000 * since_s[conjunct.name]) for conjunct in problem.conjuncts)
    return replace(problem, waiting_since_ms=since)


def worst_age_ms(lasso: Lasso, since_s: dict[str, float]) -> int:
    """By the definition: the plan is flown, and each site's age read when it is reached first."""
    actions = (*lasso.prefix, *lasso.loop, *lasso.loop)
    first: dict[str, int] = {}
    for action, time_ms in zip(actions, accumulate(a.cost_ms for a in actions), strict=True):
        assert action.destination is not None
        first.setdefault(action.destination, time_ms)
    return max(first[site] - round(1000 * since_s[site]) for site in SITES)


def entries(problem: Problem, lasso: Lasso, patrol: Planner) -> list[Lasso]:
    """The same loop entered at each of its places, by the direct flight there."""
    moves = {(a.arguments[0], a.arguments[1]): a for a in problem.actions if a.skill == "move"}
    stops = [a.destination for a in lasso.loop]
    found = []
    for place, stop in enumerate(stops):
        loop = lasso.loop[place + 1 :] + lasso.loop[: place + 1]
        found.append(Lasso((moves["H", str(stop)],) if stop != "H" else (), loop))
    return found


COSTS = st.lists(st.integers(1, 30), min_size=12, max_size=12)


@drawn(100)
@given(COSTS, st.lists(st.integers(0, 90), min_size=3, max_size=3))
def test_no_entry_of_the_loop_has_a_lesser_worst_age(costs: list[int], met: list[int]) -> None:
    pairs = [(a, b) for a in "HABC" for b in "HABC" if a != b]
    table = _closed(dict(zip(pairs, map(float, costs), strict=True)))
    patrol = planner(table)
    since_s = dict(zip(SITES, map(float, met), strict=True))
    problem = waiting(patrol, since_s)
    plan = patrol.solver.replan(problem, [[] for _ in problem.conjuncts])
    unaware = patrol.solver.replan(
        replace(problem, waiting_since_ms=()), [[] for _ in problem.conjuncts]
    )
    assert plan is not None and unaware is not None
    assert plan.lap_cost_ms == unaware.lap_cost_ms, "the lap comes first"
    ranked = [(worst_age_ms(e, since_s), e.prefix_cost_ms) for e in entries(problem, plan, patrol)]
    assert (worst_age_ms(plan, since_s), plan.prefix_cost_ms) <= min(ranked)


def _closed(table: dict[tuple[str, str], float]) -> dict[tuple[str, str], float]:
    """With the way round where that is shorter: so a direct flight is a shortest path."""
    for via in "HABC":
        for a, b in table:
            if via not in (a, b):
                table[a, b] = min(table[a, b], table[a, via] + table[via, b])
    return table


def test_before_a_flight_the_shortest_prefix_counts() -> None:
    cost = {(a, b): straight(a, b) for a in "HABC" for b in "HABC" if a != b}
    assert planner(cost).plan().prefix_cost_s == min(straight("H", site) for site in SITES)


def test_what_waits_longest_is_flown_to_first() -> None:
    cost = {(a, b): straight(a, b) for a in "HABC" for b in "HABC" if a != b}
    patrol = planner(cost)
    for oldest in SITES:
        problem = waiting(patrol, {site: 0.0 if site == oldest else 100.0 for site in SITES})
        plan = patrol.solver.replan(problem, [[] for _ in problem.conjuncts])
        assert plan is not None and plan.prefix[0].destination == oldest


def test_on_its_loop_the_vehicle_goes_on_along_it() -> None:
    """From each place of the loop, after any number of laps, the rest of the plan is planned."""
    cost = {(a, b): straight(a, b) for a in "HABC" for b in "HABC" if a != b}
    patrol = planner(cost)
    lasso = patrol.plan().lasso
    now_s, met = 0.0, dict.fromkeys(SITES, 0.0)
    for here, following in pairwise([*lasso.prefix, *lasso.loop * 3]):
        now_s += here.cost_ms / 1000
        met[str(here.destination)] = now_s
        facts = frozenset(f for f in waiting(patrol, met).facts if f.predicate != "at")
        here_now = Fact.parse(f"at({here.destination})")
        problem = replace(waiting(patrol, met), facts=facts | {here_now})
        plan = patrol.solver.replan(problem, [[] for _ in problem.conjuncts])
        assert plan is not None and plan.names(1) == [following.name]


def test_a_mark_that_is_met_on_the_way_to_the_loop_is_not_old() -> None:
    """A prefix of two flights passes A; what counts is when A is met there."""
    cost = {(a, b): 50.0 for a in "HABC" for b in "HABC" if a != b}
    cost.update({("H", "A"): 1.0, ("A", "B"): 1.0, ("B", "C"): 1.0, ("C", "A"): 1.0})
    patrol = planner(cost)
    since_s = {"A": 5.0, "B": 0.0, "C": 5.0}
    problem = waiting(patrol, since_s)
    plan = patrol.solver.replan(problem, [[] for _ in problem.conjuncts])
    assert plan is not None
    assert worst_age_ms(plan, since_s) == 2000
    assert plan.names(3) == ["move(H, A)", "move(A, B)", "move(B, C)"]


@pytest.mark.parametrize("objective", ["sum", "bottleneck"])
def test_other_objectives_know_no_ages(objective: str) -> None:
    cost = {(a, b): straight(a, b) for a in "HABC" for b in "HABC" if a != b}
    patrol = planner(cost)
    problem = waiting(patrol, {"A": 0.0, "B": 100.0, "C": 100.0})
    plain = replace(problem, waiting_since_ms=())
    histories = [[] for _ in problem.conjuncts]  # type: ignore[var-annotated]
    told = [patrol.solver.solve(p, histories, Objective(objective)).lasso for p in (problem, plain)]
    assert told[0] == told[1]
