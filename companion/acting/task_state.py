"""Where the task stands: facts, beliefs, and how far each conjunct has been read.

The word of the flight (after Section III-A of the paper):

1. A completed skill appends a position, with the facts that hold then.
2. A position is read by the automata when it is left, that is, when the next skill begins.
   Until then an event may still change it. Plans are made as if it were read.
3. An interrupted skill appends no position. The system moves first: the automata read next at
   the place that the vehicle reaches. So an event can never break `X` by itself.
4. An interrupted flight leaves the vehicle at no place: `at(here)` holds and no other `at`.
5. What was read is kept when a plan is made anew, where the paper starts from the automaton's
   initial states. Only an event may say that a conjunct begins anew (`restarts`).
"""

from __future__ import annotations

import math

from companion.ltl.automaton import successors
from companion.mission.model import Event
from companion.planning.domain import HERE, Action, Fact
from companion.planning.lasso import Conjunct, Letter, Problem
from companion.planning.planner import Planner

AT_HERE = f"at({HERE})"


class Reading:
    """What one conjunct has read: the letters, and where its automaton may be after them."""

    def __init__(self, conjunct: Conjunct) -> None:
        self._automaton = conjunct.automaton
        self.name = conjunct.name
        self.restart()

    def restart(self) -> None:
        """Begins anew."""
        self.letters: list[Letter] = []
        self.states = self._automaton.initial

    def read(self, letter: Letter) -> None:
        """One more position."""
        self.states = self.after(letter)
        self.letters.append(letter)

    def after(self, letter: Letter) -> frozenset[int]:
        """Where the automaton would be after one more position."""
        return successors(self._automaton, self.states, letter)


class TaskState:
    """The task's present state.

    Attributes:
        facts: what holds, without the beliefs.
        withdrawn: beliefs that were disproved.
        positions: how many positions have been left.
        running: the action under way.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self._readings = [Reading(conjunct) for conjunct in planner.conjuncts]
        self._is_read = False
        self.facts: frozenset[Fact] = planner.mission.initially
        self.withdrawn: frozenset[Fact] = frozenset()
        self._returns_s: dict[Fact, float] = {}
        self.positions = 0
        self.running: Action | None = None

    @property
    def all_facts(self) -> frozenset[Fact]:
        """Facts and the beliefs that are held, those about `here` included."""
        return self.problem()[0].facts

    def problem(self) -> tuple[Problem, list[list[Letter]]]:
        """The planning problem from here, and what each conjunct has read with this position."""
        if self._is_read:
            states = tuple(r.states for r in self._readings)
            histories = [r.letters for r in self._readings]
        else:
            letter = self._letter()
            states = tuple(r.after(letter) for r in self._readings)
            histories = [[*r.letters, letter] for r in self._readings]
        is_en_route = AT_HERE in self.facts
        problem = self._planner.problem(self.facts, states, self.withdrawn, is_en_route)
        return problem, histories

    def begin(self, action: Action) -> None:
        """Leaves the present position: the automata read it, once."""
        if not self._is_read:
            letter = self._letter()
            for reading in self._readings:
                reading.read(letter)
            self._is_read = True
            self.positions += 1
        self.running = action

    def complete(self, action: Action) -> None:
        """Appends the position that an action leads to."""
        self.facts = action.apply(self.facts)
        self.withdrawn = frozenset(b for b in self.withdrawn if not _is_about_here(b))
        self._is_read = False
        self.running = None

    def interrupt(self) -> None:
        """Ends the action under way without its effect."""
        if self.running is not None and self.running.destination is not None:
            self.depart()
        self.running = None

    def depart(self) -> None:
        """The vehicle is at no place."""
        self.facts = frozenset(f for f in self.facts if not f.startswith("at(")) | {AT_HERE}

    def withdraw(self, beliefs: frozenset[Fact], retry_s: float | None = None) -> None:
        """Gives up beliefs; from `retry_s` on, if given, they may be held again."""
        self.withdrawn |= beliefs
        for belief in beliefs:
            self._returns_s.pop(belief, None)
            if retry_s is not None:
                self._returns_s[belief] = retry_s

    def restore(self, now_s: float, predicates: frozenset[str]) -> list[Fact]:
        """Holds beliefs again whose time has come, or whose predicate is named; which ones."""
        restored = sorted(
            belief
            for belief in self.withdrawn
            if belief.partition("(")[0] in predicates
            or self._returns_s.get(belief, math.inf) <= now_s
        )
        self.withdrawn -= set(restored)
        return restored

    def take(self, event: Event, holds: bool) -> None:
        """Takes over an event that has changed."""
        self.facts = self.facts | {event.name} if holds else self.facts - {event.name}
        for reading in self._readings:
            if holds and reading.name in event.restarts:
                reading.restart()

    def _letter(self) -> Letter:
        """What the automata read at the present position."""
        return self.facts | (self._planner.model.beliefs - self.withdrawn)


def _is_about_here(belief: Fact) -> bool:
    """Whether a belief speaks of `here`, a place that is another one each time."""
    return HERE in belief.removesuffix(")").partition("(")[2].split(", ")
