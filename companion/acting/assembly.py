"""Assembles the parts that fly one mission with one vehicle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from companion.acting.charge.energy_gauge import Gauge
from companion.acting.docks import AnyDock, PlannedDock
from companion.acting.event_detector import EventDetector
from companion.acting.executive import Executive
from companion.acting.flight import Flight
from companion.acting.perception import Perception
from companion.acting.preparation import PreparedMission
from companion.acting.symbols import Symbols
from companion.mission.model import Mission
from companion.mission.places import Place
from companion.motion.departure import Departure
from companion.motion.marker_track import HEIGHT_M, LAND_FROM_M
from companion.motion.position_error import MOST_M
from companion.planning.energy.charge_source import ChargeSource
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.flight_times import flight_times
from companion.planning.task_state import TaskState
from companion.vehicle.gate import Envelope, LandingSite
from companion.vehicle.ports.vehicle import Vehicle


@dataclass(frozen=True)
class ActingParts:
    """The parts of a run: what acts, and what it acts on."""

    flight: Flight
    executive: Executive
    perception: Perception


def assemble(prepared: PreparedMission, vehicle: Vehicle, detector: EventDetector) -> ActingParts:
    """Makes the parts for a mission and a vehicle.

    Args:
        prepared: the mission, whose planner follows the flight from now on.
        vehicle: the vehicle that is flown.
        detector: detects the mission's events.
    """
    flight = flight_of(prepared, vehicle)
    executive = Executive(prepared, flight)
    return ActingParts(flight, executive, Perception(flight, executive, detector))


def flight_of(
    prepared: PreparedMission,
    vehicle: Vehicle,
    charge_of: Callable[[Flight, MissionEnergy], ChargeSource] = Gauge,
) -> Flight:
    """The flight of a vehicle for a mission, at its beginning.

    Args:
        prepared: the mission, whose planner follows the flight from now on.
        vehicle: the vehicle that is flown.
        charge_of: tells the charge of the flight, if plans consider energy.
    """
    mission, routes, speed_limit = prepared.mission, prepared.routes, prepared.speed_limit

    planner, energy = prepared.planner, prepared.planner.energy
    task = TaskState(planner)
    flight = Flight(
        vehicle=vehicle,
        task=task,
        routes=routes,
        speed_limit=speed_limit,
        profile=mission.vehicle,
        limits=mission.limits,
        symbols=Symbols(mission.places, routes),
        functions=prepared.functions,
        dock=AnyDock() if energy is None else PlannedDock(planner, task),
    )

    def here() -> Departure | None:
        return flight.guidance.departure

    times = flight_times(mission, prepared.flown_routes, here, lambda: speed_limit.target)
    planner.actions.follow(times)
    if energy is not None:
        energy.follow(here, charge_of(flight, energy))
    return flight


def envelope_of(mission: Mission) -> Envelope:
    """The limits for the setpoints of a mission."""
    limits, vehicle = mission.limits, mission.vehicle
    return Envelope(
        limits.fence,
        limits.up_m,
        mission.speed_limits.speed_mps,
        vehicle.climb_mps,
        vehicle.descent_mps,
        vehicle.carrot_m,
        vehicle.margin_m,
        tuple(limits.keep_out.values()),
        sites=tuple(map(_site, filter(lambda place: place.marker, mission.places.values()))),
    )


def _site(place: Place) -> LandingSite:
    """Where the vehicle may descend to the marker of a place."""
    assert place.marker is not None
    centre = place.position[:2]
    outline = place.region.outline()
    reach_m = max(math.dist(centre, c) for c in outline) if outline else place.inner_m
    return LandingSite(centre, reach_m + MOST_M, place.marker.up_m + LAND_FROM_M - HEIGHT_M)
