"""How a row of a campaign ended, and what was measured in its flight.

All numbers are rounded here, once, so that stored, compared and shown values are the same. A margin
is the least distance from a limit during the flight, by the true position; below 0 the limit was
broken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any

from companion.campaigns.rows import Row

NorthEastTrack = tuple[tuple[float, float], ...]
DIGITS = 4
"""Decimals of metres, seconds and shares: a tenth of a millimetre."""


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
        """Whether the flight failed its task; an unfair row does not count as a failure."""
        return self not in (RowOutcome.SATISFIED, RowOutcome.HOLDS_SO_FAR, RowOutcome.INVALID)

    @property
    def is_valid(self) -> bool:
        """Whether the row counts."""
        return self is not RowOutcome.INVALID


@dataclass(frozen=True, slots=True)
class Margins:
    """The margin of each limit; None where there is no such limit, or nothing was flown.

    Attributes:
        clearance_m: from the vehicle's outermost point to a wall or an obstacle.
        fence_m: to the fence and the keep-out zones, from inside.
        altitude_m: to the ends of the altitude band.
        carrot_m: to the largest distance of a setpoint that the gate accepts.
        speed_mps: to the limit of horizontal speed.
        charge: the charge of the battery, 0 to 1.
        time_s: to the time limit of the campaign.
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
"""Margins that no flight may break -> a value that is ample."""
LEADING: Mapping[str, float] = {"carrot_m": 1.0, "charge": 0.25, "time_s": 120.0}
"""Margins that often reach 0 before a failure, but are no failure -> a value that is ample."""


@dataclass(frozen=True, slots=True)
class FlownRow:
    """A row that has been flown.

    Attributes:
        row: what was flown.
        conjunct: the line of the task that was violated; "" if none.
        exit_code: that of `companion sim`; None if the flight did not end.
        reason: the reason of a failure, in one line.
        replans: number of replans.
        duration_s: simulated duration of the flight.
        phase: the phase of the sortie, when it failed or ended.
        place: the place of the mission that is nearest to where it failed or ended.
        east_m, north_m: where it failed or ended.
        signature: what happened, without numbers; equal for flights of one kind.
        track: the flown track, east and north, simplified.
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
        """The limit that was broken although the row did not fail otherwise; "" if none."""
        left = {name: getattr(self.margins, name) for name in BREAKABLE}
        broken = {name: left_m for name, left_m in left.items() if (left_m or 0.0) < 0}
        return min(broken, key=lambda name: broken[name], default="")

    @property
    def is_failure(self) -> bool:
        """Whether it failed or broke a limit."""
        return self.outcome.is_valid and (self.outcome.is_failure or bool(self.broken))

    @property
    def kind(self) -> str:
        """The kind of failure, by which failures are told apart; "" if it did not fail.

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
        """The least ratio of a margin to its ample value, at most 1; below 0 is a failure."""
        shares = [1.0]
        for scales, least in ((BREAKABLE, -1.0), (LEADING, 0.0)):
            for name, scale in scales.items():
                if (margin := getattr(self.margins, name)) is not None:
                    shares.append(max(margin / scale, least))
        is_flown = self.outcome.is_valid
        failed = -2.0 if self.outcome.is_failure else 0.0
        return round(min(shares) + failed, DIGITS) if is_flown else 1.0

    def as_json(self) -> dict[str, Any]:
        """The row as data for a line of JSON."""
        entry = asdict(self)
        return {**entry, "outcome": self.outcome.value}

    @classmethod
    def of_json(cls, entry: Mapping[str, Any]) -> FlownRow:
        """The row from the data of a line of JSON."""
        given = {
            **entry,
            "row": Row(**entry["row"]),
            "outcome": RowOutcome(entry["outcome"]),
            "margins": Margins(**entry["margins"]),
            "track": tuple((east, north) for east, north in entry["track"]),
        }
        return cls(**given)


def rounded(number: float) -> float:
    """A measured number as it is stored, never -0."""
    return round(number, DIGITS) + 0.0
