"""Figure 6: the action move(W1, W2), each of its branches ticked step by step.

selector
+- sequence: trans_ok & in W1 | MAX_TRY(m) of update_param, move_cmd | effects
+- inverter - delete trans_ok.move(W1, W2)
"""

from __future__ import annotations

from happened import Replan
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Retry
from rig import Rig
from synthetic import POSITIONS, mission, move

from companion.acting.behaviour_tree.builder import build
from companion.acting.executive_states import TaskStatus
from companion.acting.replanning.assumptions import Assumptions
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.skills import SkillFailed, SymbolMoved
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Lasso

TRIES = 3
S, F, R, NOT_YET = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID


class Figure:
    """The tree of one move, and its nodes by the figure's names."""

    def __init__(self, timeout_s: float | None = None) -> None:
        self.rig = Rig(mission("F at(A)", skills=[move(tries=TRIES, timeout_s=timeout_s)]))
        self.action: Action = next(
            a for a in self.rig.planner.actions.model.actions if a.name == "move(H, A)"
        )
        self.root = build(
            self.rig.flight,
            Lasso((self.action,), (WAIT,)),
            Assumptions(self.rig.planner, self.rig.flight),
        )
        self.selector = self.root.children[1].children[0]
        self.triple, self.inverter = self.selector.children
        self.green, self.yellow, self.blue = self.triple.children
        assert isinstance(self.yellow, Retry)  # MAX_TRY(m)
        self.max_try = self.yellow
        self.update_param, self.move_cmd = self.yellow.decorated.children
        self.withdraw = self.inverter.children[0]

    def tick(self) -> Status:
        self.rig.pass_time()
        self.root.tick_once()
        return self.root.status

    def tick_until(self, node: Behaviour, status: Status) -> None:
        for _ in range(2000):
            self.tick()
            if node.status is status:
                return
        raise AssertionError(f"{node.name} is {node.status}, never {status}")


def statuses(*nodes: Behaviour) -> list[Status]:
    return [node.status for node in nodes]


def test_success_left_branch() -> None:
    figure = Figure()
    green, yellow, blue = figure.green, figure.yellow, figure.blue

    assert figure.tick() is R  # the precondition holds and the flight has begun
    assert statuses(green, figure.update_param, figure.move_cmd) == [S, S, R]
    assert statuses(yellow, blue, figure.withdraw) == [R, NOT_YET, NOT_YET]
    assert figure.rig.task.facts == {"at(H)"}

    figure.tick_until(figure.selector, S)
    assert statuses(green, yellow, blue, figure.withdraw) == [S, S, S, NOT_YET]
    assert figure.rig.task.facts == {"at(A)"}  # in W2, and no longer in W1
    assert figure.rig.task.withdrawn == frozenset()
    assert figure.root.status is R  # the plan goes on with its loop


def test_the_precondition_is_checked_before_anything_moves() -> None:
    figure = Figure()
    figure.rig.task.withdraw(figure.action.assumes)
    assert figure.tick() is F
    assert statuses(figure.green, figure.yellow, figure.blue) == [F, NOT_YET, NOT_YET]
    assert figure.rig.vehicle.flown == []


def test_max_try_instantiates_again_before_it_fails() -> None:
    """Each try asks for a value of the symbol and flies anew from where the vehicle then is."""
    figure = Figure(timeout_s=1.0)
    starts = []
    for failures in range(1, TRIES):
        figure.tick_until(figure.move_cmd, R)
        starts.append(figure.rig.vehicle.state.motion.position)  # type: ignore[union-attr]
        figure.tick_until(figure.move_cmd, F)
        assert figure.max_try.failures == failures
        assert statuses(figure.yellow, figure.selector, figure.root) == [R, R, R]
        assert figure.rig.task.withdrawn == frozenset()
    norths = [north for north, _, _ in starts]
    assert norths == sorted(set(norths)) and norths[0] < 0.2  # further each time

    figure.tick_until(figure.move_cmd, F)
    assert statuses(figure.yellow, figure.triple, figure.blue) == [F, F, NOT_YET]


def test_a_later_try_may_succeed() -> None:
    figure = Figure(timeout_s=2.5)
    figure.tick_until(figure.move_cmd, F)
    figure.tick_until(figure.selector, S)
    assert figure.max_try.failures in (1, 2)
    assert figure.rig.task.facts == {"at(A)"}
    assert figure.rig.task.withdrawn == frozenset()


def test_failure_right_branch() -> None:
    """The wrong belief is deleted, the inverter makes that a failure, and the root fails."""
    figure = Figure(timeout_s=1.0)
    figure.tick_until(figure.root, F)
    assert statuses(figure.withdraw, figure.inverter, figure.selector) == [S, F, F]
    assert figure.rig.task.withdrawn == {"trans_ok(H, A)"}
    assert "trans_ok(H, A)" not in figure.rig.task.all_facts
    assert figure.rig.task.facts == {"at(here)"}  # on the way
    events = [stamped.event for stamped in figure.rig.flight.reports]
    assert [event for event in events if not isinstance(event, SymbolMoved)] == [
        SkillFailed("move(H, A)", "not there after 1 s"),
        BeliefWithdrawn("trans_ok(H, A)"),
    ]


def test_the_failure_of_the_root_replans_without_the_deleted_transition() -> None:
    """A is flown to from where the vehicle is, because H is no longer where it is."""
    rig = Rig(mission("F at(A)", skills=[move(tries=TRIES)])).begin()
    rig.vehicle.drift = (0.0, 0.5, 0.0)  # it always settles beside its setpoint
    rig.run(lambda: rig.executive.reports.replans > 0)
    rig.vehicle.drift = (0.0, 0.0, 0.0)
    failed = SkillFailed("move(H, A)", "still 0.5 m from A")
    story = [event for event in rig.story if not isinstance(event, SymbolMoved)]
    replan = Replan(failed.text, "move(here, A), (wait)^w")
    assert story[1:] == [failed, BeliefWithdrawn("trans_ok(H, A)"), replan]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.task.withdrawn == {"trans_ok(H, A)"}


def test_w_is_the_place_and_c_the_present_state() -> None:
    figure = Figure()
    figure.rig.vehicle.change(position=(1.0, 0.5, -2.0))
    figure.tick()
    first = figure.rig.vehicle.setpoint
    assert first is not None and first.position == (1.0, 0.5, -2.0)
    figure.tick_until(figure.selector, S)
    last = figure.rig.vehicle.setpoint
    assert last is not None and last.position == POSITIONS["A"]
