"""Repeats the recorded changes of a task's state on another state of the same mission."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from companion.mission.facts import Fact
from companion.planning.bound_clocks import ClocksRun
from companion.planning.domain import Action, reach
from companion.planning.lasso import Conjunct
from companion.planning.planner import Planner
from companion.planning.task_changes import TaskChange
from companion.planning.task_state import TaskState


class TaskReplay:
    """Repeats changes on a fresh state.

    Args:
        state: the state, of the mission.
        planner: gives the mission's actions.

    Raises:
        LookupError: by `make`, if the mission has no such action or event.
    """

    def __init__(self, state: TaskState, planner: Planner) -> None:
        self._state = state
        self._events = planner.mission.events
        safe = map(reach, planner.mission.safe_places)
        self._actions = {action.name: action for action in (*safe, *planner.all_actions())}

    def action(self, name: str) -> Action:
        """The action with this name."""
        return self._actions[name]

    def make(self, change: TaskChange) -> Sequence[Conjunct]:
        """Repeats the next change. Returns the bounded conjuncts whose clock then has run out."""
        self._state.now_s = change.now_s
        arguments = _READERS[change.method](self, change.arguments)
        done = getattr(self._state, change.method)(*arguments)
        return done.over if isinstance(done, ClocksRun) else ()

    def _of_action(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        name, *rest = arguments
        return (self._actions[name], *rest)

    def _of_actions(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        return ([self._actions[name] for name in arguments[0] if name in self._actions],)

    def _of_event(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        name, *rest = arguments
        return (self._events[name], *rest)

    def _of_facts(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        facts, *rest = arguments
        return (frozenset(map(Fact.parse, facts)), *rest)

    def _as_they_are(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        return arguments

    def _of_names(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        return (*arguments[:-1], frozenset(arguments[-1]))


_Reader = Callable[[TaskReplay, tuple[Any, ...]], tuple[Any, ...]]
_READERS: dict[str, _Reader] = {
    "begin": TaskReplay._of_action,
    "complete": TaskReplay._of_action,
    "bar": TaskReplay._of_action,
    "begin_again": TaskReplay._of_actions,
    "take": TaskReplay._of_event,
    "withdraw": TaskReplay._of_facts,
    "cut_off": TaskReplay._of_facts,
    "restore": TaskReplay._of_names,
    "drop": TaskReplay._of_names,
    "leave": TaskReplay._as_they_are,
    "interrupt": TaskReplay._as_they_are,
    "run_clocks": TaskReplay._as_they_are,
    "keep_dropped": TaskReplay._as_they_are,
    "depart": TaskReplay._as_they_are,
}
"""How the arguments of each change are read back."""
