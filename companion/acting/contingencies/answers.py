"""The answers of a flight to a change: a class for each way to continue or end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from companion.flight_events.plans import PlannedLasso


class ContingencyVerdict(Enum):
    """The outcome of a flight, in short: a letter, and words for people."""

    AS_PLANNED = ("=", "goes on as planned")
    PLANNED = ("P", "another plan")
    LINES_DROPPED = ("D", "another plan, lines dropped")
    SAFE_PLACE = ("S", "lands at a safe place")
    ON_RESERVE = ("R", "lands at a safe place, or charges, on the reserve")
    WHERE_IT_IS = ("W", "lands or holds where it is")
    UNSAFE = ("!", "unsafe: the charge does not last to a safe place")

    @property
    def letter(self) -> str:
        """The letter for a cell of the table."""
        return str(self.value[0])

    @property
    def words(self) -> str:
        """The words for a legend."""
        return str(self.value[1])


@dataclass(frozen=True, slots=True)
class GoesOn:
    """The rest of the plan is still the plan."""

    @property
    def verdict(self) -> ContingencyVerdict:
        """The outcome in short."""
        return ContingencyVerdict.AS_PLANNED

    def __str__(self) -> str:
        return self.verdict.words


@dataclass(frozen=True, slots=True)
class Replans:
    """Another plan is flown.

    Attributes:
        plan: the plan, from where the vehicle is.
        dropped: lines of the task that it does not keep.
        waited_s: how long the vehicle holds before, until a belief is held again.
        reserve_wh: how much of the reserve it takes until it has charged.
    """

    plan: PlannedLasso
    dropped: tuple[str, ...] = ()
    waited_s: float = 0.0
    reserve_wh: float = 0.0

    @property
    def verdict(self) -> ContingencyVerdict:
        """The outcome in short."""
        kinds = ContingencyVerdict
        if self.reserve_wh > 0:
            return kinds.ON_RESERVE
        return kinds.LINES_DROPPED if self.dropped else kinds.PLANNED

    def __str__(self) -> str:
        waits = f"after {self.waited_s:g} s " if self.waited_s else ""
        without = f", without {', '.join(self.dropped)}" if self.dropped else ""
        return f"{waits}{self.plan}{without}{short_of(self.reserve_wh, 0.0)}"


@dataclass(frozen=True, slots=True)
class LandsAt:
    """There is no plan; the vehicle lands at a safe place.

    Attributes:
        place: the place that it chooses.
        why: why there is no plan, in words.
        waits_for: changes for which it holds before landing; none if no change can help.
        missing_wh: the energy missing to land there with the reserve left.
        short_wh: the energy missing even if the whole reserve is used.
    """

    place: str
    why: str
    waits_for: tuple[str, ...] = ()
    missing_wh: float = 0.0
    short_wh: float = 0.0

    @property
    def verdict(self) -> ContingencyVerdict:
        """The outcome in short."""
        kinds = ContingencyVerdict
        if self.short_wh > 0:
            return kinds.UNSAFE
        return kinds.ON_RESERVE if self.missing_wh > 0 else kinds.SAFE_PLACE

    def __str__(self) -> str:
        return f"lands at {self.place}{short_of(self.missing_wh, self.short_wh)}"


@dataclass(frozen=True, slots=True)
class StaysWhereItIs:
    """There is no plan, and no safe place is flown to: the vehicle lands, or holds.

    Attributes:
        does: what the vehicle does, in words.
        why: why there is no plan.
        is_asked: whether the mission demands this; otherwise no safe place can be reached.
        waits_for: as in `LandsAt`.
    """

    does: str
    why: str
    is_asked: bool
    waits_for: tuple[str, ...] = ()

    @property
    def verdict(self) -> ContingencyVerdict:
        """The outcome in short."""
        return ContingencyVerdict.WHERE_IT_IS

    def __str__(self) -> str:
        return self.does if self.is_asked else f"{self.does}: no safe place can be reached"


Answer = GoesOn | Replans | LandsAt | StaysWhereItIs


def short_of(missing_wh: float, short_wh: float) -> str:
    """How much of the reserve a landing takes, in words to append.

    >>> short_of(0.4, 0.0)
    ', with 0.40 Wh of the reserve'
    """
    if short_wh > 0:
        return f", for which {short_wh:.2f} Wh are missing although the reserve is used"
    return f", with {missing_wh:.2f} Wh of the reserve" if missing_wh > 0 else ""
