"""The tree of a lasso: its shape for each kind of skill, and what its nodes promise."""

from __future__ import annotations

from fakes import FakeVehicle
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter, Repeat, Retry
from rig import Rig
from synthetic import command, mission, move

from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.leaves import Rest, SendCommand, UpdateParam
from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.replanning.assumptions import Assumptions
from companion.planning.lasso import Lasso


def tree_of(rig: Rig, prefix: list[str], loop: list[str]) -> Behaviour:
    known = {a.name: a for a in rig.planner.actions.model.actions}
    lasso = Lasso(tuple(known[n] for n in prefix), tuple(known[n] for n in loop))
    return build(rig.flight, lasso, Assumptions(rig.planner, rig.flight))


def plan_of(root: Behaviour) -> Behaviour:
    return root.children[1]


def test_the_root_checks_first_and_forgets_that_it_did() -> None:
    root = tree_of(Rig(mission("F at(A)")), ["move(H, A)"], ["wait"])
    assert isinstance(root, Sequence) and not root.memory
    assert [child.name for child in root.children] == ["as predicted?", "plan"]


def test_prefix_then_loop() -> None:
    root = tree_of(Rig(mission("F at(A)")), ["move(H, A)", "move(A, B)"], ["move(B, A)", "wait"])
    *prefix, loop = plan_of(root).children
    assert [node.name for node in prefix] == ["move(H, A)", "move(A, B)"]
    assert isinstance(loop, Repeat) and loop.name == "L" and loop.num_success == -1
    assert [node.name for node in loop.decorated.children] == ["move(B, A)", "wait"]


def test_without_a_prefix_only_the_loop_is_left() -> None:
    root = tree_of(Rig(mission("G at(H)")), [], ["wait"])
    assert [node.name for node in plan_of(root).children] == ["L"]


def test_an_action_is_the_triple_or_the_withdrawal_of_its_belief() -> None:
    root = tree_of(Rig(mission("F at(A)")), ["move(H, A)"], ["wait"])
    selector = plan_of(root).children[0]
    assert isinstance(selector, Selector) and selector.memory
    triple, right = selector.children
    assert isinstance(triple, Sequence) and triple.memory
    assert isinstance(right, Inverter)
    assert right.decorated.name == "withdraw trans_ok(H, A)"


def test_each_kind_of_skill_has_its_refinement() -> None:
    rig = Rig(mission("F done", skills=[move(tries=5), command("do", "at(H)", "done")]))
    root = tree_of(rig, ["do", "move(H, A)"], ["wait"])
    do, fly, loop = plan_of(root).children
    rest = loop.children[0].children[0]
    refinements = [node.children[0].children[1] for node in (do, fly, rest)]
    assert isinstance(refinements[0], SendCommand)
    assert isinstance(refinements[1], Retry) and refinements[1].num_failures == 5
    assert isinstance(refinements[2], Rest)
    tried = refinements[1].decorated.children
    assert [type(node) for node in tried] == [UpdateParam, MoveCommand]


def test_only_the_last_action_of_the_loop_ends_a_lap() -> None:
    rig = Rig(mission("G F at(A) & G F at(B)"), vehicle=FakeVehicle((0.0, 0.0, -2.0)).take_off(2))
    rig.begin()
    rig.run(lambda: rig.flight.progress.laps == 1)
    assert rig.places == ["A", "B", "A"]  # the first by the prefix
    rig.run(lambda: rig.flight.progress.laps == 2)
    assert rig.places == ["A", "B", "A", "B", "A"]


def test_a_tick_of_a_new_tree_is_running() -> None:
    rig = Rig(mission("F at(A)"))
    root = tree_of(rig, ["move(H, A)"], ["wait"])
    root.tick_once()
    assert root.status is Status.RUNNING
