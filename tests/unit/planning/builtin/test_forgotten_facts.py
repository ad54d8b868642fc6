"""Facts that stay once made: goals for them are planned as many as there are, and at their best."""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence
from dataclasses import replace

import pytest
from problems import action, asking, find_lasso, histories, problem, random_legs
from reference_search import best_lap_and_prefix

from companion.planning.builtin import search
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import WAIT, Action
from companion.planning.effort import IN_FLIGHT, Effort
from companion.planning.lasso import Problem, Solution


def shots(places: Sequence[str]) -> list[Action]:
    """A photo of each place, from there."""
    return [action(f"shoot({p})", f"at({p})", f"shot({p})") for p in places]


def seen(places: Sequence[str], more: str = "") -> str:
    return " & ".join(f"F shot({p})" for p in places) + more


def on_the_clock(asked: Problem) -> Problem:
    """The same with clocks that never run: only its lap counts, and then its prefix."""
    return replace(asked, clocks_ms=(None,) * len(asked.conjuncts))


def best(asked: Problem, effort: Effort = IN_FLIGHT) -> Solution:
    *_, solution = Search(asked.actions).solutions(asked, effort=effort)
    assert fault(asked, solution.lasso, histories(asked)) is None
    return solution


@pytest.mark.parametrize("more", ["", " & F G at(H)", " & G F at(A) & G F at(B)"])
@pytest.mark.parametrize("seed", range(4))
def test_the_plan_is_as_good_as_in_a_world_that_remembers(
    seed: int, more: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(search, "MAX_EDGES_WITH_GOALS", 0)  # the product that forgets, alone
    legs = random_legs(random.Random(seed), "HABCD", is_symmetric=False)
    asked = problem("HABCD", legs, seen("ABCD", more), shots("ABCD"))
    found = best(asked)
    reference = best_lap_and_prefix(asked)
    assert reference is not None
    assert found.lasso.lap_cost_ms == reference[0]
    if found.has_best_prefix:
        assert found.lasso.prefix_cost_ms == reference[1]
    assert found.has_best_prefix == found.lasso.ends_at_rest


@pytest.mark.parametrize("photos", [pytest.param(12, marks=pytest.mark.long), 40])
def test_a_photo_of_each_of_many_trees_is_planned_with_the_effort_of_a_flight(photos: int) -> None:
    trees = [f"t{i}" for i in range(photos)]
    legs = random_legs(random.Random(photos), ["H", *trees])
    asked = problem(["H", *trees], legs, seen(trees, " & F G at(H)"), shots(trees))
    lasso = best(asked).lasso
    assert sum(a.skill == "shoot" for a in lasso.prefix) == photos
    product = Search(asked.actions).product(asked, IN_FLIGHT)
    assert product.nodes < 5 * photos  # not twice as many with each photo


@pytest.mark.parametrize("task", ["F shot(t0)", "G F at(t0) & G F at(t1)", "F (shot(t0) & at(H))"])
@pytest.mark.parametrize("effect", ["shot({})", "shot({0}) & logged({0})"])
def test_photos_that_no_line_asks_for_are_not_in_the_states(task: str, effect: str) -> None:
    trees = [f"t{i}" for i in range(14)]
    legs = random_legs(random.Random(14), ["H", *trees])
    photos = [action(f"shoot({p})", f"at({p})", effect.format(p)) for p in trees]
    asked = problem(["H", *trees], legs, task, photos)
    assert best(asked).is_optimal
    assert Search(asked.actions).product(asked, IN_FLIGHT).nodes < 10 * len(trees)


@pytest.mark.parametrize("more", ["", " & G (alarm -> F brought)", " & (brought -> F noted)"])
def test_a_loop_may_make_what_nothing_reads_in_its_first_lap_alone(more: str) -> None:
    """Nor does a line read it that asks for nothing, as long as its event does not come."""
    load = action("load", "at(A) & !loaded", "loaded & noted")
    unload = action("unload", "at(B) & loaded", "!loaded & brought")
    legs = random_legs(random.Random(5), "HAB")
    asked = problem("HAB", legs, "G F loaded & G F !loaded" + more, [load, unload])
    found = best(asked)
    reference = best_lap_and_prefix(asked)  # its loops leave all facts as they were
    assert reference is not None
    assert found.lasso.lap_cost_ms == reference[0]
    assert found.lasso.prefix_cost_ms < reference[1]
    assert {load, unload} <= {*found.loop}


def test_what_was_shot_before_is_not_shot_again() -> None:
    trees = "ABCDEF"
    legs = random_legs(random.Random(1), "H" + trees)
    moves = problem("H" + trees, legs, "F at(A)").actions
    history = [["at(A)"], ["at(A)", "shot(A)"]]
    lasso = best(asking(seen(trees), [*moves, *shots(trees)], history)).lasso
    assert sorted(a.name for a in lasso.prefix if a.skill == "shoot") == [
        f"shoot({p})" for p in trees[1:]
    ]


@pytest.mark.parametrize(
    ("task", "extra"),
    [
        (seen("ABCD", " & G (shot(A) -> X at(B))"), []),
        (seen("ABCD", " & F (shot(A) & at(C))"), []),
        (seen("ABCD", " & F sent"), [action("send", "shot(A) & shot(B)", "sent")]),
        (seen("ABCD", " & F sent"), [action("send", "at(A) & !shot(B)", "sent")]),
        (seen("ABCD"), [action("erase", "at(B)", "!shot(A)", 0.1)]),
        (seen("ABCD", " & F s"), [action("send", "at(D)", "", conditional=[("shot(B)", "s")])]),
    ],
)
def test_what_something_else_reads_is_remembered(task: str, extra: list[Action]) -> None:
    legs = random_legs(random.Random(3), "HABCD")
    asked = problem("HABCD", legs, task, [*shots("ABCD"), *extra])
    found = best(asked).lasso
    assert (found.lap_cost_ms, found.prefix_cost_ms) == best_lap_and_prefix(asked)


def test_one_photo_may_show_several_trees_and_a_tree_may_be_passed_twice() -> None:
    """A pair that is seen from between is seen at once; the way back leads over what was seen."""
    line = dict.fromkeys(itertools.pairwise("HABCD"), 1.0)
    line |= {(b, a): 1.0 for a, b in line}
    extra = [*shots("ABCD"), action("pair(C)", "at(C)", "shot(C) & shot(D)")]
    asked = problem("HABCD", line, seen("ABCD", " & F G at(H)"), extra)
    found = best(asked).lasso
    assert found.prefix_cost_ms == 9000
    assert WAIT in found.loop


TASKS = (
    "G F f0",
    "F f0 & G F at(A)",
    "G F at(A) & G F at(B)",
    "F (f0 & X f1)",
    "G (f1 -> F f0) & G F at(B)",
    "G !f2 & F f1",
    "X X X at(A) & F G f0",
)
FACTS = [f"f{i}" for i in range(5)]


def drawn_literals(chance: random.Random, most: int) -> str:
    named = chance.sample(FACTS, chance.randint(0, most))
    return " & ".join(chance.choice(("", "!")) + name for name in named)


def drawn_actions(chance: random.Random) -> list[Action]:
    """Some read and change facts at random, some by effects with a condition."""
    drawn = []
    for number in range(chance.randint(2, 5)):
        conditional = []
        if chance.random() < 0.3 and (effect := drawn_literals(chance, 1)):
            conditional.append((drawn_literals(chance, 1), effect))
        when, effect = drawn_literals(chance, 2), drawn_literals(chance, 2)
        where = chance.choice(("", "at(A)", "at(B)"))
        when = " & ".join(part for part in (where, when) if part)
        drawn.append(action(f"do{number}", when, effect, chance.choice((0.5, 2.0)), conditional))
    return drawn


@pytest.mark.parametrize("is_timed", [False, True])
@pytest.mark.parametrize(
    "seed", [*range(50), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(50, 150))]
)
def test_nothing_is_lost_with_actions_on_which_nothing_depends(seed: int, is_timed: bool) -> None:
    """The reference has all actions, and loops that leave all facts as they were."""
    chance = random.Random(seed)
    legs = random_legs(chance, "HAB")
    asked = problem("HAB", legs, chance.choice(TASKS), drawn_actions(chance))
    reference = best_lap_and_prefix(asked)
    found = find_lasso(on_the_clock(asked) if is_timed else asked)
    assert (found is None) == (reference is None)
    if found is not None and reference is not None:
        assert fault(asked, found, histories(asked)) is None
        assert found.lap_cost_ms == reference[0]
        assert found.prefix_cost_ms <= reference[1]


