"""Figure 5: a lasso as a behaviour tree, a prefix and then the decorator L around the loop.

Each action is the figure's triple: the precondition (green), the refinement (yellow), the effects
(blue). The tree is compared as text, as py_trees writes it: [-] is a sequence that begins anew at
every tick, {-} one that goes on where it was, {o} a selector, -^- a decorator, --> a leaf.
"""

from __future__ import annotations

import py_trees
from rig import Rig
from synthetic import command, mission

from companion.acting.behaviour_tree.builder import build
from companion.acting.replanning.assumptions import Assumptions
from companion.mission.model import Mission
from companion.motion.layered_routes import LayeredRoutes


def text_of(root: py_trees.behaviour.Behaviour) -> list[str]:
    return py_trees.display.ascii_tree(root).rstrip().splitlines()


def tree_of_the_plan(rig: Rig) -> list[str]:
    lasso = rig.begin().executive.lasso
    assert lasso is not None
    return text_of(build(rig.flight, lasso, Assumptions(rig.planner, rig.flight)))


def move_as_text(origin: str, goal: str) -> list[str]:
    """One action of the figure, with the alternative that Figure 6 adds."""
    return [
        f"{{o}} move({origin}, {goal})",
        "    {-} triple",
        f"        --> pre move({origin}, {goal})",
        "        -^- MAX_TRY(3)",
        "            {-} move",
        f"                --> update_param {goal}",
        f"                --> move_cmd {goal}",
        f"        --> eff move({origin}, {goal})",
        "    -^- not",
        f"        --> withdraw trans_ok({origin}, {goal})",
    ]


def indented(lines: list[str], by: int) -> list[str]:
    return [" " * by + line for line in lines]


def test_the_first_plan_of_the_paper_s_mission(
    section_v: Mission, surveillance_routes: LayeredRoutes
) -> None:
    assert tree_of_the_plan(Rig(section_v, surveillance_routes)) == [
        "[-] root",
        "    --> as predicted?",
        "    {-} plan",
        *indented(move_as_text("Home", "A"), 8),
        "        -^- L",
        "            {-} lap",
        *indented(move_as_text("A", "B"), 16),
        *indented(move_as_text("B", "C"), 16),
        *indented(move_as_text("C", "A"), 16),
    ]


def test_a_command_and_rest_have_the_same_shape() -> None:
    rig = Rig(mission("F done", skills=[command("do", "at(H)", "done")]))
    assert tree_of_the_plan(rig) == [
        "[-] root",
        "    --> as predicted?",
        "    {-} plan",
        "        {o} do",
        "            {-} triple",
        "                --> pre do",
        "                --> command MAV_CMD_USER_1",
        "                --> eff do",
        "            -^- not",
        "                --> withdraw can_do",
        "        -^- L",
        "            {-} lap",
        "                {o} wait",
        "                    {-} triple",
        "                        --> pre wait",
        "                        --> rest",
        "                        --> eff wait",
        "                    -^- not",
        "                        --> withdraw nothing",
    ]


def test_the_prefix_is_executed_once_and_the_suffix_for_ever() -> None:
    rig = Rig(mission("G F at(A) & G F at(B)")).begin()
    rig.run(lambda: rig.flight.progress.laps == 3)
    assert rig.places == ["A", *["B", "A"] * 3]
    assert str(rig.executive.lasso) == "move(H, A), (move(A, B), move(B, A))^w"
