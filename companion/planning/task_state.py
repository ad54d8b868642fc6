"""Where the task stands: facts, beliefs, and how far each conjunct has been read.

The word of the flight (after Section III-A of the paper):

1. A completed skill appends a position, with the facts that hold then.
2. A position is read by the automata when it is left, that is, when the next skill begins.
   Until then an event may still change it. Plans are made as if it were read.
3. No rise of an event is lost. A letter has each event that is true when it is read, or has risen
   since the last letter was read. An event that was read and has fallen since is false.
4. An interrupted skill appends no position. The system moves first: the automata read next at
   the place that the vehicle reaches. So an event can never break `X` by itself.
5. An interrupted flight leaves the vehicle at no place: `at(here)` holds and no other `at`.
6. What was read is kept when a plan is made anew, where the paper starts from the automaton's
   initial states. Only an event may say that a conjunct begins anew (`restarts`).
7. A conjunct that no continuation can satisfy any more is violated by the position read last. No
   plan leads there: it takes an event or a failure that the vehicle could not choose.
8. What has to be met again and again waits since the position that met it last. Once two tries in a
   row were interrupted it waits since the last of them: others may be reached where it is not.
9. A lap of the task is over when every acceptance mark has been met since the lap before, by
   whatever plans.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Set
from dataclasses import dataclass, replace

from companion.ltl.monitor import Runs
from companion.mission.facts import AT, HERE, Fact, at
from companion.mission.model import Event
from companion.planning.domain import Action
from companion.planning.lasso import Conjunct, Letter, Problem
from companion.planning.planner import Planner

AT_HERE = at(HERE)
MAX_TRIES = 2
"""Interrupted in a row, after which what was tried waits its turn again."""


@dataclass(frozen=True, slots=True)
class Position:
    """A position of the word, as it was when it was left.

    Attributes:
        number: its place in the word; the first one is 0.
        facts: what was read; of the beliefs only those that the task mentions.
        risen: events among them that had risen before, and held no more when they were read.
        reached_s: when it was appended.
        withdrawn: beliefs that were not held.
        restarted: names of conjuncts that begin anew with this position.
        violated: conjuncts that no continuation can satisfy since this position.
    """

    number: int
    facts: frozenset[Fact]
    risen: frozenset[Fact]
    reached_s: float
    withdrawn: frozenset[Fact]
    restarted: tuple[str, ...]
    violated: tuple[Conjunct, ...]


class Reading:
    """What one conjunct has read: the letters, and where its automaton may be after them.

    Attributes:
        since_s: for each acceptance mark, since when it waits.
        left_to_meet: the marks that were not met yet in this lap of the task.
    """

    def __init__(self, conjunct: Conjunct) -> None:
        self._begin = Runs.begin(conjunct.automaton)
        self.conjunct = conjunct
        self.restart(0.0)
        self.begin_lap()

    def restart(self, now_s: float) -> None:
        """Begins anew."""
        self.letters: list[Letter] = []
        self.runs = self._begin
        self.since_s = [now_s] * self.conjunct.automaton.marks
        self._tries = [0] * self.conjunct.automaton.marks

    def begin_lap(self) -> None:
        """Every mark is to be met again."""
        self.left_to_meet = frozenset(range(self.conjunct.automaton.marks))

    def since_with(self, letter: Letter, reached_s: float) -> list[float]:
        """Since when each mark waits, with one more position."""
        met = self.runs.marks_met(letter)
        return [reached_s if mark in met else since for mark, since in enumerate(self.since_s)]

    def try_in_vain(self, letter: Letter, begun_s: float) -> None:
        """A position with this letter was not reached."""
        for mark in self.runs.marks_met(letter):
            self._tries[mark] += 1
            if self._tries[mark] >= MAX_TRIES:
                self.since_s[mark] = begun_s

    def read(self, letter: Letter, reached_s: float) -> bool:
        """One more position; whether it violates the conjunct, which it did not before."""
        could_hold = bool(self.runs.states)
        self.since_s = self.since_with(letter, reached_s)
        for mark in self.runs.marks_met(letter):
            self._tries[mark] = 0
            self.left_to_meet -= {mark}
        self.runs = self.runs.after(letter)
        self.letters.append(letter)
        return could_hold and not self.runs.states


class TaskState:
    """The task's present state.

    Attributes:
        facts: what holds, without the beliefs.
        risen: events that have risen since the last letter was read.
        withdrawn: beliefs that were disproved, or that the map contradicts.
        positions: how many positions have been left.
        laps: how many laps of the task they were.
        left: those of them that nobody has collected yet.
        running: the action under way.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self._readings = [Reading(conjunct) for conjunct in planner.conjuncts]
        self._is_read = False
        self._restarted: tuple[str, ...] = ()
        self.facts: frozenset[Fact] = planner.mission.initially
        self.risen: frozenset[Fact] = frozenset()
        self.withdrawn: frozenset[Fact] = frozenset()
        self._returns_s: dict[Fact, float] = {}
        self._failed: frozenset[Fact] = frozenset()
        self._cut_off: frozenset[Fact] = frozenset()
        self.positions = self.laps = 0
        self._reached_s, self._has_completed = 0.0, False
        self.left: list[Position] = []
        self.running: Action | None = None
        self._interrupted: Action | None = None
        self._departed_from: frozenset[Fact] = frozenset()

    @property
    def all_facts(self) -> frozenset[Fact]:
        """Facts and the beliefs that are held, those about `here` included."""
        return self.problem()[0].facts

    @property
    def violated(self) -> tuple[str, ...]:
        """Names of the conjuncts that no continuation of what was read can satisfy."""
        names = (r.conjunct.name for r in self._readings if not r.runs.states)
        return tuple(dict.fromkeys(names))

    def problem(
        self, fallen: Set[Fact] = frozenset(), returned: Set[Fact] = frozenset()
    ) -> tuple[Problem, list[list[Letter]]]:
        """The planning problem from here, and what each conjunct has read with this position.

        Args:
            fallen: events that are supposed to hold no longer.
            returned: beliefs that are supposed to be held again.
        """
        facts, withdrawn = self.facts - fallen, self.withdrawn - returned
        if self._is_read:
            states = tuple(r.runs.states for r in self._readings)
            histories = [r.letters for r in self._readings]
            waiting = [r.since_s for r in self._readings]
            unread = self.risen - facts
        else:
            letter = self._letter(facts)
            states = tuple(r.runs.after(letter).states for r in self._readings)
            histories = [[*r.letters, letter] for r in self._readings]
            waiting = [r.since_with(letter, self._reached_s) for r in self._readings]
            unread = frozenset()
        is_en_route = AT_HERE in facts
        problem = self._planner.problem(facts, states, withdrawn, is_en_route, unread)
        if self._has_completed:
            since_ms = tuple(round(1000 * min(marks, default=0.0)) for marks in waiting)
            problem = replace(problem, waiting_since_ms=since_ms)
        return problem, histories

    def begin(self, action: Action) -> None:
        """Leaves the present position for the one that an action leads to."""
        self.leave()
        self.running = action

    def leave(self) -> None:
        """The automata read the present position, once."""
        if self._is_read:
            return
        letter = self._letter(self.facts)
        reached_s = self._reached_s
        violated = tuple(r.conjunct for r in self._readings if r.read(letter, reached_s))
        facts = self.facts | letter & self._planner.task_facts
        risen = (self.risen - self.facts) & facts
        number, restarted = self.positions, self._restarted
        self.left.append(
            Position(number, facts, risen, reached_s, self.withdrawn, restarted, violated)
        )
        self._is_read = True
        self.risen = frozenset()
        self._restarted = ()
        self.positions += 1
        if self._readings and not any(r.left_to_meet for r in self._readings):
            self.laps += 1
            for reading in self._readings:
                reading.begin_lap()

    def complete(self, action: Action, now_s: float) -> None:
        """Appends the position that an action leads to."""
        self._reached_s, self._has_completed = now_s, True
        self.facts = action.apply(self.facts)
        self.withdrawn = frozenset(b for b in self.withdrawn if HERE not in b.arguments)
        self._is_read = False
        self.running = self._interrupted = None

    def interrupt(self) -> None:
        """Ends the action under way without its effect."""
        if self.running is not None:
            letter = self._letter(self.running.apply(self.facts))
            for reading in self._readings:
                reading.try_in_vain(letter, self._reached_s)
        if self.running is not None and self.running.destination is not None:
            self._interrupted = self.running
            self.depart()
        self.running = None

    def begin_again(self, actions: Iterable[Action]) -> Action | None:
        """Goes on with the flight that was interrupted last, as if it had not been.

        Returns:
            the flight; None if it is none of some actions, a position was appended since, or its
            precondition would not hold where it has begun.
        """
        flight = next((action for action in actions if action is self._interrupted), None)
        if flight is None or not flight.is_applicable(
            self.all_facts - {AT_HERE} | self._departed_from
        ):
            return None
        self.facts = self.facts - {AT_HERE} | self._departed_from
        self.running, self._interrupted = flight, None
        return flight

    def depart(self) -> None:
        """The vehicle is at no place, and leaves the one where it is."""
        self.leave()
        places = frozenset(f for f in self.facts if f.predicate == AT)
        self.facts = self.facts - places | {AT_HERE}
        self._departed_from = places

    def withdraw(self, beliefs: frozenset[Fact], retry_s: float | None = None) -> None:
        """Gives up beliefs; from `retry_s` on, if given, they may be held again."""
        self.withdrawn |= beliefs
        self._failed |= beliefs
        for belief in beliefs:
            self._returns_s.pop(belief, None)
            if retry_s is not None:
                self._returns_s[belief] = retry_s

    def cut_off(self, beliefs: frozenset[Fact]) -> tuple[list[Fact], list[Fact]]:
        """Gives up the beliefs that the map contradicts, and holds again those that it did before.

        A belief that has just failed, and that the map contradicts, has failed for the map's sake.

        Args:
            beliefs: all that the map contradicts now.

        Returns:
            The beliefs given up, and those held again.
        """
        lost, held = beliefs - self.withdrawn, self._cut_off - beliefs
        self._cut_off = (self._cut_off | lost | self._failed) & beliefs
        self._failed = frozenset()
        self.withdrawn = (self.withdrawn | lost) - held
        return sorted(lost), sorted(held)

    @property
    def returning(self) -> frozenset[Fact]:
        """The withdrawn beliefs that are held again when their time has come."""
        return self.withdrawn & self._returns_s.keys()

    @property
    def is_cut_off(self) -> bool:
        """Whether the map contradicts a belief."""
        return bool(self._cut_off)

    def restore(self, now_s: float, predicates: frozenset[str]) -> list[Fact]:
        """Holds beliefs again whose time has come, or whose predicate is named; which ones.

        Those that the map contradicts wait for the map.
        """
        restored = sorted(
            belief
            for belief in self.withdrawn - self._cut_off
            if belief.predicate in predicates or self._returns_s.get(belief, math.inf) <= now_s
        )
        self.withdrawn -= set(restored)
        return restored

    def take(self, event: Event, holds: bool) -> None:
        """Takes over an event that has changed."""
        fact = frozenset({event.fact})
        self.facts = self.facts | fact if holds else self.facts - fact
        if holds:
            self.risen |= fact
        for reading in self._readings:
            name = reading.conjunct.name
            if holds and name in event.restarts:
                reading.restart(self._reached_s)
                self._restarted = tuple(dict.fromkeys((*self._restarted, name)))

    def _letter(self, facts: frozenset[Fact]) -> Letter:
        """What the automata read at a position with some facts."""
        return facts | self.risen | (self._planner.model.beliefs - self.withdrawn)
