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
   initial states. Only an event may say that a line which must hold begins anew (`restarts`).
7. A conjunct that no continuation can satisfy any more is violated by the position read last. No
   plan leads there: it takes an event or a failure that the vehicle could not choose.
8. What has to be met again and again waits since the position that met it last. Once two tries in a
   row were interrupted it waits since the last of them: others may be reached where it is not.
9. A lap of the task is over when every acceptance mark has been met since the lap before, by
   whatever plans.
10. An action may be barred: nobody knows whether it was done, and no plan does it again.
11. A line that the present plan drops is read on. If it was violated, it begins anew with the plan
   that takes it up; plans are made as if it had. It has no part in laps.
12. A bounded line is violated as soon as its clock has run over, by the position left last, and
   told at once. Clocks go on over replans, pauses and takeovers (companion/ltl/bound_clock.py).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence, Set
from dataclasses import replace

from companion.mission.facts import AT, HERE, Fact, at
from companion.mission.model import Event
from companion.planning.bound_clocks import BoundClocks
from companion.planning.domain import Action
from companion.planning.held_beliefs import HeldBeliefs
from companion.planning.lasso import Conjunct, Letter, Problem
from companion.planning.planner import Planner
from companion.planning.readings import Reading
from companion.planning.situation import Position, TaskSituation
from companion.planning.task_changes import TaskChange, recorded
from companion.slices import spent

AT_HERE = at(HERE)
_READING_US = 40


