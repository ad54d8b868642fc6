"""Flights of shipped missions with an inexact position: the room that is left, and the cost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from benches import Row
from benches.missions import Tracking
from benches.shipped import shipped
from companion.acting.sortie.flight_limit import FlightLimit
from companion.acting.sortie.terms import SortieTerms
from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.skills import PlaceReached, RouteBlocked
from companion.flights.simulated_world import lockstep, world_of
from companion.run_sources.only_run import OnlyRun

MISSIONS = ("surveillance", "hall_of_20")
FLOWN = SortieTerms(limit=FlightLimit(duration_s=60.0))
ERRORS = {
    "GPS noise of 0.25 m": "\nhappens:\n  - {at_s: 0.1, gps: {noise_m: 0.25}}\n",
    "as a PX4": "\nairframe: px4_sih\nwander: {}\n",
}
"""Name of the row -> what is added to the scenario."""


@dataclass
class Wandering(Tracking):
    """A recorder for flights without obstacles that the map does not show.

    Attributes:
        reroutes: how often a route was not clear.
        waits_s: for each flight, the wait at its end until the vehicle arrived.
    """

    reroutes: int = 0
    waits_s: list[float] = field(default_factory=list)
    moved_s: float = 0.0

    def report(self, stamped: Stamped) -> None:
        """Counts reroutes and arrivals."""
        super().report(stamped)
        if isinstance(stamped.event, RouteBlocked):
            self.reroutes += 1
        elif isinstance(stamped.event, PlaceReached):
            self.waits_s.append(max(0.0, stamped.time_s - self.moved_s))

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Notes when the last moving setpoint was sent."""
        super().packets(now_s, datagrams)
        if self.told_mps > 0.0:
            self.moved_s = now_s


def flights(runs: int) -> Iterator[Row]:
    """A minute of each mission, seed 0: with wandering GPS, or the drag and wander of a PX4."""
    for each in (each for each in shipped() if each.name in MISSIONS):
        mission = each.load()
        assert each.scenario is not None
        text = each.scenario.read_text(encoding="utf-8")
        text = text.replace("map: maps/", f"map: {each.scenario.parent}/maps/")
        for name, errors in ERRORS.items():
            seen = Wandering()
            companion = Companion(OnlyRun(mission, seen), FLOWN)
            flight = lockstep(companion, world_of(mission, text + errors))
            seen.simulation = flight.simulation
            flight.fly()
            row = f"{each.name}, {name}"
            yield Row(f"{row}: least clearance", 100 * min(seen.clearances_m), "cm")
            yield Row(f"{row}: reroutes", seen.reroutes, "times")
            yield Row(f"{row}: longest arrival", max(seen.waits_s, default=0.0), "s")
