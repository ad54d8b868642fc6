"""The entries from which another process can continue a flight; a class for each kind.

The journal is written ahead: what is about to be done is on the disk before it is done. A reader
reconstructs the state of a flight from the entries (`JournalledFlight`). record/journal_file.py
writes them to a file; without a file nothing is stored, and nothing waits.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

from companion.flight_events.sortie import Phase
from companion.geofence import KeptFence
from companion.geometry import Ned
from companion.planning.task_changes import ActionCompleted, TaskChange
from companion.vehicle.ports.cameras import IntendedShot, ShotOwner


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
class PhotoReported:
    """A photo was made, and was reported.

    Attributes:
        action: the action that it is for.
        position: position of the word at which the action is done.
        nth: which of the action's steps, from 0.
    """

    action: str
    position: int
    nth: int

    @property
    def owner(self) -> ShotOwner:
        """What the photo is for."""
        return (self.action, self.position, self.nth)


@dataclass(frozen=True, slots=True)
class FlightCounts:
    """So many replans and laps of the task there had been."""

    replans: int
    laps: int


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
    | PhotoReported
    | PlaceFound
    | FlightCounts
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


KEPT_SHOTS = 20


@dataclass(frozen=True)
class JournalledFlight:
    """The state of a flight, between its arming and its end, when the journal ended.

    Attributes:
        begun: which flight it is.
        phase: the phase of its sortie.
        flown: the phase before somebody else had control, or before control was taken back.
        ending: how it was to end; None if it was not landing yet.
        armed_s: when it was first to arm.
        seen: where the vehicle was last; None if it was never seen.
        changes: of the task's state.
        unsettled: commands since the last completed skill that were done, or whose outcome is
            unknown.
        shots: the newest photos, `KEPT_SHOTS` at most, that were about to be requested.
        photos: what the photos were for that were made and reported.
        settings: the operator's settings; None for the initial ones.
        counts: the numbers of replans and laps.
        found: places that were found in flight, each with its newest position, the newest last.
        fence: somebody else's fence in the autopilot, to which it keeps; None without one.
        energy: the learnt energy; None if nothing was learnt.
        time_s: time of the last entry.
        away_s: the time since then, by the autopilot's clock or the wall clock.
    """

    begun: FlightBegun
    phase: Phase
    flown: Phase
    ending: EndingBegun | None
    armed_s: float
    seen: VehicleSeen | None
    changes: tuple[TaskChange, ...]
    unsettled: tuple[CommandIntended, ...]
    shots: tuple[IntendedShot, ...]
    photos: frozenset[ShotOwner]
    settings: OperatorSettings | None
    counts: FlightCounts
    found: tuple[PlaceFound, ...]
    fence: KeptFence | None
    energy: EnergyLearnt | None
    time_s: float
    away_s: float = 0.0

    @property
    def positions(self) -> int:
        """The number of positions of the word that had been left."""
        return self.changes[-1].at.positions if self.changes else 0

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


_ON_THE_WAY_BACK = (Phase.YIELDED, Phase.OFFBOARD)
_Entry = TypeVar("_Entry")


def put_together(entries: Iterable[tuple[float, JournalEntry]]) -> JournalledFlight | None:
    """Reconstructs the state of a flight; None if it has ended, or had not begun to arm.

    >>> begun = FlightBegun("survey", "survey.yaml", "0a", start_s=0.0)
    >>> flight = put_together([(0.0, begun), (3.5, PhaseBegun(Phase.ARMING))])
    >>> flight.phase.name, flight.armed_s
    ('ARMING', 3.5)
    >>> put_together([(0.0, begun)]) is None
    True

    Args:
        entries: the entries, with their times.
    """
    begun: FlightBegun | None = None
    noted: list[JournalEntry] = []
    armed_s: float | None = None
    last_s = 0.0
    for last_s, entry in entries:
        if isinstance(entry, FlightBegun):
            begun, noted, armed_s = entry, [], None
        elif armed_s is None and entry == PhaseBegun(Phase.ARMING):
            armed_s = last_s
        noted.append(entry)
    phases = [entry.phase for entry in noted if isinstance(entry, PhaseBegun)]
    if begun is None or armed_s is None or phases[-1] is Phase.ENDED:
        return None
    return JournalledFlight(
        begun=begun,
        phase=phases[-1],
        flown=[phase for phase in phases if phase not in _ON_THE_WAY_BACK][-1],
        ending=_last(EndingBegun, noted),
        armed_s=armed_s,
        seen=_last(VehicleSeen, noted),
        changes=tuple(entry for entry in noted if isinstance(entry, TaskChange)),
        unsettled=_unsettled(noted),
        shots=_all(IntendedShot, noted)[-KEPT_SHOTS:],
        photos=frozenset(photo.owner for photo in _all(PhotoReported, noted)),
        settings=_last(OperatorSettings, noted),
        counts=_last(FlightCounts, noted) or FlightCounts(0, 0),
        found=_newest(noted),
        fence=_last(KeptFence, noted),
        energy=_last(EnergyLearnt, noted),
        time_s=last_s,
    )


def _all(kind: type[_Entry], entries: Sequence[JournalEntry]) -> tuple[_Entry, ...]:
    return tuple(entry for entry in entries if isinstance(entry, kind))


def _last(kind: type[_Entry], entries: Sequence[JournalEntry]) -> _Entry | None:
    return next((entry for entry in reversed(entries) if isinstance(entry, kind)), None)


def _newest(entries: Sequence[JournalEntry]) -> tuple[PlaceFound, ...]:
    newest: dict[str, PlaceFound] = {}
    for found in _all(PlaceFound, entries):
        newest.pop(found.place, None)
        newest[found.place] = found
    return tuple(newest.values())


def _unsettled(entries: Sequence[JournalEntry]) -> tuple[CommandIntended, ...]:
    unsettled: dict[int, CommandIntended] = {}
    for entry in entries:
        match entry:
            case CommandIntended(number):
                unsettled[number] = entry
            case CommandSettled(number):
                unsettled.pop(number, None)
            case ActionCompleted():
                unsettled.clear()
    return tuple(unsettled.values())
