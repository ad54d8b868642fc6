"""Puts the parts together: the one place that knows both the acting side and the MAVLink side.

`Companion` is a state machine: time and datagrams in, datagrams out. `fly` drives it in real
(or scaled) time from a socket; the simulator's harness drives the same object in lockstep.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from companion.acting.events import EventDetector
from companion.acting.executive import Executive
from companion.acting.flight import TICK_S, Flight
from companion.acting.grounding import Symbols
from companion.acting.report import Report
from companion.acting.sortie import Phase, Sortie
from companion.acting.task_state import TaskState
from companion.errors import CompanionError, LinkTimeout
from companion.geometry import Ned
from companion.ltl.formula import atoms
from companion.mission.loader import CLEARANCE_M
from companion.mission.model import Mission, Place
from companion.motion.profile import SpeedLimits, flight_time_s
from companion.motion.routes import RouteMap, Site
from companion.motion.sensed_map import SensedMap
from companion.planning.domain import HERE, FlightTime
from companion.planning.planner import Planner
from companion.vehicle.gate import Envelope
from companion.vehicle.link import ScaledClock, UdpLink
from companion.vehicle.offboard import MavlinkVehicle


class Recorder(Protocol):
    """Keeps what happens in a run."""

    def report(self, report: Report) -> None:
        """Something happened."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Datagrams went over the link, in either direction."""

    def position(self, now_s: float, position: Ned) -> None:
        """Where the vehicle is, once per tick."""


def route_map(mission: Mission) -> RouteMap:
    """The routes of a mission: the places that its task mentions are not crossed by chance."""
    mentioned = frozenset().union(*(atoms(f) for f in mission.task.values()))
    sites = {
        name: Site(place.position, place.radius_m, is_exclusive=f"at({name})" in mentioned)
        for name, place in mission.places.items()
    }
    return RouteMap(mission.grid, sites, mission.limits.fence, CLEARANCE_M)


def flight_times(
    mission: Mission, routes: RouteMap, here: Callable[[], Ned | None] = lambda: None
) -> FlightTime:
    """Seconds of flight between places; `here` says where the vehicle is, between them."""
    limits = SpeedLimits(mission.limits.speed_mps)

    def flight_time(origin: str, goal: str) -> float:
        start = here() if origin == HERE else routes.goal(origin)
        if start is None:
            return float("inf")
        return flight_time_s(routes.distance_m(start[:2], goal), limits)

    return flight_time


def home_of(mission: Mission) -> Place:
    """The place where the mission begins."""
    return next(p for name, p in mission.places.items() if f"at({name})" in mission.initially)


class Companion:
    """One mission, from the ground to the ground.

    Args:
        mission: what to do.
        recorder: told of everything that happens.
        accepts_weak_failsafes: fly although the autopilot's failsafes are weak.
    """

    def __init__(
        self, mission: Mission, recorder: Recorder, accepts_weak_failsafes: bool = False
    ) -> None:
        routes = route_map(mission)
        detector = EventDetector(mission.events)
        home, limits = home_of(mission), mission.limits
        self._vehicle = MavlinkVehicle(
            Envelope(limits.fence, limits.up_m, limits.speed_mps),
            detector.signals,
            takeoff_up_m=-home.position[2],
        )
        planner = Planner(mission, flight_times(mission, routes, self._position))
        self._flight = Flight(
            vehicle=self._vehicle,
            task=TaskState(planner),
            routes=routes,
            limits=limits,
            symbols=Symbols(mission.places, routes),
        )
        executive = Executive(planner, self._flight, detector)
        self._sortie = Sortie(
            self._flight, executive, home, mission.otherwise, accepts_weak_failsafes
        )
        self._map = SensedMap(mission.grid)
        self._routes = routes
        self._recorder = recorder

    @property
    def is_waiting(self) -> bool:
        """Whether no vehicle has been heard yet."""
        return self._sortie.phase is Phase.WAITING

    @property
    def has_ended(self) -> bool:
        """Whether nothing is left to do."""
        return self._sortie.has_ended

    @property
    def failure(self) -> CompanionError | None:
        """Why the run did not end well."""
        return self._sortie.failure

    def stop(self) -> None:
        """Hold, land, end: what Ctrl-C asks for."""
        self._sortie.stop()

    def step(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        """One tick: reads what arrived, acts, returns what has to leave."""
        readings = self._vehicle.receive(now_s, datagrams)
        self._look()
        self._sortie.step(now_s, readings)
        answers = self._vehicle.transmit(now_s)
        self._record(now_s, datagrams + answers)
        return answers

    def _look(self) -> None:
        """Corrects the map by what the vehicle sees."""
        if any([self._map.integrate(scan) for scan in self._vehicle.scans]):
            self._routes.see(self._map.grid)

    def _record(self, now_s: float, packets: list[bytes]) -> None:
        self._recorder.packets(now_s, packets)
        position = self._position()
        if position is not None:
            self._recorder.position(now_s, position)
        for report in self._flight.reports:
            self._recorder.report(report)
        self._flight.reports.clear()

    def _position(self) -> Ned | None:
        state = self._vehicle.state
        return state.position if state else None


def fly(companion: Companion, link: UdpLink, clock: ScaledClock, timeout_s: float) -> None:
    """Drives a companion over a link, at 20 Hz of the clock's time, until it has ended.

    Raises:
        LinkTimeout: no vehicle was heard in time (seconds of the clock's time).
    """
    next_tick_s = clock.now_s()
    while not companion.has_ended:
        clock.sleep_until(next_tick_s)
        now_s = clock.now_s()
        link.send(companion.step(now_s, link.receive()))
        if companion.is_waiting and now_s > timeout_s:
            raise LinkTimeout(
                f"no vehicle on {link.endpoint} after {timeout_s:.0f} s: {link.account()}\n"
                "    PX4 SITL and `sitl` send to port 14540 by themselves; is one running?\n"
                "    QGroundControl must not listen on this port"
            )
        next_tick_s = max(next_tick_s + TICK_S, now_s)
