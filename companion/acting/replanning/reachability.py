"""Which moves does the map leave, as it is seen now? What only the others assume is not believed.

A move without a way does not exist, so no skill can be done any more that assumes what this move
assumes. Such a belief is given up at once, before a flight has to fail for it, and held again when
the map shows a way again. A task may speak of it, so the rest of the plan is asked for again.

Moves are grounded on the map whenever a plan is made. In between a quick look at the map tells
whether a place was cut off, or can be reached again; only then are they grounded in flight. The
place that is flown to is left to the flight itself, which goes round or stops, and fails if there
is no way (Fig. 6 of the paper).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from companion.acting.flight import Flight
from companion.planning.domain import Fact
from companion.planning.planner import Planner

CELLS_PER_TICK = 10_000
"""Searched in about 4 ms, and setpoints leave in the same loop; only the last search of a tick may
be one of the whole map, 10 ms for 30,000 cells."""
SHOWN = 6
"""So many beliefs are named at most."""


class Reachability:
    """The moves of a planner on the map of a flight."""

    def __init__(self, planner: Planner, flight: Flight) -> None:
        self._planner = planner
        self._flight = flight
        self._grounded_on = self._looked_at = flight.routes.version
        self._costed_at = flight.speed_limit.version
        self._cut_off = self._unreachable()
        self._have_changed = False

    def have_changed(self) -> bool:
        """Whether another place is cut off now, or no longer, than when moves were grounded."""
        version = self._flight.routes.version
        if version != self._looked_at:
            self._looked_at = version
            cut_off, running = self._unreachable(), self._flight.task.running
            is_flown_to = running is not None and running.destination in cut_off
            self._have_changed = cut_off != self._cut_off and not is_flown_to
        return self._have_changed

    def are_known(self) -> bool:
        """Whether `follow` is quick: if not, it is after some more calls, each a part of it."""
        is_known = self._grounded_on == self._flight.routes.version
        return is_known or self._flight.routes.find(CELLS_PER_TICK)

    def follow(self) -> str:
        """Moves cost what they cost on the map, and at the speed limit, as they are now.

        Returns:
            What is not believed any more, in words.
        """
        flight, state = self._flight, self._flight.vehicle.state
        is_map_new = self._grounded_on != flight.routes.version
        if state is not None and (is_map_new or self._costed_at != flight.speed_limit.version):
            self._grounded_on = flight.routes.version
            self._costed_at = flight.speed_limit.version
            for place in flight.symbols.follow_map(state.position, flight.now_s):
                flight.tell_symbol(place)
            self._planner.reground()
            self._cut_off = self._unreachable()
            self._have_changed = False
        lost, held = flight.task.cut_off(self._planner.without_a_move)
        if held:
            self._tell(f"a way again: {self._named(held)} restored", held=held)
            flight.may_do_better = True
        if not lost:
            return ""
        text = f"no way on the map as seen: {self._named(lost)} withdrawn"
        self._tell(text, lost=lost)
        return text

    def _named(self, beliefs: list[Fact]) -> str:
        gone, known = self._planner.without_a_move, self._planner.model.beliefs
        alike = beliefs if gone.isdisjoint(beliefs) else gone
        return in_words(beliefs, alike, known)

    def _tell(self, text: str, lost: Sequence[Fact] = (), held: Sequence[Fact] = ()) -> None:
        self._flight.report("map", text, withdrawn=list(lost), restored=list(held))

    def _unreachable(self) -> frozenset[str]:
        """The places from which walls divide the vehicle."""
        state = self._flight.vehicle.state
        if state is None:
            return frozenset()
        is_connected, here = self._flight.routes.is_connected, state.position[:2]
        places = self._planner.mission.places
        return frozenset(place for place in places if not is_connected(here, place))


def in_words(beliefs: Iterable[Fact], alike: Iterable[Fact], known: Iterable[Fact]) -> str:
    """Beliefs in few words: all that are known with the same last, or first, argument are one.

    Args:
        beliefs: to be named.
        alike: those of which the same is true, whether they are news or not.
        known: all there are.

    >>> known = ["ok(A, B)", "ok(C, B)", "ok(A, C)", "ok(B, C)", "ok(B, A)", "safe(B)"]
    >>> in_words(["ok(A, B)", "ok(A, C)", "ok(C, B)", "safe(B)"], known[:3] + known[5:], known)
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
    """A belief in two places, with any one of them; none for others."""
    name, _, arguments = belief.removesuffix(")").partition("(")
    places = arguments.split(", ")
    return (f"{name}(*, {places[1]})", f"{name}({places[0]}, *)") if len(places) == 2 else ()
