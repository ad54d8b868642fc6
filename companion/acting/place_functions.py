"""Suggesters and tests of places from installed packages (Section IV-D: users extend both).

They are asked in slices while a waypoint is chosen. Each is a process, and the vehicle holds until
it has answered, for at most `ASKED_S`. One that fails or takes longer proposes nothing. A waypoint
that has not passed a test is not flown to.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from companion.acting.flight import Flight
from companion.acting.function_port import known_place, known_vehicle
from companion.errors import printable
from companion.flight_events.skills import PlaceFunctionFailed
from companion.geometry import Ned, enu_from_ned, ned_from_enu
from companion.mission.places import Place
from companion.mission.python_call import PythonCall
from companion.outcomes import Failed
from companion.skills.authoring import WaypointEnu
from companion.skills.calls import CallRequest, CommandAsked, Returned
from companion.slices import wait_a_tick

ASKED_S = 10.0
"""The longest time of a call."""
IN_ALL_S = 30.0
"""The longest time of all calls for one choice of a waypoint."""


class PlaceFunctions:
    """Implements `symbols.PlaceAdvice` for one choice of a waypoint; only in slices.

    Args:
        flight: the flight for which the waypoint is chosen.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._end_s = flight.now_s + IN_ALL_S

    def suggested(self, place: Place) -> Iterator[tuple[Ned, str]]:
        """Waypoints in the place's region, each with the name of its suggester."""
        lowest_m, highest_m = self._flight.limits.up_m
        for step in place.suggesters:
            answer, strange = self._ask(step, place), 0
            for east_m, north_m, up_m in answer.waypoints if answer is not None else ():
                own_m = -place.position[2]
                waypoint = ned_from_enu(east_m, north_m, own_m if up_m is None else up_m)
                is_inside = place.region.away_m(place.position, waypoint) <= 0.0
                if is_inside and lowest_m <= -waypoint[2] <= highest_m:
                    yield waypoint, step.function.name
                else:
                    strange += 1
            if strange:
                self._tell(step, place, f"{strange} waypoints outside the region or the altitudes")

    def passing(self, place: Place, waypoints: Sequence[Ned]) -> list[bool]:
        """Whether each waypoint passes all tests."""
        verdicts = [True] * len(waypoints)
        asked = tuple(WaypointEnu(*(round(x, 3) for x in enu_from_ned(each))) for each in waypoints)
        for step in place.tests:
            answer = self._ask(step, place, asked)
            if answer is None or len(answer.verdicts) != len(waypoints):
                return [False] * len(waypoints)
            verdicts = [one and other for one, other in zip(verdicts, answer.verdicts, strict=True)]
        return verdicts

    def _ask(
        self, step: PythonCall, place: Place, waypoints: tuple[WaypointEnu, ...] = ()
    ) -> Returned | None:
        flight, end_s = self._flight, min(self._flight.now_s + ASKED_S, self._end_s)
        state, location = flight.vehicle.state, flight.vehicle.frame.location
        names = sorted({place.name} | step.names)
        known = [flight.symbols.find(name) for name in names]
        places = tuple(known_place(each, location) for each in known if each is not None)
        request = CallRequest(step.call, places, known_vehicle(state), place.name, waypoints)
        ticket = flight.functions.begin(request)
        try:
            while flight.now_s < end_s:
                for answer in flight.functions.take(ticket, flight.now_s):
                    match answer:
                        case Returned():
                            return answer
                        case Failed(reason):
                            self._tell(step, place, reason)
                            return None
                        case CommandAsked():
                            flight.functions.reply(ticket, "a skill alone may command payloads")
                wait_a_tick()
            self._tell(step, place, "it takes too long")
            return None
        finally:  # also if the choice is given up
            flight.functions.cancel(ticket)

    def _tell(self, step: PythonCall, place: Place, reason: str) -> None:
        name = step.function.name
        self._flight.report(PlaceFunctionFailed(place.name, name, printable(reason)))