class TaskState:
    """The task's present state.

    Attributes:
        facts: what holds, without the beliefs.
        risen: events that have risen since the last letter was read.
        completed: how many skills were completed, each of which has appended a position.
        positions: how many positions have been left.
        laps: how many laps of the task they were.
        left: those of them that nobody has collected yet.
        now_s: the time, where clocks have to know it; 0 before the task is flown.
        running: the action under way.
        optional: lines of the task that may be dropped.
        dropped: those of them that the present plan does not keep.
        may_take_up: whether a skill was completed since it was last asked if they can be kept.
        barred: names of actions that no plan may have.
        on_change: told of each change, after it.
        is_changing: whether one is under way.
    """

    def __init__(self, planner: Planner) -> None:
        self.on_change: Callable[[TaskChange], None] = _ignore
        self.is_changing = self._is_read = self.may_take_up = False
        self._planner = planner
        self.optional = frozenset(planner.mission.priorities)
        self._readings = [Reading(conjunct) for conjunct in planner.conjuncts]
        self._clocks = BoundClocks(planner.conjuncts)
        self._find_violated()
        self.now_s = self._left_s = self._reached_s = 0.0
        self._restarted: tuple[str, ...] = ()
        self.facts, self.risen = planner.mission.initially, frozenset[Fact]()
        self._beliefs = HeldBeliefs()
        self.positions = self.laps = self.completed = 0
        self.left: list[Position] = []
        self.running: Action | None = None
        self.dropped = self.barred = frozenset[str]()
        self._interrupted: Action | None = None
        self._departed_from: frozenset[Fact] = frozenset()

    @property
    def withdrawn(self) -> frozenset[Fact]:
        """Beliefs that were disproved, or that the map contradicts."""
        return self._beliefs.withdrawn

    @property
    def all_facts(self) -> frozenset[Fact]:
        """Facts and the beliefs that are held, those about `here` included."""
        beliefs = self._planner.beliefs(is_en_route=AT_HERE in self.facts)
        return self.facts | (beliefs - self.withdrawn)

    @property
    def situation(self) -> TaskSituation:
        """All that plans depend on, but for the map and the position."""
        return TaskSituation(self.facts, self.risen, self.withdrawn, self.positions, self.completed)

    @property
    def violated(self) -> tuple[str, ...]:
        """The lines that no continuation of what was read can satisfy, and that must hold."""
        return tuple(line for line in self._violated if line not in self.optional)

    @property
    def violated_anew(self) -> tuple[str, ...]:
        """Those that may be dropped, which the present plan was to keep."""
        return tuple(line for line in self._violated if line in self.optional - self.dropped)

    def _find_violated(self) -> None:
        """After a position was read, a clock has run over, or a line has begun anew."""
        late = self._clocks.late
        names = (r.conjunct.name for r in self._readings if not r.runs.states or r.conjunct in late)
        self._violated = tuple(dict.fromkeys(names))

    def problem(
        self, fallen: Set[Fact] = frozenset(), returned: Set[Fact] = frozenset()
    ) -> tuple[Problem, list[list[Letter]]]:
        """The planning problem from here, and what each conjunct has read with this position.

        It has all lines of the task. Those that may be dropped, and are violated, begin anew.

        Args:
            fallen: events that are supposed to hold no longer.
            returned: beliefs that are supposed to be held again.
        """
        spent(_READING_US * len(self._readings))
        facts, withdrawn = self.facts - fallen, self.withdrawn - returned
        lost = self.optional.intersection(self._violated)
        readings = [
            r.anew(self._reached_s) if r.conjunct.name in lost else r for r in self._readings
        ]
        if self._is_read:
            states = tuple(r.runs.states for r in readings)
            histories = [r.letters for r in readings]
            waiting = [r.since_s for r in readings]
            unread, present = self.risen - facts, None
        else:
            letter = self._letter(facts)
            states = tuple(r.runs.after(letter).states for r in readings)
            histories = [[*r.letters, letter] for r in readings]
            waiting = [r.since_with(letter, self._reached_s) for r in readings]
            unread, present = frozenset[Fact](), (letter, self._reached_s)
        now_s = self.now_s if self.running is None else self._left_s
        clocks_ms = self._clocks.show(now_s, present, lost)
        states = self._clocks.without_late(states, lost)
        is_en_route = AT_HERE in facts
        problem = self._planner.problem(facts, states, withdrawn, is_en_route, unread, clocks_ms)
        if self.barred:
            allowed = tuple(a for a in problem.actions if a.name not in self.barred)
            problem = replace(problem, actions=allowed)
        if self.completed:
            since_ms = tuple(round(1000 * min(marks, default=0.0)) for marks in waiting)
            problem = replace(problem, waiting_since_ms=since_ms)
        return problem, histories

    @recorded
    def begin(self, action: Action) -> None:
        """Leaves the present position for the one that an action leads to."""
        self.leave()
        self.running, self._left_s = action, self.now_s

    @recorded
    def leave(self) -> None:
        """The automata read the present position, once."""
        if self._is_read:
            return
        letter = self._letter(self.facts)
        reached_s = self._reached_s
        late = self._clocks.read(letter, reached_s, self.now_s)
        violated = tuple(r.conjunct for r in self._readings if r.read(letter, reached_s))
        violated += tuple(conjunct for conjunct in late if conjunct not in violated)
        self._find_violated()
        facts = self.facts | letter & self._planner.task_facts
        risen = (self.risen - self.facts) & facts
        number, restarted = self.positions, self._restarted
        dropped = tuple(line for line in self._planner.mission.task if line in self.dropped)
        self.left.append(
            Position(number, facts, risen, reached_s, self.withdrawn, restarted, violated, dropped)
        )
        self._is_read = True
        self.risen, self._restarted = frozenset(), ()
        self._clocks.see(self._next_letter)
        self.positions += 1
        kept = [r for r in self._readings if r.conjunct.name not in self.dropped]
        if kept and not any(r.left_to_meet for r in kept):
            self.laps += 1
            for reading in self._readings:
                reading.begin_lap()

    @recorded
    def complete(self, action: Action, now_s: float) -> None:
        """Appends the position that an action leads to."""
        self._reached_s = now_s
        self.completed += 1
        self.facts = action.apply(self.facts)
        self._beliefs.leave_here()
        self._is_read = False
        self._clocks.see(self._next_letter)
        self.running = self._interrupted = None
        self.may_take_up = bool(self.dropped)

    @recorded
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

    @recorded
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

    @recorded
    def drop(self, lines: Collection[str]) -> tuple[str, ...]:
        """The plan from now on keeps all lines but these; which of those that it keeps begin anew.

        They were violated: what they have read is forgotten.
        """
        self.dropped, self.may_take_up = frozenset(lines), False
        anew = self.violated_anew
        for line in anew:
            self._restart(line)
        return anew

    @recorded
    def keep_dropped(self) -> None:
        """No dropped line can be kept here; it is asked again when a skill was completed."""
        self.may_take_up = False

    def _restart(self, line: str) -> None:
        """The conjuncts of a line begin anew with the position that is left next."""
        for reading in self._readings:
            if reading.conjunct.name == line:
                reading.restart(self._reached_s)
                self._restarted = tuple(dict.fromkeys((*self._restarted, line)))
        self._clocks.begin_anew(line)
        self._find_violated()

    @recorded
    def depart(self) -> None:
        """The vehicle is at no place, and leaves the one where it is."""
        self.leave()
        places = frozenset(f for f in self.facts if f.predicate == AT)
        self.facts, self._departed_from = self.facts - places | {AT_HERE}, places

    @recorded
    def withdraw(self, beliefs: frozenset[Fact], retry_s: float | None = None) -> None:
        """Gives up beliefs; from `retry_s` on, if given, they may be held again."""
        self._beliefs.withdraw(beliefs, retry_s)

    @recorded
    def bar(self, action: Action) -> None:
        """No plan does an action again: it is not known whether it was done."""
        self.barred |= {action.name}

    @recorded
    def cut_off(self, beliefs: frozenset[Fact]) -> tuple[list[Fact], list[Fact]]:
        """Gives up all that the map contradicts, and holds again what it did before; both."""
        return self._beliefs.cut_off(beliefs)

    @property
    def returning(self) -> frozenset[Fact]:
        """The withdrawn beliefs that are held again when their time has come."""
        return self._beliefs.returning

    @property
    def is_cut_off(self) -> bool:
        """Whether the map contradicts a belief."""
        return self._beliefs.is_cut_off

    @recorded
    def restore(self, now_s: float, predicates: frozenset[str]) -> list[Fact]:
        """Holds beliefs again whose time has come, or whose predicate is named; which ones."""
        return self._beliefs.restore(now_s, predicates)

    @recorded
    def take(self, event: Event, holds: bool) -> None:
        """Takes over an event that has changed."""
        fact = frozenset({event.fact})
        self.facts = self.facts | fact if holds else self.facts - fact
        if holds:
            self.risen |= fact
        self._clocks.see(self._next_letter, self.now_s)
        for line in self._planner.mission.task:
            if holds and line in event.restarts:
                self._restart(line)

    @recorded
    def run_clocks(self, now_s: float) -> Sequence[Conjunct]:
        """Time goes on; the conjuncts whose clock has just run over, [] where nothing changes.

        With the first call the task begins: its first position counts as reached then.
        """
        if not self._clocks:
            return []
        if not self._clocks.are_begun and not self.positions:
            self._reached_s = now_s
        self.now_s = now_s
        over = self._clocks.run(now_s, None if self._is_read else self._next_letter)
        if over:
            self._find_violated()
        return over

    @property
    def _next_letter(self) -> Letter:
        """What is read next, as far as it is known: between places the vehicle is at none."""
        left = frozenset(f for f in self.facts if f.predicate == AT) if self._is_read else ()
        return self._letter(self.facts.difference(left))

    @property
    def is_called(self) -> bool:
        """Whether the event of a line that is ready has come, and no position has read it."""
        return self._clocks.are_called(self._planner.mission.ready)

    @property
    def last_position(self) -> int:
        """The number of the position that was left last."""
        return max(0, self.positions - 1)

    def _letter(self, facts: frozenset[Fact]) -> Letter:
        """What the automata read at a position with some facts."""
        return facts | self.risen | (self._planner.model.beliefs - self.withdrawn)


def _ignore(change: TaskChange) -> None:
    """Nobody keeps the changes."""
