"""How a row of a campaign ended, and what was measured in its flight.

All numbers are rounded here, once, so that what is kept, what is compared and what is shown are
the same. Margins are what was left of a limit at the worst moment of the flight, of the true
position: below 0 the limit was broken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any

from companion.campaigns.rows import Row

NorthEastTrack = tuple[tuple[float, float], ...]
DIGITS = 4
"""Of metres, seconds and shares: a tenth of a millimetre."""


class RowOutcome(Enum):
    """How a row ended."""

    SATISFIED = "satisfied"
    HOLDS_SO_FAR = "holds so far"
    VIOLATED = "violated"
    NO_PLAN = "no plan"
    CRASH = "crash"
    ABORTED = "aborted"
    LIMIT = "limit"
    ERROR = "error"
    DIED = "died"
    INVALID = "invalid"

    @property
    def is_failure(self) -> bool:
        """Whether the flight did not do what it was to; an unfair row says nothing of that."""
        return self not in (RowOutcome.SATISFIED, RowOutcome.HOLDS_SO_FAR, RowOutcome.INVALID)

    @property
    def is_valid(self) -> bool:
        """Whether the row counts."""
        return self is not RowOutcome.INVALID


@dataclass(frozen=True, slots=True)
class Margins:
    """What was left of each limit; None where there is no such limit, or nothing was flown.

    Attributes:
        clearance_m: between the vehicle's outermost point and a wall or an obstacle.
        fence_m: to the fence and the keep-out zones, from inside.
        altitude_m: to the ends of the altitude band.
        carrot_m: of the longest distance of a setpoint, which the gate lets pass.
        speed_mps: to the speed limit, over the ground.
        charge: of the battery, 0 to 1.
        time_s: of the limit of the campaign.
    """

    clearance_m: float | None = None
    fence_m: float | None = None
    altitude_m: float | None = None
    carrot_m: float | None = None
    speed_mps: float | None = None
    charge: float | None = None
    time_s: float | None = None


NOTHING_MEASURED = Margins()
BREAKABLE: Mapping[str, float] = {"clearance_m": 1.0, "fence_m": 1.0, "altitude_m": 1.0}
"""Margins that no flight may break, and what is plenty of each."""
LEADING: Mapping[str, float] = {"carrot_m": 1.0, "charge": 0.25, "time_s": 120.0}
"""Margins whose end is no failure by itself, but comes before one; and what is plenty of each."""


@dataclass(frozen=True, slots=True)
class FlownRow:
    """A row that was flown.

    Attributes:
        row: what was to be flown.
        conjunct: the line of the task that was violated; "" without one.
        exit_code: with which `companion sim` would have ended; None if nothing ended.
        reason: of a failure, in one line.
        replans: how many plans were made anew.
        duration_s: of the flight, simulated.
        phase: of the sortie, when it failed or ended.
        place: of the mission, nearest to where it failed or ended.
        east_m, north_m: where that was.
        signature: what happened in it, without numbers: flights of one kind have one signature.
        track: where it was flown, east and north, simplified.
    """

    row: Row
    outcome: RowOutcome
    conjunct: str = ""
    exit_code: int | None = None
    reason: str = ""
    margins: Margins = NOTHING_MEASURED
    replans: int = 0
    duration_s: float = 0.0
    phase: str = ""
    place: str = ""
    east_m: float | None = None
    north_m: float | None = None
    signature: str = ""
    track: NorthEastTrack = ()

    @property
    def broken(self) -> str:
        """The limit that was broken although the row did not fail otherwise; "" if none was."""
        left = {name: getattr(self.margins, name) for name in BREAKABLE}
        broken = {name: left_m for name, left_m in left.items() if (left_m or 0.0) < 0}
        return min(broken, key=lambda name: broken[name], default="")

    @property
    def is_failure(self) -> bool:
        """It failed, or broke a limit."""
        return self.outcome.is_valid and (self.outcome.is_failure or bool(self.broken))

    @property
    def kind(self) -> str:
        """The kind of failure, which tells different failures apart; "" for none.

        >>> FlownRow(Row(0, 1, {}), RowOutcome.VIOLATED, "upload", phase="flying the task").kind
        'violated: upload'
        """
        if not self.is_failure:
            return ""
        if not self.outcome.is_failure:
            return f"limit broken: {self.broken}"
        return f"{self.outcome.value}: {self.conjunct}" if self.conjunct else self.outcome.value

    @property
    def score(self) -> float:
        """The least margin over what is plenty of it, at most 1; below 0 is a failure."""
        shares = [1.0]
        for scales, least in ((BREAKABLE, -1.0), (LEADING, 0.0)):
            for name, scale in scales.items():
                if (margin := getattr(self.margins, name)) is not None:
                    shares.append(max(margin / scale, least))
        is_flown = self.outcome.is_valid
        failed = -2.0 if self.outcome.is_failure else 0.0
        return round(min(shares) + failed, DIGITS) if is_flown else 1.0

    def as_json(self) -> dict[str, Any]:
        """The row for a line of JSON."""
        entry = asdict(self)
        return {**entry, "outcome": self.outcome.value}

    @classmethod
    def of_json(cls, entry: Mapping[str, Any]) -> FlownRow:
        """The row of a line of JSON."""
        given = {
            **entry,
            "row": Row(**entry["row"]),
            "outcome": RowOutcome(entry["outcome"]),
            "margins": Margins(**entry["margins"]),
            "track": tuple((east, north) for east, north in entry["track"]),
        }
        return cls(**given)


def rounded(number: float) -> float:
    """A measured number as it is kept; there is no -0."""
    return round(number, DIGITS) + 0.0
