"""Bounded lines in flight: the task's state and the audit, against the definition of each bound.

Random flights: skills that take their time, holds between them, events that rise and fall at any
time. Time goes on in ticks. The reference below knows all of a flight and no clock.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from random import Random

import pytest
from synthetic import event, mission

from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import LineTakenUp
from companion.flight_events.word import PositionLeft
from companion.ltl.formula import Formula
from companion.ltl.parser import parse_line
from companion.ltl.semantics import holds
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within
from companion.ltl.timed_formula import parts
from companion.mission.model import Mission
from companion.planning.domain import WAIT
from companion.planning.planner import Planner
from companion.planning.situation import Position
from companion.planning.task_changes import TaskChange
from companion.planning.task_replay import TaskReplay
from companion.planning.task_state import TaskState
from companion.record.timed_word import TimedWord

TICK_S = 0.05
ALARM = event("alarm")
LINES = {
    "first": "F[<=20s] at(B)",
    "answer": "G (alarm -> F[<=15s] at(B))",
    "calm": "G (!alarm & at(A) -> F[<=15s] at(B))",
    "often": "revisit(A) <= 25 s",
    "soon": "F[<=20s] (at(B) | alarm)",
    "home": "revisit(at(A) | alarm) <= 25 s",
    "clear": "G (at(A) -> F[<=15s] (at(B) | alarm))",
}


def bounded(*lines: str, priorities: dict[str, int] | None = None) -> Mission:
    made = mission("F at(A)", events=[ALARM])
    task = {line: parse_line(LINES[line]) for line in lines}
    return replace(made, task=task, priorities=priorities or {})


ALL = bounded(*LINES)
PLANNER = Planner(ALL, lambda origin, goal: 4.0)


@dataclass
class Flown:
    """A flight: what a record has of it, and what was told of bounds."""

    steps: list[tuple[float, MissionEventChanged | PositionLeft]] = field(default_factory=list)
    told: set[tuple[str, int]] = field(default_factory=set)
    changes: list[TaskChange] = field(default_factory=list)
    until_s: float = 0.0
    unread: list[PositionLeft] = field(default_factory=list)

    @property
    def positions(self) -> list[PositionLeft]:
        """With the one that was reached last, which no record has."""
        left = [step for _, step in self.steps if isinstance(step, PositionLeft)]
        return left + self.unread

    @property
    def recorded(self) -> TimedWord:
        return TimedWord(tuple(self.steps), self.until_s, frozenset(self.told))


class Pilot:
    """Flies at random: in each tick a skill goes on, ends or begins, and events may change."""

    def __init__(self, random: Random, planner: Planner) -> None:
        self.task = TaskState(planner)
        self.flown = Flown()
        self.task.on_change = self.flown.changes.append
        self._random = random
        self._tick = 200
        self._busy_until = self._idle_until = self._tick

    def fly(self, ticks: int) -> Flown:
        for _ in range(ticks):
            self._tick += 1
            self._now_s = round(self._tick * TICK_S, 3)
            self.task.word.now_s = self._now_s
            for conjunct in self.task.run_clocks(self._now_s).over:
                self.flown.told.add((conjunct.name, self.task.word.last_position))
            self._events()
            self._act()
        self.flown.until_s = self._now_s
        return self.flown

    def leave(self) -> None:
        """Leaves the position that was reached last, for those who are to know it."""
        self.task.leave()
        self.flown.unread = [_left(position) for position in self.task.word.left]

    def _events(self) -> None:
        for _ in range(2):
            if self._random.random() < 0.003:
                holds = ALARM.fact not in self.task.facts
                self.task.take(ALARM, holds)
                self.flown.steps.append((self._now_s, MissionEventChanged("alarm", holds)))

    def _act(self) -> None:
        task, random = self.task, self._random
        if task.running is not None and self._tick >= self._busy_until:
            if random.random() < 0.15:
                task.interrupt()
            else:
                task.complete(task.running, self._now_s)
            self._idle_until = self._tick + random.choice((0, 0, 0, 40, 200))
        if task.running is None and self._tick >= self._idle_until:
            choices = [a for a in task.problem()[0].actions if a.is_applicable(task.all_facts)]
            action = random.choice([a for a in choices if a is not WAIT])
            task.begin(action)
            self._busy_until = self._tick + random.randint(40, 160)
        for left in task.word.left:
            self.flown.steps.append((self._now_s, _left(left)))
            self.flown.told |= {(conjunct.name, left.number) for conjunct in left.violated}
        task.word.left.clear()


def _left(position: Position) -> PositionLeft:
    return PositionLeft(
        position.number,
        facts=tuple(position.facts),
        risen=tuple(position.risen),
        reached_s=position.reached_s,
        withdrawn=(),
        restarted=position.restarted,
        for_ever=False,
    )


def requests(flown: Flown, line: str, bound: TimeBound) -> list[tuple[float, int]]:
    """When something is asked for, and the first position that may answer it."""
    word = flown.positions
    match bound:
        case Within():
            return [(word[0].reached_s, 0)]
        case Revisit(goal):
            met = met_s(flown, goal)
            visited = [p for p in word if is_true(goal, p.facts)]
            visits = [(max(p.reached_s, met[p.number]), p.number + 1) for p in visited]
            return [(word[0].reached_s, 0), *visits]
        case Response(goal=goal) if line == "clear":
            asking_at = [p for p in word if "at(A)" in p.facts and not is_true(goal, p.facts)]
            return [(p.reached_s, p.number) for p in asking_at]
    asking, due = Asking(is_calm=line == "calm"), list(word)
    for time_s, step in [*flown.steps, (flown.until_s, None)]:
        if due and asking.here is None and due[0].reached_s <= time_s:
            asking.reach(due.pop(0))
        if isinstance(step, MissionEventChanged):
            asking.change(step.holds, time_s)
        elif step is not None:
            asking.leave(step)
    if asking.asked_s is not None:
        asking.found.append((asking.asked_s, len(word) - len(flown.unread)))
    return asking.found


class Asking:
    """What is asked for by `alarm`, or by `!alarm & at(A)`, along a flight."""

    def __init__(self, is_calm: bool) -> None:
        self.found: list[tuple[float, int]] = []
        self.asked_s: float | None = None
        self.here: PositionLeft | None = None
        self._is_calm, self._holds, self._has_risen, self._was_so = is_calm, False, False, False

    def _is_so(self) -> bool:
        has_alarm = self._holds or self._has_risen
        is_at_a = self.here is not None and "at(A)" in self.here.facts
        return is_at_a and not has_alarm if self._is_calm else has_alarm

    def reach(self, position: PositionLeft) -> None:
        self.here = position
        self._was_so = self._is_so()
        self.asked_s = self.asked_s if self._was_so else None

    def change(self, holds: bool, time_s: float) -> None:
        self._holds, self._has_risen = holds, self._has_risen or holds
        if self._is_so() and not self._was_so and time_s > 10.05:  # when the word begins
            self.asked_s = time_s
        self._was_so = self._is_so()
        self.asked_s = self.asked_s if self._was_so else None

    def leave(self, position: PositionLeft) -> None:
        has_alarm = "alarm" in position.facts
        is_so = not has_alarm and "at(A)" in position.facts if self._is_calm else has_alarm
        if is_so:
            since_s = position.reached_s if self.asked_s is None else self.asked_s
            self.found.append((since_s, position.number))
        self.asked_s, self.here, self._has_risen = None, None, False
        self._was_so = self._is_so()


class Meeting:
    """When positions with a goal meet it along a flight: where an event does, when it comes."""

    def __init__(self, goal: Formula) -> None:
        self.met_s: dict[int, float] = {}
        self.here: PositionLeft | None = None
        self._goal = goal
        self._holds = self._has_risen = self._was_met = False
        self._risen_s: float | None = None

    def _is_met(self) -> bool:
        facts = {f for f in (self.here.facts if self.here else ()) if f != "alarm"}
        return is_true(self._goal, facts | ({"alarm"} if self._holds or self._has_risen else set()))

    def reach(self, position: PositionLeft) -> None:
        self.here = position
        self._was_met = self._is_met()
        self._risen_s = self._risen_s if self._was_met else None
        since_s = position.reached_s if self._risen_s is None else self._risen_s
        self.met_s[position.number] = since_s

    def change(self, holds: bool, time_s: float) -> None:
        self._holds, self._has_risen = holds, self._has_risen or holds
        if self._is_met() and not self._was_met:
            self._risen_s = time_s
            if self.here is not None:
                self.met_s[self.here.number] = time_s
        self._was_met = self._is_met()
        self._risen_s = self._risen_s if self._was_met else None

    @property
    def met_s_on_the_way(self) -> float | None:
        return self._risen_s if self.here is None else None

    def leave(self) -> None:
        self.here, self._has_risen, self._risen_s = None, False, None
        self._was_met = self._is_met()


def met_s(flown: Flown, goal: Formula) -> dict[int, float]:
    """When each position with a goal meets it, also the one that was not reached in the end."""
    meeting, due = Meeting(goal), list(flown.positions)
    for time_s, step in [*flown.steps, (flown.until_s, None)]:
        if due and meeting.here is None and due[0].reached_s <= time_s:
            meeting.reach(due.pop(0))
        if isinstance(step, MissionEventChanged):
            meeting.change(step.holds, time_s)
        elif step is not None:
            meeting.leave()
    with_goal = {p.number for p in flown.positions if is_true(goal, p.facts)}
    found = {number: s for number, s in meeting.met_s.items() if number in with_goal}
    on_the_way = meeting.met_s_on_the_way
    return found if on_the_way is None else found | {len(flown.positions): on_the_way}


def violations(flown: Flown, line: str, bound: TimeBound) -> list[float]:
    """When something is too late for the first time."""
    late = []
    met = met_s(flown, bound.goal)
    for asked_s, first in requests(flown, line, bound):
        due_s = round(asked_s + bound.limit_ms / 1000, 3)
        answers_s = [met_at_s for number, met_at_s in met.items() if number >= first]
        if due_s < flown.until_s and not any(met_at_s <= due_s for met_at_s in answers_s):
            late.append(due_s)
    return sorted(late)[:1]


def is_true(formula: Formula, facts: Iterable[str]) -> bool:
    """Whether a formula without temporal operators holds where some facts do."""
    return holds(formula, (), (frozenset(facts),))


@pytest.mark.parametrize(
    "seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 250))]
)
def test_what_is_told_is_what_the_definition_says(seed: int) -> None:
    verdicts = set()
    for number in range(10):
        random = Random(1000 * seed + number)
        pilot = Pilot(random, PLANNER)
        flown = pilot.fly(1600)
        word = flown.recorded
        pilot.leave()
        for name, line in ALL.task.items():
            ((_, bound),) = parts(line)
            assert bound is not None
            told = {position for told_name, position in flown.told if told_name == name}
            late = violations(flown, name, bound)
            assert bool(told) is bool(late), (seed, number, name)
            if late:
                left = (p.number for t, p in flown.steps if p in flown.positions and t <= late[0])
                assert told == {max(left, default=0)}, (seed, number, name)
            assert set(word.overruns(bound, name)) == told, (seed, number, name)
            verdicts.add((name, bool(late)))
    assert len(verdicts) >= 5


def test_a_journal_brings_the_clocks_back() -> None:
    for seed in range(20):
        pilot = Pilot(Random(seed), PLANNER)
        flown = pilot.fly(random_length := Random(seed).randint(1, 1200))
        again = TaskState(PLANNER)
        replay = TaskReplay(again, PLANNER)
        for change in flown.changes:
            replay.make(change)
        for task in (pilot.task, again):
            task.word.now_s = 10 + random_length * TICK_S + 100.0
            task.interrupt()
        here, there = pilot.task.problem()[0], again.problem()[0]
        assert here.clocks_ms == there.clocks_ms
        assert here.automaton_states == there.automaton_states
        assert pilot.task.violated == again.violated


def waiting(task: TaskState, until_s: float) -> list[str]:
    """Time goes on; the lines that are told to be late meanwhile."""
    told = []
    now_s = task.word.now_s
    while now_s < until_s:
        now_s = round(now_s + TICK_S, 3)
        task.word.now_s = now_s
        told += [conjunct.name for conjunct in task.run_clocks(now_s).over]
    return told


def test_a_violated_line_has_no_plan_and_one_that_may_be_dropped_begins_anew() -> None:
    asked = bounded("first", "often", priorities={"often": 1})
    task = TaskState(Planner(asked, lambda origin, goal: 4.0))
    assert waiting(task, 19.0) == []
    assert task.problem()[0].clocks_ms == (18_950, 18_950)
    assert waiting(task, 26.0) == ["first", "often"]
    assert (task.violated, task.violated_kept) == (("first",), ("often",))
    first, often = task.problem()[0].automaton_states
    assert not first and often
    assert task.problem()[0].clocks_ms[1] == 0  # as if it began anew
    assert task.drop(["often"]) == ()
    assert task.violated_kept == ()
    assert task.drop([]) == ("often",)
    assert waiting(task, 40.0) == []  # not before a position was left
    move = next(a for a in task.problem()[0].actions if a.name == "move(H, B)")
    task.begin(move)
    assert waiting(task, 64.9) == []
    assert task.problem()[0].clocks_ms[1] == 0  # as from where it was left
    assert waiting(task, 66.0) == ["often"]


def test_an_event_makes_a_bounded_line_begin_anew() -> None:
    again = event("again", restarts=["first"])
    asked = replace(bounded("first"), events={"again": again})
    task = TaskState(Planner(asked, lambda origin, goal: 4.0))
    assert waiting(task, 21.0) == ["first"]
    task.take(again, True)
    assert task.violated == () and task.problem()[0].clocks_ms == (0,)
    task.leave()
    assert waiting(task, 41.0) == []
    assert waiting(task, 41.1) == ["first"]


def test_an_answer_that_is_due_is_due_in_the_next_plan() -> None:
    task = TaskState(Planner(bounded("answer"), lambda origin, goal: 4.0))
    waiting(task, 5.0)
    task.begin(next(a for a in task.problem()[0].actions if a.name == "move(H, A)"))
    waiting(task, 7.0)
    task.take(ALARM, True)
    task.take(ALARM, False)
    waiting(task, 10.0)
    task.interrupt()
    problem = task.problem()[0]
    assert problem.unread == {"alarm"}
    assert problem.clocks_ms == (3000,)


def test_who_stands_where_it_is_to_be_is_not_late() -> None:
    task = TaskState(Planner(bounded("first"), lambda origin, goal: 4.0))
    waiting(task, 5.0)
    move = next(a for a in task.problem()[0].actions if a.name == "move(H, B)")
    task.begin(move)
    waiting(task, 15.0)
    task.complete(move, 15.0)
    assert waiting(task, 60.0) == []
    assert task.problem()[0].clocks_ms == (None,)


def test_an_event_from_before_the_task_begins_asks_from_then_on() -> None:
    """It came in the take-off: neither the flight nor the audit counts the time until it flies."""
    task = TaskState(Planner(bounded("answer"), lambda origin, goal: 4.0))
    task.take(ALARM, True)
    task.take(ALARM, False)
    task.word.now_s = 10.0
    assert waiting(task, 24.0) == []
    asked = PositionLeft(0, ("alarm", "at(A)"), ("alarm",), 10.0, (), (), False, ())
    met = PositionLeft(1, ("at(B)",), (), 24.0, (), (), False, ())
    rose, fell = (MissionEventChanged("alarm", holds) for holds in (True, False))
    word = TimedWord(((3.0, rose), (3.0, fell), (12.0, asked), (30.0, met)), 30.0)
    ((_, bound),) = parts(parse_line(LINES["answer"]))
    assert bound is not None and word.overruns(bound, "answer") == ()


def test_a_line_that_is_taken_up_anew_has_run_over_before() -> None:
    """It is not begun anew by the event that has risen between, long before."""
    ((_, bound),) = parts(parse_line("F[<=20s] at(A)"))
    home = PositionLeft(0, ("at(H)",), (), 2.0, (), (), False, ())
    late = PositionLeft(1, ("alarm", "at(A)"), ("alarm",), 25.0, (), ("soon",), False, ())
    rose, fell = (MissionEventChanged("alarm", holds) for holds in (True, False))
    taken_up = LineTakenUp("soon", anew=True)
    steps = ((3.0, home), (5.0, rose), (5.0, fell), (23.0, taken_up), (26.0, late))
    word = TimedWord(steps, 30.0, frozenset({("soon", 0)}))
    assert bound is not None and word.overruns(bound, "soon") == (0,)
