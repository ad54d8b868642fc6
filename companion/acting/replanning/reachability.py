"""Which moves the present map allows; beliefs that only other moves assume are given up.

1. A move without a route does not exist. So no skill can be done that needs a belief which only
   such moves assume. That belief is given up at once, before a flight fails because of it, and held
   again when the map shows a route again. Since a task may mention it, the rest of the plan is
   checked again.
2. Moves are instantiated on the map whenever a plan is made. In between, a quick check of the map
   tells whether a place was cut off, or can be reached again. Only then are they instantiated again
   in flight.
3. The place to which the vehicle is flying is left to the flight itself, which flies around or
   stops, and fails if there is no route (Fig. 6 of the paper).
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass

from companion.acting.flight import Flight
from companion.flight_events.facts import PlacesConnected, PlacesCutOff
from companion.mission.facts import Fact, spelled
from companion.motion.distance_maps import CELL_US
from companion.motion.routes import CELLS_PER_TICK
from companion.planning.planner import Planner
from companion.slices import Question, spent

MAX_PARTS = 200
"""The most parts of a search for routes on a changing map; then a plan uses those found."""
SHOWN = 6
"""The most beliefs that are named."""


@dataclass(frozen=True, slots=True)
class BeliefChange:
    """How the map has changed the beliefs that are held, for reports.

    Attributes:
        cut_off: the beliefs that were given up, because no move that assumes them is left; None if
            there are none.
        connected: the beliefs that are held again; None if there are none.
    """

    cut_off: PlacesCutOff | None
    connected: PlacesConnected | None


class Reachability:
    """The moves of a planner on the map of a flight.

    Attributes:
        has_changed: whether other places are cut off than when moves were last instantiated.
    """

    def __init__(self, planner: Planner, flight: Flight) -> None:
        self._planner = planner
        self._flight = flight
        self._instantiated_on = self._looked_at = flight.routes.version
        self._costed_at = flight.speed_limit.version, planner.energy_factor
        self._cut_off = self.unreachable
        self._searched_on = self._instantiated_on
        self._searching = Question[None]()
        self.has_changed = False

    def look(self) -> None:
        """Checks the map quickly, if it has changed since the last check."""
        version = self._flight.routes.version
        if version != self._looked_at:
            self._looked_at = version
            cut_off, running = self.unreachable, self._flight.task.running
            is_flown_to = running is not None and running.destination in cut_off
            self.has_changed = cut_off != self._cut_off and not is_flown_to

    @property
    def is_known(self) -> bool:
        """Whether all routes on the present map have been found."""
        return self._flight.routes.version in (self._instantiated_on, self._searched_on)

    def search(self) -> None:
        """Searches for some of the unknown routes, for one slice."""
        version = self._flight.routes.version
        if not self.is_known and self._searching.ask(version, self._find) is not None:
            self._searched_on = version

    def _find(self, max_parts: int = sys.maxsize) -> None:
        """Searches for all routes; if the map has blocked a waypoint, to another waypoint."""
        flight, state = self._flight, self._flight.vehicle.state
        if state is not None:
            for place in flight.symbols.follow_map(state.motion.position, flight.now_s):
                flight.tell_symbol(place)
        for _ in range(max_parts):
            if flight.routes.find(CELLS_PER_TICK):
                break
            spent(CELL_US * CELLS_PER_TICK)

    def follow(self) -> BeliefChange:
        """Updates the costs of moves to the present map and speed limit.

        Beliefs that they cut off are given up. It takes long with many places, or if routes are
        unknown.
        """
        flight, state = self._flight, self._flight.vehicle.state
        is_map_new = self._instantiated_on != flight.routes.version
        figures = flight.speed_limit.version, self._planner.energy_factor
        if state is not None and (is_map_new or self._costed_at != figures):
            followed = flight.routes.version, figures
            if self._searched_on != flight.routes.version:
                self._find(MAX_PARTS)
            self._planner.reinstantiate()
            self._instantiated_on, self._costed_at = followed
            self._cut_off = self.unreachable
            self.has_changed = False
        lost, held = flight.task.cut_off(self._planner.actions.without_a_move)
        connected = PlacesConnected(self._named(held), restored=tuple(held)) if held else None
        cut_off = PlacesCutOff(self._named(lost), withdrawn=tuple(lost)) if lost else None
        for event in filter(None, (connected, cut_off)):
            flight.report(event)
        return BeliefChange(cut_off, connected)

    def _named(self, beliefs: list[Fact]) -> str:
        gone, known = self._planner.actions.without_a_move, self._planner.actions.model.beliefs
        alike = beliefs if gone.isdisjoint(beliefs) else gone
        return in_words(beliefs, alike, known)

    @property
    def unreachable(self) -> frozenset[str]:
        """The places that walls separate from the vehicle."""
        state = self._flight.vehicle.state
        if state is None:
            return frozenset()
        is_connected, here = self._flight.routes.is_connected, state.motion.position
        places = self._planner.mission.places
        return frozenset(place for place in places if not is_connected(here, place))


def in_words(beliefs: Iterable[Fact], alike: Iterable[Fact], known: Iterable[Fact]) -> str:
    """Beliefs in few words: all known ones with the same last, or first, argument become one.

    Args:
        beliefs: the beliefs to be named.
        alike: those for which the same is true, whether or not they are news.
        known: all beliefs.

    >>> names = ["ok(A, B)", "ok(C, B)", "ok(A, C)", "ok(B, C)", "ok(B, A)", "safe(B)"]
    >>> known = [Fact.parse(name) for name in names]
    >>> in_words([known[0], known[2], known[1], known[5]], known[:3] + known[5:], known)
    'ok(*, B), ok(A, *), safe(B)'
    """
    members: dict[str, set[Fact]] = {}
    for belief in known:
        for pattern in _patterns(belief):
            members.setdefault(pattern, set()).add(belief)
    same = set(alike)
    words = dict.fromkeys(
        next((p for p in _patterns(belief) if 1 < len(members[p]) and members[p] <= same), belief)
        for belief in beliefs
    )
    more = f" and {len(words) - SHOWN} more" if len(words) > SHOWN else ""
    return ", ".join(list(words)[:SHOWN]) + more


def _patterns(belief: Fact) -> tuple[str, ...]:
    """The patterns of a belief about two places, with * for either; none for others."""
    if len(belief.arguments) != 2:
        return ()
    first, second = belief.arguments
    return spelled(belief.predicate, ("*", second)), spelled(belief.predicate, (first, "*"))
