"""Lines that shall hold whenever their event may come: what a plan may do, so that they do.

Whatever is under way is finished first, and then the vehicle flies to the place that the line asks
for. So an action is allowed if what it takes and the shortest way from its end to that place fit
into the line's limit. This is a rule for single actions: it removes some before any search, and
every action on the shortest way keeps it by itself.

Where the vehicle was driven to a place from which no action is allowed, those that lead to where
the rule can be kept again are.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from companion.ltl.time_bounds import Response
from companion.ltl.timed_formula import parts
from companion.mission.facts import AT, HERE, Fact, at
from companion.mission.model import Mission
from companion.planning.domain import WAIT, Action, duration_ms
from companion.slices import spent

_ACTION_US = 3


@dataclass(frozen=True, slots=True)
class ReadyLine:
    """A line that shall hold whenever its event may come.

    Attributes:
        place: where its answer is.
    """

    name: str
    bound: Response
    place: str


def ready_lines(mission: Mission) -> tuple[ReadyLine, ...]:
    """Those of a mission."""
    found = []
    for name in mission.ready:
        for _, bound in parts(mission.task[name]):
            if isinstance(bound, Response):
                place = Fact.parse(bound.goal.atom).arguments[0]
                found.append(ReadyLine(name, bound, place))
    return tuple(found)


class Readiness:
    """Which actions are allowed.

    Args:
        mission: whose lines shall hold.
    """

    def __init__(self, mission: Mission) -> None:
        self.lines = ready_lines(mission)
        self._last: tuple[tuple[Action, ...], frozenset[Fact]] = ((), frozenset())
        self._kept: tuple[Action, ...] = ()

    def allowed(
        self, actions: tuple[Action, ...], withdrawn: frozenset[Fact] = frozenset()
    ) -> tuple[Action, ...]:
        """The actions that a plan may have, in their order.

        Args:
            actions: all that there are.
            withdrawn: beliefs that were disproved: ways that need them are none.
        """
        if self.lines and self._last != (actions, withdrawn):
            self._last, self._kept = (actions, withdrawn), actions
            for line in self.lines:
                spent(_ACTION_US * len(actions))
                ways_ms = _ways_ms(actions, withdrawn, line.place)
                self._kept = tuple(_allowed(line, self._kept, ways_ms))
        return self._kept if self.lines else actions

    @property
    def too_far(self) -> tuple[str, ...]:
        """The places that no action may lead to, in words, among those that were asked for last."""
        actions, _ = self._last
        found = []
        for line in self.lines:
            ways_ms = _ways_ms(actions, frozenset(), line.place)
            nearest: dict[str, tuple[int, Action]] = {}
            for action in actions:
                origin, end = _ends(action)
                if end is not None and origin not in (end, HERE):
                    way_ms = duration_ms(action) + ways_ms.get(end, math.inf)
                    if math.isfinite(way_ms) and way_ms < nearest.get(end, (math.inf, action))[0]:
                        nearest[end] = int(way_ms), action
            for place, (way_ms, action) in nearest.items():
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
    departures = [action for action in actions if _ends(action)[0] == HERE]
    can_depart = any(_is_in_time(action, ways_ms, limit_ms) for action in departures)
    for action in actions:
        origin, end = _ends(action)
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
    return duration_ms(action) + ways_ms.get(_ends(action)[1] or "", math.inf) <= limit_ms


def _ends(action: Action) -> tuple[str | None, str | None]:
    """Where an action begins and ends; None for anywhere."""
    begin = next((f.arguments[0] for f in action.requires if f.predicate == AT), None)
    return begin, next((f.arguments[0] for f in action.adds if f.predicate == AT), begin)


def _ways_ms(actions: Sequence[Action], withdrawn: frozenset[Fact], place: str) -> dict[str, int]:
    """From each place the least that actions take to another one; none where there is no way."""
    into: dict[str, list[tuple[str, int]]] = defaultdict(list)
    for action in actions:
        origin, end = _ends(action)
        if origin and end and origin != end and not action.assumes & withdrawn:
            into[end].append((origin, duration_ms(action)))
    found: dict[str, int] = {}
    pending = [(0, place)]
    while pending:
        way_ms, name = heapq.heappop(pending)
        if name not in found:
            found[name] = way_ms
            for origin, more_ms in into[name]:
                heapq.heappush(pending, (way_ms + more_ms, origin))
    return found
