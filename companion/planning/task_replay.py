"""Makes recorded changes again, on another state of the same mission."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import assert_never

from companion.mission.facts import Fact
from companion.planning import task_changes as changes
from companion.planning.domain import Action, reach
from companion.planning.lasso import Conjunct
from companion.planning.planner import Planner
from companion.planning.skill_trials import OverdueSkill
from companion.planning.task_state import TaskState


class TaskReplay:
    """Makes changes again on a fresh state.

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
        self._actions = {action.name: action for action in (*safe, *planner.actions.every())}

    def action(self, name: str) -> Action:
        """The action with this name."""
        return self._actions[name]

    def make(self, change: changes.TaskChange) -> Sequence[Conjunct]:
        """Makes the next change. Returns the bounded conjuncts whose clock then has run out."""
        state = self._state
        state.word.now_s = change.at.now_s
        match change:
            case changes.ActionBegun():
                state.begin(self._actions[change.action])
            case changes.ActionCompleted():
                state.complete(self._actions[change.action], change.reached_s)
            case changes.ActionInterrupted():
                state.interrupt()
            case changes.FlightResumed():
                state.resume_flight(self._actions[change.action])
            case changes.ActionBarred():
                state.bar(self._actions[change.action])
            case changes.SkillsPutAside():
                state.put_aside(change.skills)
            case changes.SkillsPutBack():
                state.put_back()
            case changes.SkillOverdue():
                state.note_overdue(OverdueSkill(change.skill, change.least_ms))
            case changes.OverdueForgotten():
                state.forget_overdue()
            case changes.PositionRead():
                state.leave()
            case changes.VehicleDeparted():
                state.depart()
            case changes.EventValueTaken():
                state.take(self._events[change.event], change.holds)
            case changes.BeliefsWithdrawn():
                state.withdraw(_facts(change.beliefs), change.retry_s)
            case changes.BeliefsCutOff():
                state.cut_off(_facts(change.beliefs))
            case changes.BeliefsRestored():
                predicates = frozenset(change.predicates)
                state.restore(change.restored_s, change.is_waiting, predicates)
            case changes.LinesDropped():
                state.drop(change.lines)
            case changes.DroppedLinesKept():
                state.keep_dropped()
            case changes.ClocksChanged():
                return state.run_clocks(change.at.now_s).over
            case _:
                assert_never(change)
        return ()


def _facts(names: Iterable[str]) -> frozenset[Fact]:
    return frozenset(map(Fact.parse, names))
