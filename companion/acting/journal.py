"""The entries from which another process can continue a flight; a class for each kind.

The journal is written ahead: what is about to be done is on the disk before it is done. A reader
reconstructs the state of a flight from the entries (`JournalledFlight`). record/journal_file.py
writes them to a file; without a file nothing is stored, and nothing waits.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Protocol

from companion.flight_events.sortie import Phase
from companion.geofence import KeptFence
from companion.geometry import Ned
from companion.planning.task_changes import TaskChange
from companion.vehicle.camera_port import IntendedShot


@dataclass(frozen=True, slots=True)
class FlightBegun:
    """A mission is about to be flown.

    Attributes:
        mission: its name.
        path: path of its file.
        digest: hash of everything in the mission.
        start_s: when the run began, on the flight's clock.
    """

    mission: str
    path: str
    digest: str
    start_s: float


@dataclass(frozen=True, slots=True)
class PhaseBegun:
    """A phase of the sortie began."""

    phase: Phase


@dataclass(frozen=True, slots=True)
class EndingBegun:
    """The vehicle is about to land, and the run ends in this way.

    Attributes:
        reason: why it does not end well; "" if it does.
        place: where an operator, a limit or the battery called the vehicle; "" if nowhere.
    """

    is_satisfied: bool
    is_called_home: bool
    reason: str
    exit_code: int
    place: str = ""


@dataclass(frozen=True, slots=True)
class VehicleSeen:
    """Where the vehicle is, once a second.

    Attributes:
        position: in the mission's frame.
        origin: of that frame, in the autopilot's local frame.
        altitude_m: of the origin above mean sea level.
        system: MAVLink system id of the vehicle.
        zero_s: the flight's clock when the autopilot's clock shows 0.
    """

    position: Ned
    origin: Ned
    altitude_m: float
    system: int
    zero_s: float | None = None


@dataclass(frozen=True, slots=True)
class CommandIntended:
    """A command of a skill is about to be sent for the first time.

    Attributes:
        number: of the intention.
        action: the action that sends it.
    """

    number: int
    action: str
    command: str


@dataclass(frozen=True, slots=True)
class CommandSettled:
    """The command has failed, or its try has. A command that was done is part of its skill."""

    number: int


@dataclass(frozen=True, slots=True)
class PlanNumbered:
    """A plan was made, or none was found; so many plans had been made before."""

    number: int


@dataclass(frozen=True, slots=True)
class PlaceFound:
    """Where a place was found in flight, in the mission's frame."""

    place: str
    position: Ned


@dataclass(frozen=True, slots=True)
class EnergyLearnt:
    """The learnt ratios of energy (`planning/energy/ratio_estimate.py`)."""

    flying: float
    flying_deviation: float
    gauge: float
    gauge_deviation: float


@dataclass(frozen=True, slots=True)
class OperatorSettings:
    """The companion's parameters that an operator has set."""

    speed_max_mps: float
    belief_retry_s: float


JournalEntry = (
    FlightBegun
    | PhaseBegun
    | EndingBegun
    | EnergyLearnt
    | VehicleSeen
    | CommandIntended
    | CommandSettled
    | IntendedShot
    | KeptFence
    | OperatorSettings
    | PlaceFound
    | PlanNumbered
    | TaskChange
)


class Journal(Protocol):
    """Stores entries, in order."""

    def note(self, now_s: float, entry: JournalEntry) -> None:
        """Stores an entry, soon; it may not block."""

    @property
    def is_kept(self) -> bool:
        """Whether all noted entries are on the disk, or never will be."""


class NoJournal:
    """Stores nothing."""

    is_kept = True

    def note(self, now_s: float, entry: JournalEntry) -> None:
        """Ignores the entry."""