def test_what_is_made_of_photos_that_no_line_asks_for_is_not_in_the_states() -> None:
    trees = [f"t{i}" for i in range(14)]
    legs = random_legs(random.Random(14), ["H", *trees])
    sent = [action(f"send({p})", f"at({p}) & shot({p})", f"sent({p})") for p in trees]
    lamps = [action("light", "!lit", "lit"), action("darken", "lit", "!lit")]
    asked = problem(["H", *trees], legs, "G F at(t0) & G F at(t1)", [*shots(trees), *sent, *lamps])
    assert best(asked).is_optimal
    assert Search(asked.actions).product(asked, IN_FLIGHT).nodes < 10 * len(trees)


@pytest.mark.parametrize("task", ["G F at(t0)", "F G at(H)", "G F shot(t0) & G (lit -> F at(t1))"])
def test_what_takes_away_only_what_lines_want_is_not_done(task: str) -> None:
    """Photos that a line demands, and that could be sent, stay: each is in no more states."""
    trees = [f"t{i}" for i in range(4)]
    legs = random_legs(random.Random(4), ["H", *trees])
    sent = [action(f"send({p})", f"at(H) & shot({p})", f"!shot({p})") for p in trees]
    demanded = f"{seen(trees)} & {task}"
    asked, kept = (
        on_the_clock(problem(["H", *trees], legs, demanded, extra))
        for extra in ([*shots(trees), *sent], shots(trees))
    )
    found, without = (Search(each.actions).product(each, IN_FLIGHT) for each in (asked, kept))
    assert (found.nodes, len(found.ends)) == (without.nodes, len(without.ends))
    assert best(asked).lasso == best(kept).lasso


def test_what_a_line_wants_away_is_taken_away() -> None:
    legs = random_legs(random.Random(4), "HA")
    sent = action("send(A)", "at(H) & shot(A)", "!shot(A)")
    asked = on_the_clock(problem("HA", legs, "G F shot(A) & G F !shot(A)", [*shots("A"), sent]))
    assert sent in best(asked).lasso.loop
