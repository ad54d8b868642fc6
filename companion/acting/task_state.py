"""Where the task stands: facts, beliefs, and how far the automata have read.

The word of the flight (DESIGN of the semantics, after Section III-A of the paper):

1. A completed skill appends a position, with the facts that hold then.
2. A position is read by the automata when it is left, that is, when the next skill begins.
3. An interrupted skill appends no position. The system moves first: the automata read next at
   the place that the vehicle reaches. So an event can never break `X` by itself.
4. An interrupted flight leaves the vehicle at no place: what the action deletes is gone, what
   it adds has not come, and `at(here)` holds.
"""

from __future__ import annotations

from companion.mission.model import Fly
from companion.planning.domain import HERE, Action, Fact
from companion.planning.lasso import Letter, Problem
from companion.planning.planner import Planner

AT_HERE = f"at({HERE})"


class TaskState:
    """The task's present state.

    Attributes:
        facts: what holds, without the beliefs.
        withdrawn: beliefs that were disproved.
        history: the letters read so far.
        running: the action under way.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self.facts: frozenset[Fact] = planner.mission.initially
        self.withdrawn: frozenset[Fact] = frozenset()
        self.history: list[Letter] = []
        self.running: Action | None = None
        self._states = planner.initial_states
        self._is_read = False

    @property
    def all_facts(self) -> frozenset[Fact]:
        """Facts and the beliefs that are held, those about `here` included."""
        return self.problem().facts

    def problem(self) -> Problem:
        """The planning problem from here."""
        return self._planner.problem(
            self.facts,
            self._states,
            self.withdrawn,
            is_read=self._is_read,
            is_en_route=AT_HERE in self.facts,
        )

    def begin(self, action: Action) -> None:
        """Leaves the present position: the automata read it, once."""
        if not self._is_read:
            letter = self.facts | (self._planner.model.beliefs - self.withdrawn)
            self.history.append(letter)
            self._states = self._planner.read(self._states, letter)
            self._is_read = True
        self.running = action

    def complete(self, action: Action) -> None:
        """Appends the position that an action leads to."""
        self.facts = action.apply(self.facts)
        self.withdrawn = frozenset(b for b in self.withdrawn if not _is_about_here(b))
        self._is_read = False
        self.running = None

    def interrupt(self) -> None:
        """Ends the action under way without its effect."""
        if self.running is not None and isinstance(self.running.execute, Fly):
            self.facts = (self.facts - self.running.deletes) | {AT_HERE}
        self.running = None

    def withdraw(self, beliefs: frozenset[Fact]) -> None:
        """Gives up beliefs."""
        self.withdrawn |= beliefs

    def set_fact(self, fact: Fact, holds: bool) -> None:
        """Takes over a fact that the vehicle cannot choose."""
        self.facts = self.facts | {fact} if holds else self.facts - {fact}


def _is_about_here(belief: Fact) -> bool:
    """Whether a belief speaks of `here`, a place that is another one each time."""
    return HERE in belief.removesuffix(")").partition("(")[2].split(", ")
