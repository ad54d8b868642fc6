"""Lines that must hold whenever their event comes: which actions a plan may have because of them.

When the event comes, the present action is finished first. Then the vehicle flies to the place that
the line asks for. So an action is allowed if its duration, and the shortest way from its end to
that place, fit into the limit of the line. The rule concerns single actions: it removes some before
any search. Every action on the shortest way keeps the rule by itself.

If the vehicle was driven to a place from which no action is allowed, those actions are allowed that
lead to a place from which the rule can be kept again.

With a battery, each place also keeps the energy to fly to that place and on to a dock
(`energy/ready_levels.py`). A charge ends when the event comes, so it takes no longer than to land
and take off.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from companion.ltl.time_bounds import Response
from companion.ltl.timed_formula import parts
from companion.mission.facts import HERE, Fact, at
from companion.mission.model import Mission
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import WAIT, Action, duration_ms, ends_of
from companion.planning.energy.ready_levels import FlightBetween, Pad, kept_at, ready_levels
from companion.planning.lasso import Energy, Problem
from companion.slices import spent

_ACTION_US = 3


@dataclass(frozen=True, slots=True)
class ReadyLine:
    """A line that must hold whenever its event comes.

    Attributes:
        place: where the line's goal is.
    """

    name: str
    bound: Response
    place: str


def ready_lines(mission: Mission) -> tuple[ReadyLine, ...]:
    """The ready lines of a mission."""
    found = []
    for name in mission.ready:
        for _, bound in parts(mission.task[name]):
            if isinstance(bound, Response):
                place = Fact.parse(bound.goal.atom).arguments[0]
                found.append(ReadyLine(name, bound, place))
    return tuple(found)


class Readiness:
    """Decides which actions are allowed.

    Args:
        lines: the ready lines.
    """

    def __init__(self, lines: Sequence[ReadyLine]) -> None:
        self.lines = lines
        self._last: tuple[tuple[Action, ...], frozenset[Fact]] = ((), frozenset())
        self._kept: tuple[Action, ...] = ()
        self._asked: tuple[tuple[Action, ...], frozenset[Fact], Mapping[str, int]] | None = None
        self._on_battery: tuple[tuple[Action, ...], Mapping[str, int]] = ((), {})

    def allowed(
        self, actions: tuple[Action, ...], withdrawn: frozenset[Fact] = frozenset()
    ) -> tuple[Action, ...]:
        """The allowed actions, in their order.

        Args:
            actions: all actions.
            withdrawn: beliefs that were disproved; ways that need them do not count.
        """
        if self.lines and self._last != (actions, withdrawn):
            self._last, self._kept = (actions, withdrawn), actions
            for line in self.lines:
                spent(_ACTION_US * len(actions))
                ways_ms = _ways_ms(actions, withdrawn, line.place)
                self._kept = tuple(_allowed(line, self._kept, ways_ms))
        return self._kept if self.lines else actions

    def on_battery(
        self, actions: tuple[Action, ...], energy: Energy, withdrawn: frozenset[Fact] = frozenset()
    ) -> tuple[tuple[Action, ...], Energy]:
        """Actions and energy with the levels that must remain at places and docks.

        Args:
            actions: the allowed actions.
            energy: the energy of a problem.
            withdrawn: beliefs that were disproved; ways and docks that need them do not count.
        """
        if not self.lines:
            return actions, energy
        asked = actions, withdrawn, energy.floors
        if self._asked != asked:
            self._asked, self._on_battery = asked, self._kept_on_battery(actions, withdrawn, energy)
        kept, levels = self._on_battery
        return kept, replace(energy, ready=levels)

    def _kept_on_battery(
        self, actions: tuple[Action, ...], withdrawn: frozenset[Fact], energy: Energy
    ) -> tuple[tuple[Action, ...], Mapping[str, int]]:
        spent(_ACTION_US * len(actions))
        pads = dict(_pads(actions))
        known = [a for a in actions if ends_of(a)[0] != HERE]  # nobody waits for an event at `here`
        flights = list(_flights(known))
        believed = list(_flights(a for a in known if not a.assumes & withdrawn))
        open_ = [pad for n, pad in pads.items() if not actions[n].assumes & withdrawn]
        answers = [line.place for line in self.lines]
        levels = ready_levels(answers, believed, open_, energy)
        kept = list(actions)
        for number, pad in pads.items():
            kept[number] = replace(kept[number], charger=kept_at(pad, flights, levels))
        return tuple(kept), levels


def most_kept(lines: Sequence[ReadyLine], energy: Energy) -> str:
    """The largest charge that ready lines keep, in words."""
    more = {place: level - energy.floors[place] for place, level in energy.ready.items()}
    place = max(more, key=lambda each: more[each])
    names = dict.fromkeys(line.name for line in lines)
    answers = dict.fromkeys(line.place for line in lines)
    return (
        f"without ready: there would be a plan; for {', '.join(names)} {place} keeps "
        f"{more[place] / UNITS_PER_WH:.2f} Wh more than it takes to land at a safe place: for "
        f"the way to {' or '.join(answers)}, and on to a dock"
    )


def ruled_out(problem: Problem) -> frozenset[str]:
    """The names of the actions that a problem lacks because lines have to be ready."""
    names = frozenset(action.name for action in problem.with_ruled_out)
    return names.difference(action.name for action in problem.actions)


def too_far(lines: Sequence[ReadyLine], problem: Problem) -> tuple[str, ...]:
    """The places and docks that no action may lead to because lines have to be ready, in words."""
    found = []
    for line in lines:
        ways_ms = _ways_ms(problem.with_ruled_out, frozenset(), line.place)
        nearest: dict[tuple[str, bool], tuple[int, Action]] = {}
        for action in problem.with_ruled_out:
            origin, end = ends_of(action)
            charges = action.charger is not None
            if end is not None and (origin != end or charges) and origin != HERE:
                way_ms, key = duration_ms(action) + ways_ms.get(end, math.inf), (end, charges)
                if math.isfinite(way_ms) and way_ms < nearest.get(key, (math.inf, action))[0]:
                    nearest[key] = int(way_ms), action
        for (place, _), (way_ms, action) in nearest.items():
            if way_ms > line.bound.planned_ms:
                found.append(
                    f"{place} is too far for {line.name} to be ready: {action.name} and the "
                    f"way to {line.place} take {way_ms / 1000:.1f} s, a plan has "
                    f"{line.bound.planned_ms / 1000:g} s"
                )
    return tuple(found)


def _allowed(
    line: ReadyLine, actions: Sequence[Action], ways_ms: Mapping[str, int]
) -> Iterator[Action]:
    limit_ms = line.bound.planned_ms
    departures = [action for action in actions if ends_of(action)[0] == HERE]
    can_depart = any(_is_in_time(action, ways_ms, limit_ms) for action in departures)
    for action in actions:
        origin, end = ends_of(action)
        if action is WAIT:
            yield action
        elif end is None:  # done anywhere: not where the way is too long
            far = {at(p) for p, ms in ways_ms.items() if duration_ms(action) + ms > limit_ms}
            yield replace(action, forbids=action.forbids | far) if far else action
        elif _is_in_time(action, ways_ms, limit_ms):
            yield action
        elif origin == HERE and not can_depart and ways_ms.get(end, math.inf) <= limit_ms:
            yield action


def _is_in_time(action: Action, ways_ms: Mapping[str, int], limit_ms: int) -> bool:
    return duration_ms(action) + ways_ms.get(ends_of(action)[1] or "", math.inf) <= limit_ms


def _flights(actions: Iterable[Action]) -> Iterator[FlightBetween]:
    """The actions that lead from one place to another, except those that charge."""
    for action in actions:
        origin, end = ends_of(action)
        if origin and end and origin != end and action.charger is None:
            yield FlightBetween(origin, end, duration_ms(action), action.drain)


def _pads(actions: Sequence[Action]) -> Iterator[tuple[int, Pad]]:
    """The charges among some actions, with their indices."""
    for number, action in enumerate(actions):
        origin, dock = ends_of(action)
        if action.charger is not None and origin and dock:
            yield number, Pad(origin, dock, action.charger)


def _ways_ms(actions: Sequence[Action], withdrawn: frozenset[Fact], place: str) -> dict[str, int]:
    """From each place, the least duration of actions to a given place; absent without a way."""
    into: dict[str, list[tuple[str, int]]] = defaultdict(list)
    for origin, end, way_ms, _ in _flights(a for a in actions if not a.assumes & withdrawn):
        into[end].append((origin, way_ms))
    found: dict[str, int] = {}
    pending = [(0, place)]
    while pending:
        way_ms, name = heapq.heappop(pending)
        if name not in found:
            found[name] = way_ms
            for origin, more_ms in into[name]:
                heapq.heappush(pending, (way_ms + more_ms, origin))
    return found
