"""The parts that act out one mission on one vehicle, put together."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.event_detector import EventDetector
from companion.acting.executive import Executive
from companion.acting.flight import Flight
from companion.acting.symbols import Symbols
from companion.geometry import Ned
from companion.mission.model import Mission
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.motion.routes import RouteMap
from companion.planning.flight_times import flight_times, route_map
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState
from companion.vehicle.port import Vehicle


@dataclass(frozen=True)
class ActingParts:
    """What plans, what is acted on, and what acts."""

    planner: Planner
    flight: Flight
    executive: Executive


def assemble(
    mission: Mission,
    vehicle: Vehicle,
    detector: EventDetector,
    routes: RouteMap | None = None,
) -> ActingParts:
    """The parts for a mission and a vehicle.

    Args:
        mission: what to do.
        vehicle: what is flown; where it is between places is asked of it.
        detector: of the mission's events.
        routes: of the mission; made if absent.
    """
    routes = routes or route_map(mission)

    def here() -> Ned | None:
        return vehicle.state.position if vehicle.state else None

    speed_limit = LiveSpeedLimit(mission.speed_limits)
    times = flight_times(mission, routes, here, lambda: speed_limit.target)
    planner = Planner(mission, times)
    flight = Flight(
        vehicle=vehicle,
        task=TaskState(planner),
        routes=routes,
        speed_limit=speed_limit,
        profile=mission.vehicle,
        symbols=Symbols(mission.places, routes),
    )
    return ActingParts(planner, flight, Executive(planner, flight, detector))