@dataclass(frozen=True)
class JournalledFlight:
    """The state of a flight when the journal ended.

    Attributes:
        begun: which flight it is.
        phase: the phase of its sortie.
        flown: the phase before somebody else had control, or before control was taken back.
        ending: how it was to end; None if it was not landing yet.
        armed_s: when it was to arm; None if it never was.
        seen: where the vehicle was last; None if it was never seen.
        changes: of the task's state.
        unsettled: commands since the last completed skill that were done, or whose outcome is
            unknown.
        shots: the newest photos that were about to be requested.
        settings: the operator's settings; None for the initial ones.
        replans: number of replans.
        found: places that were found in flight, each with its newest position, the newest last.
        fence: somebody else's fence in the autopilot, to which it keeps; None without one.
        energy: the learnt energy; None if nothing was learnt.
        time_s: time of the last entry.
        away_s: the time since then, by the autopilot's clock or the wall clock.
    """

    begun: FlightBegun
    phase: Phase = Phase.WAITING
    flown: Phase = Phase.WAITING
    ending: EndingBegun | None = None
    armed_s: float | None = None
    seen: VehicleSeen | None = None
    changes: tuple[TaskChange, ...] = ()
    unsettled: tuple[CommandIntended, ...] = field(default=())
    shots: tuple[IntendedShot, ...] = ()
    settings: OperatorSettings | None = None
    replans: int = 0
    found: tuple[PlaceFound, ...] = ()
    fence: KeptFence | None = None
    energy: EnergyLearnt | None = None
    time_s: float = 0.0
    away_s: float = 0.0

    @property
    def positions(self) -> int:
        """The number of positions of the word that had been left."""
        return self.changes[-1].positions if self.changes else 0

    @property
    def goes_on_s(self) -> float:
        """The flight's clock when it continues."""
        return self.time_s + self.away_s

    def found_at(self, boot_s: float) -> JournalledFlight:
        """The same flight, with the time since then by the autopilot's clock.

        A clock that shows less than before has restarted, and tells nothing.

        Args:
            boot_s: the autopilot's clock now, in seconds since its boot.
        """
        if self.seen is None or self.seen.zero_s is None:
            return self
        away_s = self.seen.zero_s + boot_s - self.time_s
        return replace(self, away_s=away_s) if away_s >= 0.0 else self

    @property
    def is_over(self) -> bool:
        """Whether there is nothing to continue: it has ended, or had not begun to arm."""
        return self.phase is Phase.ENDED or self.armed_s is None


KEPT_SHOTS = 20
_ON_THE_WAY_BACK = (Phase.YIELDED, Phase.OFFBOARD)


def put_together(entries: Iterable[tuple[float, JournalEntry]]) -> JournalledFlight | None:
    """Reconstructs the state of a flight; None if it has not begun.

    >>> begun = FlightBegun("survey", "survey.yaml", "0a", start_s=0.0)
    >>> flight = put_together([(0.0, begun), (3.5, PhaseBegun(Phase.ARMING))])
    >>> flight.phase.name, flight.armed_s, flight.is_over
    ('ARMING', 3.5, False)

    Args:
        entries: the entries, with their times.
    """
    flight: JournalledFlight | None = None
    changes: list[TaskChange] = []
    for time_s, entry in entries:
        if isinstance(entry, FlightBegun):
            flight = JournalledFlight(entry)
        elif isinstance(entry, TaskChange):
            changes.append(entry)
            if flight is not None and entry.method == "complete":
                flight = replace(flight, unsettled=())
        elif flight is not None:
            flight = _after(flight, time_s, entry)
        if flight is not None:
            flight = replace(flight, time_s=time_s)
    return None if flight is None else replace(flight, changes=tuple(changes))


def _after(flight: JournalledFlight, time_s: float, entry: JournalEntry) -> JournalledFlight:
    match entry:
        case PhaseBegun(phase):
            flown = flight.flown if phase in _ON_THE_WAY_BACK else phase
            armed_s = flight.armed_s
            if phase is Phase.ARMING and armed_s is None:
                armed_s = time_s
            return replace(flight, phase=phase, flown=flown, armed_s=armed_s)
        case EndingBegun():
            return replace(flight, ending=entry)
        case VehicleSeen():
            return replace(flight, seen=entry)
        case CommandIntended():
            return replace(flight, unsettled=(*flight.unsettled, entry))
        case CommandSettled(number):
            left = tuple(each for each in flight.unsettled if each.number != number)
            return replace(flight, unsettled=left)
        case IntendedShot():
            return replace(flight, shots=(*flight.shots, entry)[-KEPT_SHOTS:])
        case KeptFence():
            return replace(flight, fence=entry)
        case EnergyLearnt():
            return replace(flight, energy=entry)
        case PlanNumbered(number):
            return replace(flight, replans=number)
        case OperatorSettings():
            return replace(flight, settings=entry)
        case PlaceFound(place):
            before = tuple(each for each in flight.found if each.place != place)
            return replace(flight, found=(*before, entry))
    return flight
