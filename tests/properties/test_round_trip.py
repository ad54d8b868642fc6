"""Formula, lasso, tree, flight: what is flown is the plan, action by action and letter by letter.

Missions are drawn; the vehicle is a point that obeys, and every command is accepted. Then nothing
differs from what the plan assumed, and the tree has to execute the prefix once and the loop again
and again.
"""

from __future__ import annotations

from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from rig import Rig
from synthetic import command, mission

from companion.acting.executive_states import TaskStatus
from companion.outcomes import Progress
from companion.planning.lasso import word

PARTS = [
    "F at(A)",
    "F (at(A) & F at(B))",
    "F G at(C)",
    "G F at(A)",
    "G F at(B)",
    "G F (at(A) | at(C))",
    "G (at(A) -> X at(B))",
    "!at(B) U at(A)",
    "G !at(C)",
    "F done",
    "G F done & G F !done",
    "F done & G (done -> X at(H))",
    "G (at(A) -> F done)",
]
LAPS = 3
LIMIT_S = 600.0


def rig_of(parts: list[str]) -> Rig:
    """A mission that asks for all parts, with work to do at B and to undo at H."""
    skills = [command("do", "at(B)", "done"), command("undo", "at(H) & done", "!done")]
    rig = Rig(mission({f"line{i}": p for i, p in enumerate(parts)}, "HABC", skills))
    a_while = (0.2, Progress.DONE)  # so that a command is seen while it is under way
    rig.vehicle.payloads.answers = [a_while] * 100
    return rig


def fly(rig: Rig) -> list[str]:
    """Flies until the task is satisfied, or for some laps; the actions that were completed."""
    completed: list[str] = []
    under_way = ""

    def watch() -> bool:
        nonlocal under_way
        for _ in range(rig.flight.progress.completed - len(completed)):
            completed.append(under_way)
        under_way = rig.task.running.name if rig.task.running else ""
        is_over = rig.executive.status is not TaskStatus.RUNNING
        return is_over or rig.flight.progress.laps == LAPS

    rig.run(watch, LIMIT_S)
    return completed


@drawn(40)
@given(st.lists(st.sampled_from(PARTS), min_size=1, max_size=3, unique=True))
def test_the_tree_executes_the_prefix_and_then_the_loop_again_and_again(parts: list[str]) -> None:
    rig = rig_of(parts)
    problem, _ = rig.task.problem()
    assume(rig.planner.explain() is None)
    rig.begin()
    (lasso,) = rig.plans
    laps = 1 if lasso.ends_at_rest else LAPS
    assert fly(rig) == [a.name for a in (*lasso.prefix, *lasso.loop * laps)]
    assert rig.executive.reports.replans == 0
    assert rig.flight.progress.laps == laps
    ending = TaskStatus.SATISFIED if lasso.ends_at_rest else TaskStatus.RUNNING
    assert rig.executive.status is ending

    before, again = word(problem, lasso)
    promised = [problem.facts, *before, *again * (LAPS + 1)]
    for position, letter in zip(rig.positions, promised, strict=False):
        assert set(position.facts) == letter - rig.planner.actions.model.beliefs
    assert len(rig.positions) >= len(lasso.prefix) + laps * len(lasso.loop)
