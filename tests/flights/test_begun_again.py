"""A companion started anew on an autopilot that goes on, whose vehicle has landed beside Home.

The estimate wanders as a PX4's. The first mission ends and lands a metre beside Home; the second
one, of another companion, begins there.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from lockstep import Lockstep, World
from synthetic import mission

from companion.flight_events.frames import HomeMeasured, HomeRecalled
from companion.flight_events.sortie import Phase, PhaseEntered, TaskSatisfied
from companion.geometry import Ned, horizontal_distance
from companion.mission.model import Mission
from companion.mission.places import Place
from companion.motion.region import Disc
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.laid_frames import LaidFrames
from companion.vehicle.mission_frame import SETTLING_S
from sitl.flight.estimate import Wander
from sitl.world.scenario import Scenario

AS_PX4: World = (Scenario(airframe="px4_sih", wander=Wander(0.25, 0.3)), None)
BESIDE: Ned = (0.8, 0.6, -2.0)
OFF_M = 0.4
"""By which a frame may be off that was laid at Home, by a position that is good for 0.25 m."""


def landing_at(place: Ned) -> Mission:
    made = mission("F G at(B)", places="HB")
    return replace(made, places={**made.places, "B": Place("B", place, Disc(0.3))})


def two_flights(seed: int, *, remembers: bool = True) -> Lockstep:
    """The second one, under way."""
    flight: Lockstep
    frames = LaidFrames(lambda: flight.now_s) if remembers else None
    memory = FlightMemory(frames=frames)
    flight = first = Lockstep(landing_at(BESIDE), AS_PX4, seed=seed, memory=memory)
    first.until_the_end()
    assert first.ending == TaskSatisfied() and not first.of(HomeRecalled)
    flight = Lockstep(mission("F at(A)"), AS_PX4, memory=memory)
    flight.simulation, flight._ticks = first.simulation, first._ticks
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    return flight


def off_m(flight: Lockstep) -> float:
    """How far the map lies from where it lay at first: there the local frame begins."""
    origin = flight.companion.telemetry.frame.origin
    assert origin is not None
    return horizontal_distance(origin, (0.0, 0.0, 0.0))


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_the_map_stays_where_it_lay_though_the_vehicle_begins_beside_home(seed: int) -> None:
    flight = two_flights(seed)
    told = flight.one(HomeRecalled)
    assert told.home == "H" and told.gap_m > 2 * OFF_M
    assert off_m(flight) < OFF_M


@pytest.mark.long
def test_what_it_would_be_off_by_without_a_memory() -> None:
    flight = two_flights(0, remembers=False)
    assert not flight.of(HomeRecalled)
    assert off_m(flight) > 2 * OFF_M


def test_that_it_is_measured_where_the_vehicle_stands_is_told_once() -> None:
    """Nothing happened for ten seconds, and nobody knew why."""
    flight = Lockstep(mission("F at(A)"), AS_PX4)
    flight.until_reported(PhaseEntered, phase=Phase.ARMING)
    told = flight.one(HomeMeasured)
    assert told.home == "H" and told.for_s == SETTLING_S
    exact = Lockstep(mission("F at(A)"), (Scenario(), None))
    exact.until_reported(PhaseEntered, phase=Phase.ARMING)
    assert not exact.of(HomeMeasured)
