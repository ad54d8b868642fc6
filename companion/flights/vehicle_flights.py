"""What `companion run` flies: one mission once, or missions that ground stations start."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from companion.errors import CompanionError
from companion.flights.cut_off_runs import CutOffRun, cut_off_run, found_by_its_clock
from companion.flights.front_end import FrontEnd
from companion.flights.hosted_flights import hosted_flights
from companion.flights.monitor_page import PageOptions, monitored
from companion.flights.only_flight import only_flight
from companion.flights.options import FlightOptions, LinkOptions
from companion.flights.over_link import fly_over_link
from companion.flights.run_folders import RunFolders
from companion.mission.model import Mission
from companion.record.flight_memory_files import flight_memory_in


@dataclass(frozen=True)
class VehicleFlights:
    """Flights of one vehicle, recorded and shown.

    Attributes:
        options: how missions are flown; if its terms say so, a run that was cut off is resumed.
        link: the link to the vehicle.
        log_dir: contains the run folders.
        page: where the monitor page is served.
        front_end: the program around the flights.
    """

    options: FlightOptions
    link: LinkOptions
    log_dir: Path
    page: PageOptions
    front_end: FrontEnd

    def fly_once(self, mission: Mission) -> CompanionError | None:
        """Flies one mission, or resumes a run that was cut off; returns why it failed.

        Raises:
            LinkError: the link cannot be opened, or no vehicle was heard in time.
            CompanionError: nothing can be recorded, or the cut-off run had another mission.
        """
        cut_off = self._cut_off(mission)
        with (
            self._folders.recorded(mission, cut_off) as folder,
            monitored(self.page, self.front_end.say, folder.folder) as page,
            only_flight(
                mission,
                folder,
                self.options,
                folder=folder.folder,
                page=page,
                memory=flight_memory_in(self.log_dir),
                journalled=cut_off.journalled if cut_off else None,
            ) as companion,
        ):
            fly_over_link(companion, self.link, self.front_end, _begin_s(cut_off))
        return companion.failure

    def host(self, mission: Mission | None) -> None:
        """Waits for ground stations to start missions, until stopped.

        Args:
            mission: what they may start before they have sent another mission; None if nothing.

        Raises:
            LinkError: the link cannot be opened.
            CompanionError: the run that was cut off had another mission.
        """
        cut_off = self._cut_off(mission)
        mission = cut_off.mission if cut_off else mission
        with (
            monitored(self.page, self.front_end.say) as page,
            hosted_flights(
                mission,
                self._folders,
                self.options,
                page=page,
                memory=flight_memory_in(self.log_dir),
                cut_off=cut_off,
                has_reports=self.link.events is not None,
            ) as companion,
        ):
            what = f"to fly {mission.name}" if mission else "and a mission"
            self.front_end.say(f"hosting    waits for MAV_CMD_MISSION_START {what}; Ctrl-C ends it")
            fly_over_link(companion, self.link, self.front_end, _begin_s(cut_off))

    @property
    def _folders(self) -> RunFolders:
        return RunFolders(self.log_dir, self.front_end, keeps_journal=True)

    def _cut_off(self, mission: Mission | None) -> CutOffRun | None:
        """The run to resume, if there is one and the operator has said so."""
        if not self.options.terms.resumes:
            return None
        cut_off = cut_off_run(self.log_dir, mission)
        return found_by_its_clock(cut_off, self.link) if cut_off is not None else None


def _begin_s(cut_off: CutOffRun | None) -> float:
    """What the flight's clock shows at the start."""
    return cut_off.journalled.goes_on_s if cut_off is not None else 0.0
