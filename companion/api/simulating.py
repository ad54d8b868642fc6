"""Flights in the bundled simulator, in lockstep in one process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from companion.acting.sortie.flight_limit import FlightLimit
from companion.acting.sortie.terms import SortieTerms
from companion.api.flight_arguments import check_flight_arguments
from companion.api.results import FlightResult, FlownTrajectory, OnEvent, Recording, recording
from companion.arguments import check_kind
from companion.documents import Given
from companion.flights.only_flight import only_flight
from companion.flights.options import USUAL_OPTIONS, FlightOptions
from companion.flights.simulated_world import World, lockstep, verdict, world_of
from companion.mission.model import Mission

if TYPE_CHECKING:
    from companion.flights.simulated_world import LockstepFlight


@dataclass(frozen=True, eq=False, repr=False)
class SimulationResult(FlightResult):
    """The result of a simulated flight; its trajectory is where the vehicle truly was.

    Attributes:
        scenario_events: time (seconds) and text of each scenario event that has happened.
        collisions: number of collisions with walls and obstacles, also after the end; any is a
            failure with exit code 5, whatever the result of the task.
    """

    scenario_events: tuple[tuple[float, str], ...]
    collisions: int


def simulate(
    mission: Mission,
    scenario: Given | None = None,
    *,
    seed: int = 0,
    folder: Path | str | None = None,
    on_event: OnEvent | None = None,
    laps: int | None = None,
    limit_s: float | None = None,
    timeout_s: float = 30.0,
) -> SimulationResult:
    """Flies a mission in the bundled simulator as fast as possible, without writing any files.

    Equal arguments give equal flights.

    >>> from companion import load_mission, simulate
    >>> run = simulate(load_mission("missions/surveillance.yaml"), seed=7)
    >>> run
    <SimulationResult of surveillance: exit code 0>
    >>> run.events[-1].event
    TaskSatisfied(exit_code=0)
    >>> run.trajectory.positions.shape == (len(run.trajectory.times_s), 3)
    True

    Args:
        mission: the mission to fly.
        scenario: the world: a path, a YAML text, or data (docs/scenario.md). A text, or data,
            without a map uses the mission's map. By default NAME.sim.yaml beside a mission file
            NAME.yaml, if it exists; otherwise the mission's own map, without wind and events.
        seed: the seed of wind, sensors and the estimate.
        folder: where to write a run folder; None writes none.
        on_event: called with each event that is shown to people.
        laps: after this many laps the vehicle is called home; None means no limit.
        limit_s: likewise, simulated seconds since arming was due.
        timeout_s: simulated seconds to wait for a vehicle.

    Raises:
        MissionError: the scenario cannot be read, or does not fit the mission.
        LibraryMissing: jsbsim is not installed.
        CompanionError: it is no mission, or another argument has a wrong type or value.
    """
    check_flight_arguments(mission, folder, on_event, laps, limit_s, timeout_s)
    check_kind(seed, int, "a whole number as seed")
    world = world_of(mission, scenario)
    run_folder = Path(folder) if folder is not None else None
    options = FlightOptions(SortieTerms(limit=FlightLimit(laps, limit_s)))
    flying = flight_of(mission, world, seed, folder=run_folder, on_event=on_event, options=options)
    with flying as (flight, recorder):
        flight.fly(timeout_s)
    return SimulationResult(
        mission=mission,
        events=tuple(recorder.events),
        trajectory=FlownTrajectory.of(flight.truth),
        failure=verdict(flight.companion.failure, flight.simulation.is_damaged),
        folder=run_folder,
        scenario_events=tuple(flight.simulation.event_log),
        collisions=flight.simulation.collisions,
    )


@contextmanager
def flight_of(
    mission: Mission,
    world: World,
    seed: int = 0,
    *,
    folder: Path | None = None,
    on_event: OnEvent | None = None,
    options: FlightOptions = USUAL_OPTIONS,
) -> Iterator[tuple[LockstepFlight, Recording]]:
    """A flight of `simulate` before its first tick, with its recording."""
    with (
        recording(mission, folder, on_event) as recorder,
        only_flight(mission, recorder, options, folder=folder, is_lockstep=True) as companion,
    ):
        yield lockstep(companion, world, seed=seed, keeps_packets=folder is not None), recorder
