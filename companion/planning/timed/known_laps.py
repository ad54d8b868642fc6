"""Laps that were found before. In flight they are tried first, and mostly nothing else is tried.

A replan, at another place and with other clocks, mostly needs only a path into the lap that was
flown. If costs have changed since, another lap may be better; then the known lap is used if no
other is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from companion.planning.domain import Action
from companion.planning.lasso import Problem
from companion.planning.timed.charge_levels import charging
from companion.planning.timed.component import TimedComponent
from companion.planning.timed.lapless import LaplessComponents
from companion.planning.timed.laps import TimedLap, lap_of
from companion.planning.timed.timed_product import TimedProduct
from companion.planning.timed.timed_step import TimedStep

MOST_KNOWN = 8

_Charge = tuple[int, int] | None
_KnownLap = tuple[tuple[str, _Charge], ...]
"""Names of actions, and how each charges."""
_ByAction = dict[int, dict[int, list[tuple[TimedStep, int]]]]


class _Path(NamedTuple):
    """A step, and the steps before it."""

    last: TimedStep
    before: _Path | None

    @property
    def steps(self) -> list[TimedStep]:
        """The steps from the first one on."""
        found, here = list[TimedStep](), self
        while True:
            found.append(here.last)
            if here.before is None:
                return found[::-1]
            here = here.before


class KnownLaps:
    """The known laps of one mission.

    Attributes:
        are_best: whether they were found with the present costs.
        lapless: the components in which no lap was found.
    """

    def __init__(self) -> None:
        self._known: list[_KnownLap] = []
        self.are_best = True
        self.lapless = LaplessComponents()

    def copied(self) -> KnownLaps:
        """An independent copy."""
        others = KnownLaps()
        others._known, others.are_best = [*self._known], self.are_best
        others.lapless = self.lapless.copied()
        return others

    def keep(self, problem: Problem, lap: TimedLap) -> None:
        """Adds a lap in the product of a problem."""
        self._keep(tuple((problem.actions[s.action].name, s.charge) for s in lap.steps))

    def keep_loop(self, loop: Sequence[Action]) -> None:
        """Adds the loop of a plan made for the battery only, which charges from floors on."""
        self._keep(tuple((action.name, _charge_of(action)) for action in loop))

    def _keep(self, steps: _KnownLap) -> None:
        others = [other for other in self._known if other != steps]
        self._known = [steps, *others][:MOST_KNOWN]

    def within(
        self, problem: Problem, graph: TimedProduct, parts: Sequence[TimedComponent]
    ) -> list[TimedLap]:
        """The known laps that exist in some components, the shortest first."""
        if not self._known:
            return []
        numbers = {action.name: number for number, action in enumerate(problem.actions)}
        known = [
            [(numbers[name], charge) for name, charge in each]
            for each in self._known
            if all(name in numbers for name, _ in each)
        ]
        found = _found_in(parts, graph, problem.actions, known)
        return sorted(found, key=lambda lap: lap.cost_ms)


def elsewhere(
    laps: Sequence[TimedLap],
    problem: Problem,
    graph: TimedProduct,
    parts: Sequence[TimedComponent],
) -> Iterator[TimedLap]:
    """The laps in every component in which the same actions form a lap.

    Components differ by what is done once and for all, often by something that no line demands.
    """
    known = [[(step.action, step.charge) for step in lap.steps] for lap in laps]
    return _found_in(parts, graph, problem.actions, known)


def _found_in(
    parts: Sequence[TimedComponent],
    graph: TimedProduct,
    actions: Sequence[Action],
    known: Sequence[Sequence[tuple[int, _Charge]]],
) -> Iterator[TimedLap]:
    for part in parts:
        for steps in known:
            yield from _found_again(graph, part.by_action, actions, steps, part.all)


def _charge_of(action: Action) -> _Charge:
    if action.charger is None or action.charge_to is None:
        return None
    return action.charger.floor, action.charge_to


def _found_again(
    graph: TimedProduct,
    inside: _ByAction,
    actions: Sequence[Action],
    known: Sequence[tuple[int, _Charge]],
    every_mark: int,
) -> Iterator[TimedLap]:
    """A loop of actions as a lap in a component; nothing if it is no lap there.

    Args:
        graph: the product.
        inside: by state of the component and action, the steps within it and the marks that they
            meet.
        actions: the actions of the problem.
        known: the numbers of the actions, and how far they charge.
        every_mark: the marks that a lap has to meet.
    """
    for start in inside:
        steps = _round(inside, actions, known, start, every_mark)
        lap = None if steps is None else lap_of(graph, steps)
        if lap is not None:
            yield lap
            return


def _round(
    inside: _ByAction,
    actions: Sequence[Action],
    known: Sequence[tuple[int, _Charge]],
    start: int,
    every_mark: int,
) -> list[TimedStep] | None:
    """Steps of some actions from a state back to it that meet every mark; None without any.

    All runs of the automata are followed, because one action may lead to several states.
    """
    reached: dict[int, dict[int, _Path | None]] = {start: {0: None}}  # by state and marks met
    for number, charge in known:
        after: dict[int, dict[int, _Path | None]] = {}
        charger = actions[number].charger
        for here, paths in reached.items():
            for step, marks in inside.get(here, {}).get(number, ()):
                if charger is not None and charge is not None:
                    step = charging(step, charger, *charge)
                into = after.setdefault(step.end, {})
                for met, path in paths.items():
                    into.setdefault(met | marks, _Path(step, path))
        if not after:
            return None
        reached = after
    path = reached.get(start, {}).get(every_mark)
    return None if path is None else path.steps
