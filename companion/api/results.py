"""What a program gets from a flight that it has flown: events, trajectory, result."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import time

import numpy as np
import numpy.typing as npt

from companion.acting.journal import Journal, NoJournal
from companion.errors import CompanionError
from companion.flight_events.event import Stamped
from companion.geometry import Ned
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.record.run_folder import RunFolder
from companion.vehicle.run_clocks import ClockReading

OnEvent = Callable[[Stamped], None]
"""Called with each event that is shown to people, when it happens."""


@dataclass(frozen=True, eq=False, slots=True)
class FlownTrajectory:
    """The positions of the vehicle, one per tick.

    Attributes:
        times_s: (n,) seconds since the run began.
        positions: (n, 3) metres, local north-east-down of the home position.
    """

    times_s: npt.NDArray[np.float64]
    positions: npt.NDArray[np.float64]

    @classmethod
    def of(cls, samples: Sequence[tuple[float, Ned]]) -> FlownTrajectory:
        """The trajectory of times and positions."""
        times_s = np.array([time_s for time_s, _ in samples], dtype=float)
        positions = np.array([position for _, position in samples], dtype=float)
        return cls(times_s, positions.reshape(-1, 3))

    @property
    def north_m(self) -> npt.NDArray[np.float64]:
        """(n,) metres north of home."""
        return self.positions[:, 0]

    @property
    def east_m(self) -> npt.NDArray[np.float64]:
        """(n,) metres east of home."""
        return self.positions[:, 1]

    @property
    def up_m(self) -> npt.NDArray[np.float64]:
        """(n,) metres above home."""
        return -self.positions[:, 2]


@dataclass(frozen=True, eq=False, repr=False)
class FlightResult:
    """The result of a flight.

    Attributes:
        mission: the mission that was flown.
        events: all events, in order, with their times.
        trajectory: where the vehicle was.
        failure: why the task was not satisfied; None if it was, or if the flight was stopped on
            request.
        folder: the run folder, if one was written.
    """

    mission: Mission
    events: tuple[Stamped, ...]
    trajectory: FlownTrajectory
    failure: CompanionError | None
    folder: Path | None

    def __repr__(self) -> str:
        """One line: the mission, and the exit code."""
        return f"<{type(self).__name__} of {self.mission.name}: exit code {self.exit_code}>"

    @property
    def exit_code(self) -> int:
        """The exit code of the command line: 0 satisfied, 3 no plan, 5 the pilot won, ..."""
        return self.failure.exit_code if self.failure else 0


class Recording:
    """Records events and positions, and passes everything on to another recorder.

    Args:
        other: another recorder, such as that of a run folder.
        on_event: called with each event that is shown to people.

    Attributes:
        events: all events so far.
        positions: as reported by the autopilot, with their times.
    """

    def __init__(self, other: Recorder | None = None, on_event: OnEvent | None = None) -> None:
        self.events: list[Stamped] = []
        self.positions: list[tuple[float, Ned]] = []
        self._other = other
        self._on_event = on_event

    @property
    def name(self) -> str:
        """The name of the other recorder; "" without one."""
        return self._other.name if self._other is not None else ""

    @property
    def journal(self) -> Journal:
        """The journal of the other recorder; without one, nothing is kept."""
        return self._other.journal if self._other is not None else NoJournal()

    def report(self, stamped: Stamped) -> None:
        """Records an event."""
        self.events.append(stamped)
        if self._other is not None:
            self._other.report(stamped)
        if self._on_event is not None and stamped.event.is_told:
            self._on_event(stamped)

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Records datagrams of the link, in either direction."""
        if self._other is not None:
            self._other.packets(now_s, datagrams)

    def position(self, now_s: float, position: Ned) -> None:
        """Records the vehicle's position, once per tick."""
        self.positions.append((now_s, position))
        if self._other is not None:
            self._other.position(now_s, position)

    def clocks(self, reading: ClockReading) -> None:
        """Records a reading of the clocks."""
        if self._other is not None:
            self._other.clocks(reading)


@contextmanager
def recording(
    mission: Mission, folder: Path | None, on_event: OnEvent | None
) -> Iterator[Recording]:
    """A recording, which also writes a run folder if one is given."""
    if folder is None:
        yield Recording(on_event=on_event)
        return
    files = RunFolder(folder, mission, time(), lambda stamped: None)
    try:
        yield Recording(files, on_event)
    finally:
        files.close()
