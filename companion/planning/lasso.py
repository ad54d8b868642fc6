"""The planning problem, and the lasso that solves it.

A lasso is a finite prefix of actions and a loop that is repeated for ever (Section III-A). Its
word is the sequence of facts at the positions it passes.

A plan is made for the positions to come, so in a problem the automata have read the present
one. The product rule of the paper reads a position when it is left; that is the same run half
a step later, but a loop that closes there needs a step more: for "eventually at A" it flies to
A, and then away, before it may rest.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from companion.flight_events.plans import PlannedAction, PlannedLasso
from companion.flight_events.writing import json_of
from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.formula import Formula, atoms
from companion.ltl.time_bounds import TimeBound
from companion.mission.facts import Fact
from companion.planning.domain import WAIT, Action
from companion.planning.objective import Objective

Letter = frozenset[Fact]
"""The facts that hold at one position."""


@dataclass(frozen=True)
class Conjunct:
    """One named part of the task with its automaton.

    Attributes:
        formula: what its automaton reads: without its bound in time.
        bound: None if it has none.
    """

    name: str
    formula: Formula
    automaton: BuchiAutomaton
    bound: TimeBound | None = None

    @property
    def text(self) -> str:
        """What it says, with its bound."""
        return str(self.bound or self.formula)

    @cached_property
    def facts(self) -> frozenset[Fact]:
        """The facts that it speaks of."""
        return frozenset(map(Fact.parse, atoms(self.formula)))


@dataclass(frozen=True)
class Energy:
    """The energy of a problem, in whole units.

    Attributes:
        level: what is there now.
        floors: by place, `here` among them: the reserve, and what it takes to land at a safe one.
        rests: by place, what has to be there where a plan comes to rest, which is to land.
        rest: what a step of rest takes in the air.
        percents: by level, the charge of the battery.
        ready: by place, what has to be left there so that lines are ready; empty without any.
        is_short: the way into a loop keeps the floors alone, for want of what lines that are ready
            keep: it was used up, by an answer or by the wind.
        lent: what of `level` is not there: it is taken from the reserve.
        lendable: what may be taken from it where there is no plan without: it lasts for a landing
            at a dock, and not for charging there.
    """

    level: int
    floors: Mapping[str, int]
    rests: Mapping[str, int]
    rest: int
    percents: Sequence[float]
    ready: Mapping[str, int] = field(default_factory=dict)
    is_short: bool = False
    lent: int = 0
    lendable: int = 0

    def floor(self, place: str, in_loop: bool = True) -> int | None:
        """What has to be left at a place; None where no safe one can be reached.

        Args:
            place: where the vehicle is.
            in_loop: in a loop, not on the way into it.
        """
        floor = self.floors.get(place)
        if floor is None or (self.is_short and not in_loop):
            return floor
        return max(floor, self.ready.get(place, 0))


@dataclass(frozen=True)
class Problem:
    """A planning problem; between replans the first two fields stay as they are.

    Attributes:
        actions: instances of skills; their order breaks ties.
        conjuncts: the task.
        facts: what holds now.
        automaton_states: per conjunct, the states its automaton may be in after reading the
            history up to and including the present position.
        withdrawn: beliefs that were disproved and would be facts otherwise.
        unread: events that have risen since the last letter was read, and have fallen again: the
            first letter of a plan has them, and no other one. The automata know
            (unread_rises.py).
        waiting_since_ms: per conjunct, when the acceptance mark was met that has waited longest
            since; in flight time, of which only differences matter. Empty while nothing has been
            waited for: before the first skill of a flight is completed.
        energy: None where plans know of none.
        clocks_ms: per conjunct, what its clock shows after the present position was read; None: it
            stands still, or there is no bound. Empty if no conjunct has one.
        with_ruled_out: the actions, and between them those that lines to be ready rule out
            (readiness.py). Empty if none is to be ready.
    """

    actions: tuple[Action, ...]
    conjuncts: tuple[Conjunct, ...]
    facts: frozenset[Fact]
    automaton_states: tuple[frozenset[int], ...]
    withdrawn: frozenset[Fact] = frozenset()
    unread: frozenset[Fact] = frozenset()
    waiting_since_ms: tuple[int, ...] = ()
    energy: Energy | None = None
    clocks_ms: tuple[int | None, ...] = ()
    with_ruled_out: tuple[Action, ...] = ()

    def only(self, indices: Sequence[int]) -> Problem:
        """The same with some of the conjuncts alone."""
        since_ms, clocks_ms = self.waiting_since_ms, self.clocks_ms
        return replace(
            self,
            conjuncts=tuple(self.conjuncts[i] for i in indices),
            automaton_states=tuple(self.automaton_states[i] for i in indices),
            waiting_since_ms=tuple(since_ms[i] for i in indices) if since_ms else (),
            clocks_ms=tuple(clocks_ms[i] for i in indices) if clocks_ms else (),
        )


@dataclass(frozen=True)
class Lasso:
    """An infinite plan: `prefix` once, then `loop` for ever, which is never empty."""

    prefix: tuple[Action, ...]
    loop: tuple[Action, ...]

    @property
    def prefix_cost_ms(self) -> int:
        """Cost of the prefix."""
        return sum(a.cost_ms for a in self.prefix)

    @property
    def lap_cost_ms(self) -> int:
        """Cost of one lap of the loop."""
        return sum(a.cost_ms for a in self.loop)

    @property
    def ends_at_rest(self) -> bool:
        """Whether the loop is nothing but rest: after the prefix the task is done."""
        return all(a is WAIT for a in self.loop)

    def rest(self, start: int) -> Lasso:
        """What is left of it from position `start` on.

        >>> str(Lasso((), (WAIT,)).rest(3))
        '(wait)^w'
        """
        if start <= len(self.prefix):
            return Lasso(self.prefix[start:], self.loop)
        flown = (start - len(self.prefix)) % len(self.loop)
        return Lasso(self.loop[flown:] if flown else (), self.loop)

    def names(self, count: int, start: int = 0) -> list[str]:
        """The names of `count` actions from position `start` on.

        >>> lap = Lasso((), (WAIT,))
        >>> lap.names(2, start=7)
        ['wait', 'wait']
        """
        actions = itertools.chain(self.prefix, itertools.cycle(self.loop))
        return [a.name for a in itertools.islice(actions, start, start + count)]

    def __str__(self) -> str:
        prefix = ", ".join(a.name for a in self.prefix)
        loop = ", ".join(a.name for a in self.loop)
        return f"{prefix + ', ' if prefix else ''}({loop})^w"

    @property
    def planned(self) -> PlannedLasso:
        """Prefix and loop with costs, as they are told and recorded."""
        return PlannedLasso(
            prefix=tuple(_planned(a) for a in self.prefix),
            loop=tuple(_planned(a) for a in self.loop),
            prefix_cost_s=self.prefix_cost_ms / 1000,
            lap_cost_s=self.lap_cost_ms / 1000,
        )


def _planned(action: Action) -> PlannedAction:
    return PlannedAction(action.name, action.skill, action.arguments, action.cost_ms / 1000)


@dataclass(frozen=True, slots=True)
class DroppedLine:
    """A line of the task that a plan does not keep.

    Attributes:
        reason: in words.
    """

    line: str
    reason: str

    def __str__(self) -> str:
        return f"{self.line}: {self.reason}"


@dataclass(frozen=True, slots=True)
class ChosenPlan:
    """A plan to fly.

    Attributes:
        dropped: lines of the task that it does not keep.
    """

    lasso: Lasso
    dropped: tuple[DroppedLine, ...] = ()

    @property
    def lines_dropped(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(each.line for each in self.dropped)


@dataclass(frozen=True)
class Solution:
    """A plan: a lasso, and what is known of its quality.

    Attributes:
        cost_ms: the objective: the lap, or prefix and lap together, or the bottleneck.
        bound_ms: no lasso has a lower objective; 0 if nothing is known.
        engine: name of the planner that found it.
        has_best_prefix: whether it is proved that no lasso with this lap has a shorter prefix.
        dropped: lines of the task that the plan does not keep, the most important one first.
    """

    lasso: Lasso
    objective: Objective
    cost_ms: int
    bound_ms: int
    engine: str
    has_best_prefix: bool = False
    dropped: tuple[DroppedLine, ...] = ()

    @property
    def prefix(self) -> tuple[Action, ...]:
        """The actions that are done once, first."""
        return self.lasso.prefix

    @property
    def loop(self) -> tuple[Action, ...]:
        """The actions that are then repeated for ever, at least one."""
        return self.lasso.loop

    @property
    def prefix_cost_s(self) -> float:
        """Cost of the prefix, seconds."""
        return self.lasso.prefix_cost_ms / 1000

    @property
    def lap_cost_s(self) -> float:
        """Cost of one lap of the loop, seconds."""
        return self.lasso.lap_cost_ms / 1000

    @property
    def cost_s(self) -> float:
        """The objective, seconds."""
        return self.cost_ms / 1000

    @property
    def bound_s(self) -> float | None:
        """What no plan's objective is below, seconds; None if nothing is known."""
        return self.bound_ms / 1000 if self.bound_ms else None

    def __str__(self) -> str:
        return str(self.lasso)

    @property
    def is_optimal(self) -> bool:
        """Whether it is proved that no lasso is better.

        Of equal laps the one with the shorter prefix is better; other objectives are one figure.
        """
        is_least = self.cost_ms <= self.bound_ms
        return is_least and (self.has_best_prefix or self.objective is not Objective.LAP)

    def as_json(self) -> dict[str, object]:
        """The lasso and its quality, as `companion plan --json` gives them."""
        return {
            **json_of(self.lasso.planned),
            "objective": self.objective.value,
            "cost_s": self.cost_s,
            "bound_s": self.bound_s,
            "optimal": self.is_optimal,
            "engine": self.engine,
            "dropped": [{"line": each.line, "reason": each.reason} for each in self.dropped],
            "reason": None,
        }


def word(problem: Problem, lasso: Lasso) -> tuple[list[Letter], list[Letter]]:
    """The letters that a lasso appends to the history: once, and then in each lap.

    Where the first letter has unread events and there is no prefix, the first lap is read once.
    """
    letters: list[Letter] = []
    facts = problem.facts
    for action in (*lasso.prefix, *lasso.loop):
        facts = action.apply(facts)
        letters.append(facts)
    cut = len(lasso.prefix)
    once, lap = letters[:cut], letters[cut:]
    if problem.unread:
        first, *rest = once or lap
        once = [first | problem.unread, *rest]
    return once, lap
