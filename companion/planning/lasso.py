"""The planning problem, and the lasso that solves it.

A lasso is a finite prefix of actions and a loop that is repeated for ever (Section III-A). Its word
is the sequence of facts at the positions that it passes.

A plan is about the positions to come: in a problem, the automata have already read the present one.
In the paper's product, a position is read when it is left. That is the same run half a step later,
but a loop that closes there needs one more step: for "eventually at A" the paper's plan flies to A
and then away before it may rest.
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
from companion.ltl.literals import Literals, literals
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
        formula: what its automaton reads: the formula without its time bound.
        bound: the time bound; None if there is none.
    """

    name: str
    formula: Formula
    automaton: BuchiAutomaton
    bound: TimeBound | None = None

    @property
    def text(self) -> str:
        """The formula with its bound."""
        return str(self.bound or self.formula)

    @cached_property
    def facts(self) -> frozenset[Fact]:
        """The facts that the formula mentions."""
        return frozenset(map(Fact.parse, atoms(self.formula)))

    @cached_property
    def literals(self) -> Literals:
        """The propositions that the formula demands to be true, and to be false."""
        return literals(self.formula)


@dataclass(frozen=True)
class Energy:
    """The energy of a problem, in whole units.

    Attributes:
        level: the level now.
        floors: per place, including `here`: the reserve, and the energy to land at a safe place.
        rests: per place, the level needed where a plan comes to rest, which means to land.
        rest: what a step of rest takes in the air.
        percents: per level, the charge of the battery.
        ready: per place, the level that must remain so that lines are ready; empty without any.
        is_short: the way into the loop keeps only the floors, because the level is too low for what
            ready lines keep: an answer to an event, or wind, used it up.
        borrowed: the part of `level` that is borrowed from the reserve.
        borrowable: how much may be borrowed from the reserve if there is no plan without: enough to
            land at a dock, but not for charging there.
    """

    level: int
    floors: Mapping[str, int]
    rests: Mapping[str, int]
    rest: int
    percents: Sequence[float]
    ready: Mapping[str, int] = field(default_factory=dict)
    is_short: bool = False
    borrowed: int = 0
    borrowable: int = 0

    def floor(self, place: str, in_loop: bool = True) -> int | None:
        """The level that must remain at a place; None if no safe place can be reached from there.

        Args:
            place: where the vehicle is.
            in_loop: whether this is in the loop, not on the way into it.
        """
        floor = self.floors.get(place)
        if floor is None or (self.is_short and not in_loop):
            return floor
        return max(floor, self.ready.get(place, 0))


@dataclass(frozen=True)
class Problem:
    """A planning problem. `actions` and `conjuncts` stay the same between replans.

    Attributes:
        actions: instances of skills; their order decides ties.
        conjuncts: the task.
        facts: what holds now.
        automaton_states: per conjunct, the possible states of its automaton after reading the
            history, including the present position.
        withdrawn: beliefs that were disproved, and that would otherwise be facts.
        unread: events that have risen since the last letter was read and have fallen again. Only
            the first letter of a plan contains them, and only the automata know of them
            (unread_rises.py).
        waiting_since_ms: per conjunct, the time at which its longest-waiting acceptance mark was
            last met; in flight time, of which only differences matter. Empty before the first skill
            of a flight is completed.
        energy: None if plans do not consider energy.
        clocks_ms: per conjunct, what its clock shows after the present position was read; None if
            it stands still or there is no bound. Empty if no conjunct has a bound.
        with_ruled_out: all actions in their order, including those that ready lines rule out
            (readiness.py). Empty if no line has to be ready.
        barred: names of actions left out because it is not known whether they were done.
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
    barred: frozenset[str] = frozenset()

    def only(self, indices: Sequence[int]) -> Problem:
        """The same problem with only some of the conjuncts."""
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
    """An infinite plan: `prefix` once, then `loop` for ever. The loop is never empty."""

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
        """Whether the loop consists of rest only: after the prefix the task is done."""
        return all(a is WAIT for a in self.loop)

    def rest(self, start: int) -> Lasso:
        """The rest of the plan from position `start` on.

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
        """Prefix and loop with costs, as they are reported and recorded."""
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
        reason: why, in words.
    """

    line: str
    reason: str

    def __str__(self) -> str:
        return f"{self.line}: {self.reason}"


@dataclass(frozen=True, slots=True)
class ChosenPlan:
    """A plan that is to be flown.

    Attributes:
        dropped: lines of the task that the plan does not keep.
    """

    lasso: Lasso
    dropped: tuple[DroppedLine, ...] = ()

    @property
    def lines_dropped(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(each.line for each in self.dropped)


@dataclass(frozen=True)
class Solution:
    """A lasso, and what is known of its quality.

    Attributes:
        cost_ms: the value of the objective: the lap, prefix and lap together, or the bottleneck.
        bound_ms: a lower bound of the objective over all lassos; 0 if nothing is known.
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
        """The actions that are done once, at the beginning."""
        return self.lasso.prefix

    @property
    def loop(self) -> tuple[Action, ...]:
        """The actions that are then repeated for ever; at least one."""
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
        """The value of the objective, seconds."""
        return self.cost_ms / 1000

    @property
    def bound_s(self) -> float | None:
        """A lower bound of the objective over all plans, seconds; None if nothing is known."""
        return self.bound_ms / 1000 if self.bound_ms else None

    def __str__(self) -> str:
        return str(self.lasso)

    @property
    def is_optimal(self) -> bool:
        """Whether it is proved that no lasso is better.

        Of equal laps, the one with the shorter prefix is better; other objectives are one number.
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
    """The letters that a lasso appends to the history: first once, then in each lap.

    If there is no prefix and the first letter has unread events, the first lap is returned as the
    first part.
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
