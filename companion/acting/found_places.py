"""Places whose position in their region is reported in flight.

A report that is accepted makes the place known: from then on routes lead there, and its event
becomes true, which leads to a new plan. A later report moves the place. Rules:

1. A report outside the place's region, or where the vehicle cannot be, is refused and reported. So
   no report widens fence or zones: the region was checked when the mission was read.
2. While the vehicle flies to the place, the place does not move: the vehicle arrives where it was
   to arrive. Otherwise it moves by at least SAME_M, and at most once in MOVES_S.
3. The journal stores what was found, so a flight that continues after a restart knows it.
4. The vehicle flies to the point that was found, and to no other point of the region.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from companion.acting.flight import Flight
from companion.acting.journal import PlaceFound
from companion.geometry import GlobalOrigin, Ned, NorthEast, horizontal_distance
from companion.mission.found_places import FOUND, report_of
from companion.mission.model import Mission
from companion.mission.places import Place
from companion.mission.signals import REPORT, Signal
from companion.outcomes import Refusal
from companion.planning.planner import Planner
from companion.vehicle.sightings import Sighting, Sightings

SAME_M = 1.0
MOVES_S = 2.0


class SightingReports(Protocol):
    """The positions that other programs have reported."""

    def take_sightings(self) -> dict[str, Sighting]:
        """The newest report of each name since the last call."""

    def refuse(self, why: str) -> None:
        """Reports why a report cannot be used."""


class FoundPlaces:
    """The places of a mission that are found in flight.

    Args:
        mission: the mission.
        flight: the flight.
    """

    def __init__(self, mission: Mission, flight: Flight) -> None:
        self._flight = flight
        self._places: dict[str, Place] = {
            report_of(mission.events[place.found_by]): place
            for place in mission.places.values()
            if place.found_by
        }
        self._moved_s: dict[str, float] = {}
        self._sightings = Sightings()
        self._now_s = 0.0

    @property
    def reports(self) -> frozenset[str]:
        """The names of the reports by which places are found."""
        return frozenset(self._places)

    def look(
        self,
        now_s: float,
        reports: SightingReports,
        zero_s: float | None,
        zero: GlobalOrigin | None,
    ) -> list[tuple[Signal, float]]:
        """Takes the reports of a tick; returns the signals of those that find a place.

        Args:
            now_s: the flight's time.
            reports: the reports of other programs.
            zero_s: the machine's clock when the flight's clock showed 0; None in lockstep.
            zero: where the mission's frame lies on the earth, if that is known.
        """
        self._now_s, found = now_s, []
        vehicle = self._flight.vehicle
        is_certain = vehicle.frame.doubt is None
        self._sightings.follow(vehicle.state if is_certain else None)
        for report, sighting in reports.take_sightings().items():
            at = self._sightings.locate(sighting, now_s, zero_s, zero if is_certain else None)
            refusal = at if isinstance(at, Refusal) else self._take(report, at)
            if refusal is None:
                found.append((Signal(REPORT, report, ""), FOUND))
            else:
                reports.refuse(f"{report}: {refusal.reason}")
        return found

    def _take(self, report: str, at: NorthEast) -> Refusal | None:
        """Takes the position of a place; why it is refused, or None if the place is known now."""
        flight, place = self._flight, self._places[report]
        position = (*at, place.position[2])
        is_known = place.name in self._moved_s
        if is_known and self._stays(place.name, position):
            return None
        away_m = place.region.away_m(place.position, position)
        if away_m > 0:
            return Refusal(f"it is {away_m:.1f} m outside the region of {place.name}")
        if not flight.routes.is_free(position):
            return Refusal("it is too near to a wall, a zone or the fence to be flown to")
        flight.journal.note(self._now_s, PlaceFound(place.name, position))
        self._know(place.name, position, f"EVENT[{report}]")
        flight.tell_symbol(place.name)
        return None

    def restore(self, found: Sequence[PlaceFound], planner: Planner) -> None:
        """Makes places that were found before an absence known, also to the planner."""
        for each in found:
            self._know(each.place, each.position, "the journal")
        if found:
            planner.reinstantiate()  # moves to these places may be among the completed actions

    def _know(self, name: str, position: Ned, source: str) -> None:
        self._moved_s[name] = self._now_s
        self._flight.symbols.suggest(name, position, source, self._now_s)
        self._flight.routes.find_place(name, position)

    def _stays(self, name: str, position: Ned) -> bool:
        """Whether a report changes nothing about a known place."""
        flight = self._flight
        running = flight.task.running
        is_flown_to = running is not None and running.destination == name
        is_same = horizontal_distance(flight.symbols[name].position, position) < SAME_M
        is_soon = self._now_s - self._moved_s.get(name, -math.inf) < MOVES_S
        return is_flown_to or is_same or is_soon
