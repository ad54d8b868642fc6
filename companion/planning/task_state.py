"""The state of the task: facts, beliefs, and the word of the flight.

Rules of the word (after Section III-A of the paper):

1. A completed skill appends a position, with the facts that hold then.
2. The automata read a position when the vehicle leaves it, that is, when the next skill begins.
   Until then an event may still change it. Plans are made as if it had been read.
3. No event is missed: a letter contains each event that is true when it is read, or that has become
   true since the letter before was read. No failure is missed: a belief returns by time only after
   a position has been read at which it did not hold.
4. An interrupted skill appends no position. The system moves first: the automata next read at the
   place that the vehicle reaches. So an event alone can never violate `X`.
5. An interrupted flight leaves the vehicle at no place: `at(here)` holds, and no other `at`.
6. A new plan keeps what was read (the paper starts again from the automaton's initial states). Only
   an event can make a line that must hold start again (`restarts`).
7. An action may be barred: nobody knows whether it was done, so no plan does it again, from
   wherever it would begin.
8. A line that the present plan drops continues to read. If it was violated, it starts again with
   the plan that takes it up; plans are made as if it had.

task_readings.py keeps what the conjuncts have read.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Set
from dataclasses import replace

from companion.mission.events import Event
from companion.mission.facts import AT, HERE, Fact, at
from companion.planning import task_changes as changes
from companion.planning.bound_clocks import NOTHING_OVER, ClocksRun
from companion.planning.domain import Action
from companion.planning.held_beliefs import HeldBeliefs
from companion.planning.lasso import Letter, Problem
from companion.planning.planner import Planner
from companion.planning.situation import Position, TaskSituation, unread_events
from companion.planning.skill_trials import UNTRIED
from companion.planning.task_readings import TaskReadings

AT_HERE = at(HERE)


class TaskState:
    """The task's present state.

    Attributes:
        facts: what holds, without the beliefs.
        beliefs: the beliefs that are held; only the state changes them.
        risen: events that have risen since the last letter was read.
        completed: number of completed skills; each has appended a position.
        positions: number of positions that have been left.
        left: those positions that nobody has collected yet.
        now_s: the time, if the task has clocks; 0 before the task is flown.
        running: the action that is under way.
        optional: lines of the task that may be dropped.
        dropped: those optional lines that the present plan does not keep.
        may_take_up: whether a skill was completed since dropped lines were last reconsidered.
        trials: what was learnt of the skills by trying them; plans depend on it.
        on_change: called with each change, after it.
    """

    def __init__(self, planner: Planner) -> None:
        self.on_change: Callable[[changes.TaskChange], None] = lambda _: None
        self._planner = planner
        self._readings = TaskReadings(planner.conjuncts)
        self.beliefs = HeldBeliefs(planner.task_facts)
        self.facts = planner.mission.initially
        self.risen = frozenset[Fact]()
        self.running: Action | None = None
        self._interrupted: Action | None = None
        self._departed_from = frozenset[Fact]()
        self.trials = UNTRIED
        self._unread_events = unread_events(planner.mission)
        self.optional = frozenset(planner.mission.priorities)
        self.dropped = frozenset[str]()
        self.may_take_up = False
        self.completed = 0
        self.positions = 0
        self.left: list[Position] = []
        self._is_read = False
        self._restarted: tuple[str, ...] = ()
        self.now_s = self._left_s = self._reached_s = 0.0

    @property
    def _moment(self) -> changes.TaskMoment:
        return changes.TaskMoment(self.positions, self.now_s)

    @property
    def withdrawn(self) -> frozenset[Fact]:
        """Beliefs that were disproved or that the map contradicts."""
        return self.beliefs.withdrawn

    @property
    def all_facts(self) -> frozenset[Fact]:
        """Facts, and the beliefs that are held, including those about `here`."""
        beliefs = self._planner.actions.beliefs(is_en_route=AT_HERE in self.facts)
        return self.facts | (beliefs - self.withdrawn)

    @property
    def situation(self) -> TaskSituation:
        """Everything that plans depend on, except the map and the position."""
        return TaskSituation(self.facts, self.risen, self.withdrawn, self.positions, self.completed)

    @property
    def violated(self) -> tuple[str, ...]:
        """The lines that must hold but that no continuation of the word can satisfy."""
        return tuple(line for line in self._readings.violated if line not in self.optional)

    @property
    def violated_anew(self) -> tuple[str, ...]:
        """The violated optional lines that the present plan was to keep."""
        kept = self.optional - self.dropped
        return tuple(line for line in self._readings.violated if line in kept)

    @property
    def laps(self) -> int:
        """The number of completed laps of the task."""
        return self._readings.laps

    def problem(
        self,
        fallen: Set[Fact] = frozenset(),
        returned: Set[Fact] = frozenset(),
        is_interrupted: bool = False,
    ) -> tuple[Problem, list[list[Letter]]]:
        """The planning problem from here, and what each conjunct has read, including this position.

        It has all lines of the task. Optional lines that are violated start again.

        Args:
            fallen: events that are assumed to hold no longer.
            returned: beliefs that are assumed to be held again.
            is_interrupted: whether the action under way is assumed to end here and now.
        """
        facts, withdrawn = self.facts - fallen, self.withdrawn - returned
        lost = self.optional.intersection(self._readings.violated)
        letter = None if self._is_read else self._letter(facts)
        now_s = self.now_s if self.running is None or is_interrupted else self._left_s
        if is_interrupted and self.running is not None and self.running.destination is not None:
            facts = frozenset(f for f in facts if f.predicate != AT) | {AT_HERE}
        word = self._readings.so_far(letter, self._reached_s, now_s, lost)
        problem = self._planner.problem(
            facts,
            word.automaton_states,
            withdrawn,
            is_en_route=AT_HERE in facts,
            unread=self.risen - facts if self._is_read else frozenset(),
            clocks_ms=word.clocks_ms,
            trials=self.trials,
        )
        if self.completed:
            problem = replace(problem, waiting_since_ms=word.waiting_since_ms)
        return problem, word.histories

    def begin(self, action: Action) -> None:
        """Leaves the present position for the one that an action leads to."""
        self._read_position()
        self.running, self._left_s = action, self.now_s
        self.on_change(changes.ActionBegun(self._moment, action.name))

    def leave(self) -> None:
        """Lets the automata read the present position, once."""
        self._read_position()
        self.on_change(changes.PositionRead(self._moment))

    def _read_position(self) -> None:
        if self._is_read:
            return
        letter = self._letter(self.facts)
        violated = self._readings.read(letter, self._reached_s, self.now_s, self.dropped)
        facts = self.facts | letter & self._planner.task_facts
        self.left.append(
            Position(
                number=self.positions,
                facts=facts,
                risen=(self.risen - self.facts) & facts,
                reached_s=self._reached_s,
                withdrawn=self.withdrawn,
                restarted=self._restarted,
                violated=violated,
                dropped=tuple(n for n in self._planner.mission.task if n in self.dropped),
            )
        )
        self.positions += 1
        self.risen = frozenset()
        self._restarted = ()
        self._is_read = True
        self.beliefs.read()
        self._readings.foresee(self._next_letter)

    def complete(self, action: Action, now_s: float) -> None:
        """Appends the position that an action leads to."""
        self._reached_s = now_s
        self.completed += 1
        self.facts = action.apply(self.facts)
        self.beliefs.leave_here()
        self.running = self._interrupted = None
        self.trials = self.trials.in_time
        self._is_read = False
        self._readings.foresee(self._next_letter)
        self.may_take_up = bool(self.dropped)
        self.on_change(changes.ActionCompleted(self._moment, action.name, now_s))

    def interrupt(self) -> None:
        """Ends the action under way, without its effects."""
        if self.running is not None:
            letter = self._letter(self.running.apply(self.facts))
            self._readings.try_in_vain(letter, self._reached_s)
        if self.running is not None and self.running.destination is not None:
            self._interrupted = self.running
            self._leave_place()
        self.running = None
        self.on_change(changes.ActionInterrupted(self._moment))

    def interrupted(self, actions: Iterable[Action]) -> Action | None:
        """The flight that was interrupted last and can be resumed.

        None if it is not one of these actions, if a position was appended since, or if its
        precondition would not hold where it began.
        """
        began_with = self.all_facts - {AT_HERE} | self._departed_from
        own = (a for a in actions if a is self._interrupted and a.is_applicable(began_with))
        return next(own, None)

    def begin_again(self, flight: Action) -> None:
        """Resumes the flight that was interrupted last, as if it had not been interrupted."""
        self.facts = self.facts - {AT_HERE} | self._departed_from
        self.running, self._interrupted = flight, None
        self.on_change(changes.FlightBegunAgain(self._moment, flight.name))

    def drop(self, lines: Collection[str]) -> tuple[str, ...]:
        """Drops these lines from now on and keeps all others.

        Returns the kept lines that start again: they were violated, what they read is forgotten.
        """
        self.dropped, self.may_take_up = frozenset(lines), False
        anew = self.violated_anew
        for line in anew:
            self._restart(line)
        self.on_change(changes.LinesDropped(self._moment, tuple(sorted(lines))))
        return anew

    def keep_dropped(self) -> None:
        """Leaves all dropped lines dropped until a skill is completed."""
        self.may_take_up = False
        self.on_change(changes.DroppedLinesKept(self._moment))

    def _restart(self, line: str) -> None:
        if self._readings.restart(line, self._reached_s):
            self._restarted = tuple(dict.fromkeys((*self._restarted, line)))

    def depart(self) -> None:
        """The vehicle leaves the place where it is, and is at no place."""
        self._leave_place()
        self.on_change(changes.VehicleDeparted(self._moment))

    def _leave_place(self) -> None:
        self._read_position()
        places = frozenset(f for f in self.facts if f.predicate == AT)
        self.facts, self._departed_from = self.facts - places | {AT_HERE}, places

    def withdraw(self, beliefs: frozenset[Fact], retry_s: float | None = None) -> None:
        """Withdraws beliefs; from time `retry_s` on, if given, they may be held again."""
        self.beliefs.withdraw(beliefs, retry_s)
        self.on_change(changes.BeliefsWithdrawn(self._moment, tuple(sorted(beliefs)), retry_s))

    def bar(self, action: Action) -> None:
        """No plan does an action again, because it is not known whether it was done."""
        self.trials = self.trials.without(action)
        self.on_change(changes.ActionBarred(self._moment, action.name))

    def put_aside(self, skills: Collection[str]) -> None:
        """Leaves skills out of plans until an event or a belief comes; none puts all back."""
        aside = self.trials.put_aside.union(skills) if skills else frozenset[str]()
        if aside != self.trials.put_aside:
            self.trials = replace(self.trials, put_aside=aside)
            self.on_change(changes.SkillsPutAside(self._moment, tuple(sorted(skills))))

    def note_overdue(self, skill: str, least_ms: int) -> None:
        """A skill works longer than its cost; until one is completed, plans say so, too."""
        self.trials = replace(self.trials, overdue=skill, least_ms=least_ms)
        self.on_change(changes.SkillOverdue(self._moment, skill, least_ms))

    def cut_off(self, beliefs: frozenset[Fact]) -> tuple[list[Fact], list[Fact]]:
        """Withdraws what the map contradicts, holds again what it no longer does; returns both."""
        lost, held = self.beliefs.cut_off(beliefs)
        self.trials = self.trials.forgiven if held else self.trials
        self.on_change(changes.BeliefsCutOff(self._moment, tuple(sorted(beliefs))))
        return lost, held

    def restore(self, now_s: float, is_waiting: bool, predicates: frozenset[str]) -> list[Fact]:
        """Holds beliefs again and returns them; see `HeldBeliefs.restore`."""
        restored = self.beliefs.restore(now_s, is_waiting, predicates)
        if restored:
            self.trials = self.trials.forgiven
            asked = now_s, is_waiting, tuple(sorted(predicates))
            self.on_change(changes.BeliefsRestored(self._moment, *asked))
        return restored

    def take(self, event: Event, holds: bool) -> None:
        """Sets the new value of an event."""
        fact = frozenset({event.fact})
        self.facts = self.facts | fact if holds else self.facts - fact
        if holds:
            self.risen |= fact
        if event.fact not in self._unread_events:
            self.trials = self.trials.forgiven
        self._readings.foresee(self._next_letter, self.now_s)
        for line in self._planner.mission.task:
            if holds and line in event.restarts:
                self._restart(line)
        self.on_change(changes.EventValueTaken(self._moment, event.name, holds))

    def run_clocks(self, now_s: float) -> ClocksRun:
        """Lets time pass. Returns which clocks have just run out.

        The first call begins the task: its first position counts as reached then.
        """
        readings = self._readings
        if not readings.have_clocks:
            return NOTHING_OVER
        if not readings.have_begun and not self.positions:
            self._reached_s = now_s
        self.now_s = now_s
        run = readings.run_clocks(now_s, None if self._is_read else self._next_letter)
        if run.has_changed:
            self.on_change(changes.ClocksChanged(self._moment))
        return run

    @property
    def _next_letter(self) -> Letter:
        """What is read next, as far as it is known; between places, the vehicle is at none."""
        left = frozenset(f for f in self.facts if f.predicate == AT) if self._is_read else ()
        return self._letter(self.facts.difference(left))

    @property
    def is_called(self) -> bool:
        """Whether the event of a ready line has come, and no position has read it yet."""
        return self._readings.are_called(self._planner.mission.ready)

    @property
    def last_position(self) -> int:
        """The number of the position that was left last."""
        return max(0, self.positions - 1)

    def _letter(self, facts: frozenset[Fact]) -> Letter:
        """What the automata read at a position with these facts."""
        return facts | self.risen | (self._planner.actions.model.beliefs - self.withdrawn)
