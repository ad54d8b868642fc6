"""What a component offers: rest, cycles or tours, and only what has to be met is met."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace

import numpy as np
import pytest
from problems import action, asking, problem, random_legs, unit_legs
from reference_search import laps

from companion.planning.builtin.loops import Loops, ShortestCycles, TargetTours, loops_of
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.product import Product
from companion.planning.builtin.restrictions import Restrictions
from companion.planning.builtin.shortest_paths import ShortestPaths
from companion.planning.domain import WAIT
from companion.planning.effort import BEFORE_FLIGHT, Effort
from companion.planning.lasso import Problem

ROUGH = replace(BEFORE_FLIGHT, dijkstra_steps=1, held_karp_additions=0)


def offered(asked: Problem, effort: Effort = BEFORE_FLIGHT) -> tuple[Product, Loops]:
    """The loops of the component with the most nodes that meets all marks: the patrol."""
    made = Product(asked, KnownActions(asked.actions), Restrictions())
    paths = ShortestPaths(made)
    reach = paths.costs_from(range(made.nodes)) < 1 << 49
    mutual = reach & reach.T
    components = [np.flatnonzero(row) for row in mutual]
    meeting = [c for c in components if _marks(made, c) == made.all_marks]
    return made, loops_of(made, max(meeting, key=len), paths, effort)


def _marks(made: Product, nodes: np.ndarray) -> int:
    return int(np.bitwise_or.reduce(np.array(made.marks)[nodes]))


@pytest.mark.parametrize(
    ("task", "kind"),
    [
        ("G !at(A)", ShortestCycles),
        ("F at(A)", ShortestCycles),
        ("G F at(A)", TargetTours),
        ("G F at(A) & G F at(B)", TargetTours),
        (
            "G (at(H) -> X at(A)) & G (at(A) -> X at(B)) & G (at(B) -> X at(H)) & G F at(B)",
            TargetTours,
        ),
    ],
)
def test_marks_decide_between_cycles_and_tours(task: str, kind: type[Loops]) -> None:
    _, loops = offered(problem("HAB", unit_legs("HAB"), task))
    assert isinstance(loops, kind)


def bottleneck_of_best(loops: Loops) -> int:
    """The bottleneck of a shortest loop."""
    best = int(loops.nodes[loops.costs(loops.nodes).argmin()])
    return loops.bottleneck_ms(loops.loop_from(best))


def test_a_mark_that_comes_with_another_one_is_left_out() -> None:
    """Whoever visits A again and again visits A or B again and again."""
    _, one = offered(problem("HAB", unit_legs("HAB"), "G F at(A)"))
    made, both = offered(problem("HAB", unit_legs("HAB"), "G F at(A) & G F (at(A) | at(B))"))
    assert made.all_marks == 0b11
    assert both.best_ms == one.best_ms == 100  # rest at A
    assert both.bottleneck_bound_ms == bottleneck_of_best(both) == 100
    assert both.batch_size == one.batch_size  # so there is no more to add up


TASKS = [
    "G !at(A)",
    "G F at(A) & G F at(B)",
    "G F (at(A) | at(B)) & G F (at(B) | at(C))",
    "G (at(A) -> X !at(A)) & G F at(A)",
]


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("seed", range(4))
def test_every_loop_costs_what_it_says_and_the_best_is_the_shortest_there_is(
    task: str, seed: int
) -> None:
    legs = random_legs(random.Random(seed), "HABC", is_symmetric=False)
    asked = problem("HABC", legs, task)
    made, loops = offered(asked)
    costs = loops.costs(loops.nodes)
    assert loops.best_ms == loops.bound_ms == costs.min() == min(laps(asked).values())
    every = set(laps(asked).values())
    for node, cost in zip(loops.nodes.tolist(), costs.tolist(), strict=True):
        loop = loops.loop_from(node)
        assert cost in every
        assert cost == sum(edge.cost_ms for edge in loop)
        assert loop[-1].end == node
        met = [made.marks[edge.end] for edge in loop]
        assert int(np.bitwise_or.reduce(met)) == made.all_marks


@pytest.mark.parametrize("task", TASKS)
def test_with_hardly_any_effort_a_loop_is_still_a_loop_and_nothing_is_proved(task: str) -> None:
    legs = random_legs(random.Random(7), "HABC", is_symmetric=False)
    asked = problem("HABC", legs, task)
    _, exact = offered(asked)
    made, rough = offered(asked, ROUGH)
    rough.improve()
    assert rough.is_final
    assert rough.bound_ms <= exact.best_ms <= rough.best_ms
    for node in rough.nodes.tolist():
        met = [made.marks[edge.end] for edge in rough.loop_from(node)]
        assert int(np.bitwise_or.reduce(met)) == made.all_marks


def test_rest_is_found_without_looking_for_cycles() -> None:
    """Where resting is as short as anything, no cycle can be shorter."""
    _, loops = offered(problem("HABC", unit_legs("HABC"), "G !gone"), ROUGH)
    assert loops.best_ms == loops.bound_ms == WAIT.cost_ms
    assert all(len(loops.loop_from(node)) == 1 for node in loops.nodes.tolist())


def test_where_rest_is_forbidden_a_cycle_is_found() -> None:
    """The lamp has to change at every step; the cheaper way back is a detour."""
    switches = [
        action("on", "!lamp", "lamp", 1.0),
        action("off", "lamp", "!lamp", 5.0),
        action("dim", "lamp & !dim", "dim & !lamp", 1.0),
        action("bright", "!lamp & dim", "lamp & !dim", 1.0),
    ]
    _, loops = offered(asking("G (lamp <-> X !lamp)", [*switches, WAIT], [()]))
    assert isinstance(loops, ShortestCycles)
    assert loops.best_ms == loops.bound_ms == 2000


def test_the_bottleneck_of_a_patrol_is_the_lap() -> None:
    _, loops = offered(problem("HABC", unit_legs("HABC"), "G F at(A) & G F at(B) & G F at(C)"))
    assert bottleneck_of_best(loops) == loops.bottleneck_bound_ms == loops.best_ms == 3000


def test_the_bottleneck_is_bounded_where_a_part_can_be_met_in_two_places() -> None:
    """A or B is met twice a lap and C once; without rest C is met again after a lap at best."""
    legs = {("A", "C"): 4.0, ("C", "B"): 4.0, ("B", "A"): 2.0, ("H", "A"): 1.0}
    asked = problem("HABC", legs, "G F (at(A) | at(B)) & G F at(C)")
    _, loops = offered(replace(asked, actions=asked.actions[:-1]))
    assert loops.best_ms == bottleneck_of_best(loops) == loops.bottleneck_bound_ms == 10_000


def test_of_too_many_targets_the_nearest_are_looked_at_and_nothing_is_proved() -> None:
    """A and C are near and far apart; B and D, of the same two parts, are far and close by."""
    places = "HABCD"
    legs = {pair: 10.0 for pair in itertools.permutations(places, 2)}
    legs |= {("H", "A"): 1.0, ("H", "C"): 1.0, ("B", "D"): 0.5, ("D", "B"): 0.5}
    asked = problem(places, legs, "G F (at(A) | at(B)) & G F (at(C) | at(D))")
    _, exact = offered(asked)
    _, nearest = offered(asked, replace(BEFORE_FLIGHT, dijkstra_steps=1))
    assert exact.bound_ms == exact.best_ms == 1000
    assert nearest.best_ms > 1000 >= max(nearest.bound_ms, nearest.bottleneck_bound_ms)


def test_of_too_many_nodes_the_cycles_of_the_nearest_are_looked_at_and_nothing_is_proved() -> None:
    legs = {pair: 10.0 for pair in itertools.permutations("HAB", 2)}
    asked = problem("HAB", legs | {("A", "B"): 1.0, ("B", "A"): 2.0}, "G !gone")
    asked = replace(asked, actions=asked.actions[:-1])
    _, loops = offered(asked, ROUGH)
    assert loops.bound_ms == 1000  # no cycle is shorter than an edge
    assert loops.best_ms == 20_000  # from H and back
    assert loops.costs(loops.nodes).min() == 3000


def test_the_bottleneck_is_bounded_by_the_nearest_two_places_of_a_part() -> None:
    """A and B are far apart, but who goes back and forth between A and C need not fly to B."""
    legs = {pair: 10.0 for pair in itertools.permutations("ABC", 2)}
    legs |= {("A", "C"): 1.0, ("C", "A"): 1.0}
    asked = problem("ABC", legs, "G F (at(A) | at(B)) & G F at(C)")
    _, loops = offered(replace(asked, actions=asked.actions[:-1]))
    assert bottleneck_of_best(loops) == loops.bottleneck_bound_ms == 2000
