"""Laps that keep all bounds for ever, and what their clocks may show where they are entered.

1. If the goal of a clock is met somewhere on a lap, the clock shows the same at the end of every
   lap, whatever it showed before the first one. So a lap can be flown for ever if it can be flown
   once with the clocks as it leaves them. For a revisit, this means: the time from the last visit
   of a lap to its end, plus the time from its beginning to the first visit, is within the limit.
2. If a lap meets no goal of a clock, that clock has to stand still.
3. A plan may enter a lap wherever each clock leaves enough time until its next goal.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import gt

from companion.planning.timed.timed_product import STANDS, Clocks, TimedProduct
from companion.planning.timed.timed_step import TimedStep
from companion.slices import spent

_STEP_US = 5.0


@dataclass(frozen=True, slots=True)
class TimedLap:
    """A lap that keeps all bounds for ever.

    Attributes:
        steps: from its beginning, which is also where the last step ends.
        cost_ms: the cost of all steps.
        latest: by place in `steps`, the most that each clock may show before the step.
        is_rest: whether it is a step of rest, for which the vehicle lands.
    """

    steps: tuple[TimedStep, ...]
    cost_ms: int
    latest: tuple[Clocks, ...]
    is_rest: bool = False

    def state(self, place: int) -> int:
        """The state where a step begins."""
        return self.steps[place - 1].end

    def admits(self, place: int, clocks: Clocks) -> bool:
        """Whether the lap can be entered before a step with these clocks."""
        return all(now <= last for now, last in zip(clocks, self.latest[place], strict=True))


def lap_of(graph: TimedProduct, steps: Sequence[TimedStep]) -> TimedLap | None:
    """Some steps back to their beginning as a lap; None if they break a bound."""
    spent(_STEP_US * len(steps) * len(graph.bounds))
    first = _flown(graph, graph.least, steps)
    if first is None:
        return None
    again = _flown(graph, first, steps)
    if again is None or any(map(gt, again, first)):
        return None
    return TimedLap(tuple(steps), sum(step.cost_ms for step in steps), latest_clocks(graph, steps))


def rest_of(graph: TimedProduct, step: TimedStep) -> TimedLap | None:
    """A step of rest as a lap; None if it breaks a bound."""
    if graph.charges is None:
        lap = lap_of(graph, [step])
        return None if lap is None else replace(lap, is_rest=True)
    landed = step._replace(drain=0)
    clocks = graph.after(graph.least, landed)
    again = None if clocks is None else graph.after(clocks, landed)
    if clocks is None or again is None or any(map(gt, again, clocks)):
        return None
    (latest,) = latest_clocks(graph, [landed])
    most = graph.charges.most_missing_at_rest(step.end)
    return TimedLap((step,), step.cost_ms, ((*latest[:-1], most),), is_rest=True)


def _flown(graph: TimedProduct, clocks: Clocks, steps: Sequence[TimedStep]) -> Clocks | None:
    for step in steps:
        after = graph.after(clocks, step)
        if after is None:
            return None
        clocks = after
    return clocks


def latest_clocks(graph: TimedProduct, steps: Sequence[TimedStep]) -> tuple[Clocks, ...]:
    """For each step of a lap, the most that each clock may show before it."""
    found: list[Clocks] = []
    latest = [STANDS] * len(graph.bounds)
    charges, missing = graph.charges, graph.limits_ms[-1]
    for step in (*steps, *steps)[::-1]:  # for goals that are met early in the next lap
        for clock, limit_ms in enumerate(graph.limits_ms[: len(latest)]):
            if graph.is_goal(clock, step.end):
                latest[clock] = limit_ms
            latest[clock] = max(STANDS, latest[clock] - step.duration_ms)
        if charges is not None:
            missing = charges.most_before(missing, step)
        found.append((*latest, missing) if charges is not None else tuple(latest))
    return tuple(found[::-1][: len(steps)])


class LapEntries:
    """Where some laps may be entered."""

    def __init__(self, laps: Sequence[TimedLap]) -> None:
        self._by_state: dict[int, list[tuple[TimedLap, int]]] = {}
        for lap in laps:
            for place in range(len(lap.steps)):
                self._by_state.setdefault(lap.state(place), []).append((lap, place))

    def at(self, state: int, clocks: Clocks) -> Iterator[tuple[TimedLap, int]]:
        """The laps that can be entered at a state with these clocks, and the places."""
        for lap, place in self._by_state.get(state, ()):
            if lap.admits(place, clocks):
                yield lap, place
