"""The levels at each place with which lines can stay ready on a battery.

When the event of a line comes, the vehicle finishes the present step, then flies the quickest route
to the place that the line demands, and on to a dock that charges. So each place keeps the energy
for both routes. A dock also keeps the energy to land there and to take off again, because a charge
ends when the event comes.

The search for laps only considers the levels at docks. So a dock keeps enough for each place before
it to keep its level. If the quickest route is also the one of least energy, that is what the dock
keeps for itself.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from companion.planning.charger import Charger
from companion.planning.lasso import Energy, Problem
from companion.slices import spent

_FLIGHT_US = 1.0


class FlightBetween(NamedTuple):
    """A route from one place to another."""

    origin: str
    goal: str
    time_ms: int
    drain: int


class Pad(NamedTuple):
    """A charge: the place where it begins (the dock, unless it includes a flight), and the dock."""

    origin: str
    dock: str
    charger: Charger


def ready_levels(
    answers: Sequence[str], flights: Sequence[FlightBetween], pads: Sequence[Pad], energy: Energy
) -> dict[str, int]:
    """By place, the level with which the vehicle can fly to each of some places, and on to a dock.

    If no dock is on the route, the vehicle lands at a safe place after its answer.

    Args:
        answers: the places that lines demand.
        flights: the flights that are believed possible.
        pads: the charges that are believed possible.
        energy: contains the floors.
    """
    docks = {pad.origin: pad.charger.floor for pad in pads}
    onward = _levels(docks, flights, energy.floors, by_time=False)
    found: dict[str, int] = {}
    for answer in answers:
        least = onward.get(answer, energy.floors.get(answer))
        begin = {} if least is None else {answer: least}
        for place, level in _levels(begin, flights, energy.floors, by_time=True).items():
            found[place] = max(level, found.get(place, 0))
    return found


def kept_at(pad: Pad, flights: Sequence[FlightBetween], levels: Mapping[str, int]) -> Charger:
    """A dock that keeps what lines need in order to be ready.

    Args:
        pad: the dock.
        flights: all flights of a plan.
        levels: by place, the level that it keeps.
    """
    called = pad.charger.take_off + levels.get(pad.dock, 0)
    charger = replace(pad.charger, called=called)
    drains = _levels({pad.origin: 0}, flights, {}, by_time=False)
    before = (levels[place] - drain for place, drain in drains.items() if place in levels)
    floor = max(charger.floor, charger.landing + called, *before)
    return replace(charger, floor=floor, bare=charger)


def is_cautious(problem: Problem) -> bool:
    """Whether some dock keeps more than it needs itself, because of places before it."""
    return any(
        charger.floor > max(charger.bare.floor, charger.landing + charger.called)
        for charger in (action.charger for action in problem.actions)
        if charger is not None and charger.bare is not None and charger.called is not None
    )


def without_ready(problem: Problem) -> Problem:
    """The problem without ready lines, as far as energy is concerned."""
    assert problem.energy is not None
    actions = (
        a if a.charger is None else replace(a, charger=a.charger.bare or a.charger)
        for a in problem.actions
    )
    return replace(problem, actions=tuple(actions), energy=replace(problem.energy, ready={}))


def _levels(
    begin: Mapping[str, int],
    flights: Sequence[FlightBetween],
    floors: Mapping[str, int],
    by_time: bool,
) -> dict[str, int]:
    """By place, the level with which some place can be reached with the level required there.

    Args:
        begin: by place, the level required there.
        flights: the flights.
        floors: by place, the lowest level allowed on the way.
        by_time: whether to use the quickest routes instead of those of least energy.
    """
    spent(_FLIGHT_US * len(flights))
    into: dict[str, list[FlightBetween]] = defaultdict(list)
    for flight in flights:
        into[flight.goal].append(flight)
    pending = [(0, level, place) for place, level in begin.items()]
    heapq.heapify(pending)
    found: dict[str, int] = {}
    while pending:
        time_ms, level, place = heapq.heappop(pending)
        if place in found:
            continue
        found[place] = level
        for origin, _, leg_ms, drain in into[place]:
            before = max(level + drain, floors.get(origin, 0))
            heapq.heappush(pending, (time_ms + leg_ms if by_time else 0, before, origin))
    return found
