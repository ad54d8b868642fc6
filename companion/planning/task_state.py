"""The state of the task: facts, beliefs, the word of the flight, and what was learnt of skills.

Rules of the state (after Section III-A of the paper); word.py has those about reading positions:

1. A completed skill appends a position to the word, with the facts that hold then. The automata
   read it when the next skill begins; plans are made as if it had been read.
2. An interrupted skill appends no position. The system moves first: the automata next read at the
   place that the vehicle reaches. So an event alone can never violate `X`.
3. An interrupted flight leaves the vehicle at no place: `at(here)` holds, and no other `at`.
4. No failure is missed: a belief returns by time only after a position has been read at which it
   did not hold.
5. A new plan keeps what was read (the paper starts again from the automaton's initial states). Only
   an event can make a line that must hold start again (`restarts`).
6. An action may be barred: nobody knows whether it was done, so no plan does it again, from
   wherever it would begin.
7. A line that the present plan drops continues to read. If it was violated, it starts again with
   the plan that takes it up; plans are made as if it had.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Set
from dataclasses import replace

from companion.mission.events import Event
from companion.mission.facts import Fact
from companion.planning import task_changes as changes
from companion.planning.bound_clocks import ClocksRun
from companion.planning.domain import Action
from companion.planning.en_route import AT_HERE, InterruptedFlight, at_no_place, places
from companion.planning.held_beliefs import HeldBeliefs
from companion.planning.lasso import Letter, Problem
from companion.planning.line_choice import LineChoice
from companion.planning.planner import Planner
from companion.planning.situation import TaskSituation, unread_events
from companion.planning.skill_trials import UNTRIED, OverdueSkill
from companion.planning.word import Word


class TaskState:
    """The task's present state.

    Attributes:
        facts: what holds, without the beliefs.
        beliefs: the beliefs that are held; only the state changes them.
        word: the positions of the word, and what was read at them.
        lines: which optional lines the present plan keeps.
        trials: what was learnt of the skills by trying them; plans depend on it.
        completed: number of completed skills; each has appended a position.
        running: the action that is under way.
        on_change: called with each change, after it.
    """

    def __init__(self, planner: Planner) -> None:
        self.on_change: Callable[[changes.TaskChange], None] = lambda _: None
        self._planner = planner
        self._unread_events = unread_events(planner.mission)
        self.facts = planner.mission.initially
        self.beliefs = HeldBeliefs(planner.task_facts)
        self.word = Word(planner, self.beliefs)
        self.lines = LineChoice(frozenset(planner.mission.priorities))
        self.trials = UNTRIED
        self.completed = 0
        self.running: Action | None = None
        self._begun_s = 0.0
        self._interrupted: InterruptedFlight | None = None

    @property
    def _moment(self) -> changes.TaskMoment:
        return changes.TaskMoment(self.word.positions, self.word.now_s)

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
        word = self.word
        return TaskSituation(self.facts, word.risen, self.withdrawn, word.positions, self.completed)

    @property
    def violated(self) -> tuple[str, ...]:
        """The lines that must hold but that no continuation of the word can satisfy."""
        return self.lines.required(self.word.violated)

    @property
    def violated_kept(self) -> tuple[str, ...]:
        """The violated optional lines that the present plan was to keep."""
        return self.lines.kept(self.word.violated)

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
        lost = self.lines.optional.intersection(self.word.violated)
        is_over = self.running is None or is_interrupted
        read = self.word.so_far(facts, self.word.now_s if is_over else self._begun_s, lost)
        if is_interrupted and self.running is not None and self.running.destination is not None:
            facts = at_no_place(facts)
        problem = self._planner.problem(
            facts,
            read.automaton_states,
            withdrawn,
            is_en_route=AT_HERE in facts,
            unread=self.word.risen - facts if self.word.is_read else frozenset(),
            clocks_ms=read.clocks_ms,
            trials=self.trials,
        )
        if self.completed:
            problem = replace(problem, waiting_since_ms=read.waiting_since_ms)
        return problem, read.histories

    def begin(self, action: Action) -> None:
        """Leaves the present position for the one that an action leads to."""
        self._read_position()
        self.running, self._begun_s = action, self.word.now_s
        self.on_change(changes.ActionBegun(self._moment, action.name))

    def leave(self) -> None:
        """Lets the automata read the present position, once."""
        self._read_position()
        self.on_change(changes.PositionRead(self._moment))

    def _read_position(self) -> None:
        self.word.read(self.facts, self.lines.dropped)

    def complete(self, action: Action, now_s: float) -> None:
        """Appends the position that an action leads to."""
        self.completed += 1
        self.facts = action.apply(self.facts)
        self.beliefs.leave_here()
        self.running = self._interrupted = None
        self.trials = self.trials.in_time
        self.lines = self.lines.after_skill
        self.word.append(self.facts, now_s)
        self.on_change(changes.ActionCompleted(self._moment, action.name, now_s))

    def interrupt(self) -> None:
        """Ends the action under way, without its effects."""
        if self.running is not None:
            self.word.try_in_vain(self.running.apply(self.facts))
        if self.running is not None and self.running.destination is not None:
            self._interrupted = InterruptedFlight(self.running, self._leave_place())
        self.running = None
        self.on_change(changes.ActionInterrupted(self._moment))

    def interrupted(self, actions: Iterable[Action]) -> Action | None:
        """The flight that was interrupted last and can be resumed.

        None if it is not one of these actions, if a position was appended since, or if its
        precondition would not hold where it began.
        """
        last = self._interrupted
        is_own = last is not None and last.is_one_of(actions, self.all_facts)
        return last.flight if last is not None and is_own else None

    def resume_flight(self, flight: Action) -> None:
        """Resumes the flight that was interrupted last, as if it had not been interrupted."""
        if self._interrupted is not None:
            self.facts = self._interrupted.facts_before(self.facts)
        self.running, self._interrupted = flight, None
        self.on_change(changes.FlightResumed(self._moment, flight.name))

    def drop(self, lines: Collection[str]) -> tuple[str, ...]:
        """Drops these lines from now on and keeps all others.

        Returns the kept lines that start again: they were violated, what they read is forgotten.
        """
        self.lines = self.lines.dropping(lines)
        restarted = self.violated_kept
        for line in restarted:
            self.word.restart(line)
        self.on_change(changes.LinesDropped(self._moment, tuple(sorted(lines))))
        return restarted

    def keep_dropped(self) -> None:
        """Leaves all dropped lines dropped until a skill is completed."""
        self.lines = self.lines.reconsidered
        self.on_change(changes.DroppedLinesKept(self._moment))

    def depart(self) -> None:
        """The vehicle leaves the place where it is, and is at no place."""
        left = self._leave_place()
        if self._interrupted is not None:
            self._interrupted = replace(self._interrupted, left=left)
        self.on_change(changes.VehicleDeparted(self._moment))

    def _leave_place(self) -> frozenset[Fact]:
        """Returns the facts that said where the vehicle was."""
        self._read_position()
        left = places(self.facts)
        self.facts = at_no_place(self.facts)
        return left

    def withdraw(self, beliefs: frozenset[Fact], retry_s: float | None = None) -> None:
        """Withdraws beliefs; from time `retry_s` on, if given, they may be held again."""
        self.beliefs.withdraw(beliefs, retry_s)
        self.on_change(changes.BeliefsWithdrawn(self._moment, tuple(sorted(beliefs)), retry_s))

    def bar(self, action: Action) -> None:
        """No plan does an action again, because it is not known whether it was done."""
        self.trials = self.trials.without(action)
        self.on_change(changes.ActionBarred(self._moment, action.name))

    def put_aside(self, skills: Collection[str]) -> None:
        """Leaves skills out of plans until an event or a belief comes."""
        before, self.trials = self.trials, self.trials.putting_aside(skills)
        if self.trials != before:
            self.on_change(changes.SkillsPutAside(self._moment, tuple(sorted(skills))))

    def put_back(self) -> None:
        """Plans may have the skills again that were put aside."""
        before, self.trials = self.trials, self.trials.with_all_put_back
        if self.trials != before:
            self.on_change(changes.SkillsPutBack(self._moment))

    def note_overdue(self, skill: OverdueSkill) -> None:
        """A skill works longer than its cost; until one is completed, plans say so, too."""
        self.trials = replace(self.trials, overdue=skill)
        self.on_change(changes.SkillOverdue(self._moment, skill.name, skill.least_ms))

    def forget_overdue(self) -> None:
        """Plans assume again that each skill takes as long as its cost says."""
        before, self.trials = self.trials, self.trials.in_time
        if self.trials != before:
            self.on_change(changes.OverdueForgotten(self._moment))

    def cut_off(self, beliefs: frozenset[Fact]) -> tuple[list[Fact], list[Fact]]:
        """Withdraws what the map contradicts, holds again what it no longer does; returns both."""
        lost, held = self.beliefs.cut_off(beliefs)
        self.trials = self.trials.with_all_put_back if held else self.trials
        self.on_change(changes.BeliefsCutOff(self._moment, tuple(sorted(beliefs))))
        return lost, held

    def restore(self, now_s: float, is_waiting: bool, predicates: frozenset[str]) -> list[Fact]:
        """Holds beliefs again and returns them; see `HeldBeliefs.restore`."""
        restored = self.beliefs.restore(now_s, is_waiting, predicates)
        if restored:
            self.trials = self.trials.with_all_put_back
            asked = now_s, is_waiting, tuple(sorted(predicates))
            self.on_change(changes.BeliefsRestored(self._moment, *asked))
        return restored

    def take(self, event: Event, holds: bool) -> None:
        """Sets the new value of an event."""
        fact = frozenset({event.fact})
        self.facts = self.facts | fact if holds else self.facts - fact
        if event.fact not in self._unread_events:
            self.trials = self.trials.with_all_put_back
        self.word.take(event, holds, self.facts)
        self.on_change(changes.EventValueTaken(self._moment, event.name, holds))

    def run_clocks(self, now_s: float) -> ClocksRun:
        """Lets time pass. Returns which clocks have just run out; see `Word.run_clocks`."""
        run = self.word.run_clocks(now_s, self.facts)
        if run.has_changed:
            self.on_change(changes.ClocksChanged(self._moment))
        return run
