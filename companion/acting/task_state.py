"""Where the task stands: facts, beliefs, and how far the automata have read.

The word of the flight (DESIGN of the semantics, after Section III-A of the paper):

1. A completed skill appends a position, with the facts that hold then.
2. A position is read by the automata when it is left, that is, when the next skill begins.
   Until then an event may still change it. Plans are made as if it were read.
3. An interrupted skill appends no position. The system moves first: the automata read next at
   the place that the vehicle reaches. So an event can never break `X` by itself.
4. An interrupted flight leaves the vehicle at no place: `at(here)` holds and no other `at`.
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
        history: the letters read so far; the present position's only after it was left.
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
        return self.problem()[0].facts

    def problem(self) -> tuple[Problem, list[Letter]]:
        """The planning problem from here, and the history with the present position."""
        states, history = self._states, self.history
        if not self._is_read:
            states, history = self._planner.read(states, self._letter()), [*history, self._letter()]
        is_en_route = AT_HERE in self.facts
        return self._planner.problem(self.facts, states, self.withdrawn, is_en_route), history

    def begin(self, action: Action) -> None:
        """Leaves the present position: the automata read it, once."""
        if not self._is_read:
            self._states = self._planner.read(self._states, self._letter())
            self.history.append(self._letter())
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
            self.depart()
        self.running = None

    def depart(self) -> None:
        """The vehicle is at no place."""
        self.facts = frozenset(f for f in self.facts if not f.startswith("at(")) | {AT_HERE}

    def withdraw(self, beliefs: frozenset[Fact]) -> None:
        """Gives up beliefs."""
        self.withdrawn |= beliefs

    def set_fact(self, fact: Fact, holds: bool) -> None:
        """Takes over a fact that the vehicle cannot choose."""
        self.facts = self.facts | {fact} if holds else self.facts - {fact}

    def _letter(self) -> Letter:
        """What the automata read at the present position."""
        return self.facts | (self._planner.model.beliefs - self.withdrawn)


def _is_about_here(belief: Fact) -> bool:
    """Whether a belief speaks of `here`, a place that is another one each time."""
    return HERE in belief.removesuffix(")").partition("(")[2].split(", ")
