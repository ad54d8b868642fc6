"""A state is what its changes make of the first one: replayed, also from text, it is the same."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, get_args

from hypothesis import given
from hypothesis import strategies as st
from synthetic import command, event, mission

from companion.flight_events.values import object_of
from companion.flight_events.writing import json_of
from companion.mission.model import Mission
from companion.planning.bound_clocks import BoundClocks
from companion.planning.domain import Action
from companion.planning.en_route import InterruptedFlight
from companion.planning.held_beliefs import HeldBeliefs
from companion.planning.planner import Planner
from companion.planning.readings import Reading
from companion.planning.skill_trials import OverdueSkill
from companion.planning.task_changes import ClocksChanged, TaskChange
from companion.planning.task_readings import TaskReadings
from companion.planning.task_replay import TaskReplay
from companion.planning.task_state import TaskState
from companion.planning.word import Word

ASKED = mission(
    {"sites": "G F at(A) & G F at(B)", "report": "G(found -> F done)", "first": "F at(A)"},
    skills=[command("do", "at(B)", "done")],
    events=[event("found", restarts=["first"])],
    priorities={"first": 2, "sites": 1},
)
MUTATORS = ("begin", "complete", "interrupt", "again", "take", "depart", "withdraw", "cut_off")
TRIALS = ("bar", "aside", "back", "overdue", "in time")
CALLS = (*MUTATORS, "restore", "drop", "keep", "leave", *TRIALS)


def kept(asked: Mission) -> tuple[Planner, TaskState, list[TaskChange]]:
    planner = Planner(asked, lambda origin, goal: 4.0)
    state = TaskState(planner)
    changes: list[TaskChange] = []
    state.on_change = changes.append
    return planner, state, changes


def call(state: TaskState, planner: Planner, name: str, choice: int, now_s: float) -> None:
    """One of the calls that acting makes, with arguments that a number chooses."""
    actions = state.problem()[0].actions
    action: Action = actions[choice % len(actions)]
    assumed = action.assumes

    def complete() -> None:
        if state.running:
            state.complete(state.running, now_s)

    def again() -> None:
        if flight := state.interrupted(planner.actions.every()):
            state.resume_flight(flight)

    calls: dict[str, Callable[[], object]] = {
        "begin": lambda: state.begin(action),
        "complete": complete,
        "interrupt": state.interrupt,
        "again": again,
        "take": lambda: state.take(planner.mission.events["found"], choice % 2 == 0),
        "depart": state.depart,
        "withdraw": lambda: state.withdraw(assumed, now_s + 5.0 if choice % 2 else None),
        "cut_off": lambda: state.cut_off(assumed),
        "restore": lambda: state.restore(
            now_s, choice % 2 == 0, frozenset({"can_do"} if choice % 3 else ())
        ),
        "drop": lambda: state.drop(["sites", "first"][: choice % 3]),
        "keep": state.keep_dropped,
        "leave": state.leave,
        "bar": lambda: state.bar(action),
        "aside": lambda: state.put_aside([action.from_anywhere]),
        "back": state.put_back,
        "overdue": lambda: state.note_overdue(OverdueSkill(action.from_anywhere, 1000 * choice)),
        "in time": state.forget_overdue,
    }
    calls[name]()


def told(state: TaskState) -> dict[str, Any]:
    """All of a state, with the actions by their names and the readings by their contents."""

    left_out = ("on_change", "_planner", "_conjuncts")

    def plain(value: object) -> object:
        match value:
            case Action():
                return value.name
            case Reading():
                inner = {k: v for k, v in vars(value).items() if k not in ("conjunct", "_begin")}
                return inner | {"runs": value.runs.states}
            case HeldBeliefs() | BoundClocks() | TaskReadings() | Word():
                return {k: plain(v) for k, v in vars(value).items() if k not in left_out}
            case InterruptedFlight():
                return value.flight.name, value.left
            case list():
                return [plain(each) for each in value]
        return value

    return {name: plain(value) for name, value in vars(state).items() if name not in left_out}


@given(st.lists(st.tuples(st.sampled_from(CALLS), st.integers(0, 30)), max_size=40))
def test_changes_that_are_replayed_make_the_same_state(calls: list[tuple[str, int]]) -> None:
    planner, state, changes = kept(ASKED)
    for number, (name, choice) in enumerate(calls):
        call(state, planner, name, choice, 0.5 * number)
    other_planner, again, _ = kept(ASKED)
    replay = TaskReplay(again, other_planner)
    for change in changes:
        written = json.loads(json.dumps(json_of(change)))
        replay.make(object_of(type(change), written))
    assert told(again) == told(state)
    assert again.problem()[0].actions == state.problem()[0].actions


def test_every_kind_of_change_is_reported() -> None:
    planner, state, changes = kept(ASKED)
    flying = ("begin", "complete", "begin", "interrupt", "again", "leave", "depart")
    others = ("take", "withdraw", "restore", "cut_off", "drop", "keep", *TRIALS[1:])
    for choice in range(20):
        for name in (*flying, *others):
            call(state, planner, name, choice, 10.0 * choice)
    call(state, planner, "bar", 0, 200.0)
    kinds = {type(change) for change in changes}
    assert set(get_args(TaskChange)) - kinds == {ClocksChanged}  # the mission has no clocks


def test_what_changes_nothing_is_not_kept() -> None:
    _, state, changes = kept(ASKED)
    state.restore(1.0, True, frozenset())
    assert changes == []


def test_a_barred_action_is_in_no_plan() -> None:
    planner, state, _ = kept(mission("F done", skills=[command("do", "", "done")]))
    assert "do" in {action.name for action in state.problem()[0].actions}
    state.bar(next(a for a in planner.actions.every() if a.name == "do"))
    problem, histories = state.problem()
    assert planner.solver.replan(problem, histories) is None
    told = str(planner.solver.explain_soon(problem))
    assert "not done again: do, as it is not known whether that was done" in told
