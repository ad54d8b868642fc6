"""What `companion sim` flies: a mission in the bundled simulator, in lockstep or by the clock."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from companion.errors import CompanionError
from companion.flights.front_end import FrontEnd
from companion.flights.monitor_page import Page, PageOptions, monitored
from companion.flights.only_flight import only_flight
from companion.flights.options import FlightOptions, LinkOptions
from companion.flights.over_link import fly_over_link
from companion.flights.run_folders import RunFolders
from companion.flights.simulated_world import (
    World,
    lockstep,
    scenario_beside,
    verdict,
    world_alone,
    world_in_words,
    world_of,
)
from companion.mission.model import Mission
from companion.record.run_folder import RunFolder
from companion.simulator import simulator
from companion.vehicle.endpoints import OFFBOARD_PORT, UdpPort


@dataclass(frozen=True)
class SimulatorOptions:
    """The simulated vehicle and its world.

    Attributes:
        scenario: the file of the world; None for the one beside the mission, if there is one, or
            else for the map of the mission.
        seed: the seed of all randomness.
        instance: is added to the ports of the simulator and to its system id.
        ground_port: the UDP port of the ground station, which there is only by the clock.
    """

    scenario: Path | None
    seed: int
    instance: int
    ground_port: int


@dataclass(frozen=True)
class SimulatedFlights:
    """Flights in the bundled simulator, recorded and shown.

    Attributes:
        options: how missions are flown.
        simulator: the vehicle and its world.
        timeout_s: how long a flight waits for its vehicle, in seconds of real time; in lockstep, of
            simulated time.
        log_dir: contains the run folders.
        page: where the monitor page is served.
        front_end: the program around the flights.
    """

    options: FlightOptions
    simulator: SimulatorOptions
    timeout_s: float
    log_dir: Path
    page: PageOptions
    front_end: FrontEnd

    def fly_in_lockstep(self, mission: Mission) -> CompanionError | None:
        """Flies a mission in this process, as fast as possible; returns why it failed.

        Raises:
            MissionError: the scenario cannot be read, or does not fit the mission.
            LibraryMissing: jsbsim is not installed.
        """
        seed, instance = self.simulator.seed, self.simulator.instance
        scenario = self._scenario_of(mission)
        world = world_of(mission, scenario)
        with (
            self._shown(mission, scenario) as (run, page),
            only_flight(
                mission, run, self.options, folder=run.folder, page=page, is_lockstep=True
            ) as companion,
        ):
            flight = lockstep(companion, world, seed=seed, instance=instance)
            with self.front_end.attending(companion):
                flight.fly(self.timeout_s)
        return verdict(companion.failure, flight.simulation.is_damaged)

    def fly_by_clock(
        self, mission: Mission, speed: float, events: str | None
    ) -> CompanionError | None:
        """Flies a mission over a link to a simulator in its own process; returns why it failed.

        Args:
            mission: the mission to fly.
            speed: as a multiple of real time.
            events: where other programs on board report events; None if only the simulator does.

        Raises:
            MissionError: the scenario cannot be read, or does not fit the mission.
            LibraryMissing: jsbsim is not installed.
            LinkError: the simulator does not start, or was not heard in time.
        """
        scenario = self._scenario_of(mission)
        world = world_of(mission, scenario)
        endpoint = UdpPort("127.0.0.1", OFFBOARD_PORT + self.simulator.instance)
        told = f"{speed:g} x real time; ground station on UDP port {self.simulator.ground_port}"
        with self._shown(mission, scenario) as (run, page), _report_address(events) as reports:
            self.front_end.say(f"vehicle    simulated, {told}")
            link = LinkOptions(endpoint, None, reports, self.timeout_s * speed, speed)
            file = scenario or _written(world_alone(mission), run.folder / "world.sim.yaml")
            arguments = self._arguments(file, world, speed, reports)
            with (
                only_flight(mission, run, self.options, folder=run.folder, page=page) as companion,
                simulator(arguments, run.folder / "sitl.log") as child,
            ):
                fly_over_link(companion, link, self.front_end)
        return verdict(companion.failure, child.is_damaged)

    @contextmanager
    def _shown(self, mission: Mission, scenario: Path | None) -> Iterator[tuple[RunFolder, Page]]:
        """The run folder and the page of a flight."""
        folders = RunFolders(self.log_dir, self.front_end)
        with (
            folders.recorded(mission) as folder,
            monitored(self.page, self.front_end.say, folder.folder) as page,
        ):
            self.front_end.say(f"world      {world_in_words(mission, scenario)}")
            yield folder, page

    def _scenario_of(self, mission: Mission) -> Path | None:
        return self.simulator.scenario or scenario_beside(mission)

    def _arguments(self, file: Path, world: World, speed: float, reports: str) -> list[object]:
        """The arguments of `sitl`."""
        return [
            *("--scenario", file, "--seed", self.simulator.seed, "--speed", speed),
            *("--instance", self.simulator.instance, "--ground-port", self.simulator.ground_port),
            *("--home", world[0].home, "--reports", reports),
        ]


@contextmanager
def _report_address(given: str | None) -> Iterator[str]:
    """The address for reports of a simulated vehicle's programs: the user's, or an own socket.

    The socket has a folder of its own, because its path must be short.
    """
    with TemporaryDirectory(prefix="companion-") as own:
        yield given or f"unix:{own}/events"


def _written(scenario: dict[str, object], path: Path) -> Path:
    """Writes a file with a scenario that is given as data; JSON is also YAML."""
    path.write_text(json.dumps(scenario), encoding="utf-8")
    return path
