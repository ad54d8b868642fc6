"""The changes that may happen while a plan is flown: a class for each kind.

There is one change at a time, at one position of the plan. A plan assumes that events keep their
values, that beliefs hold, that routes lead to its places, and that the battery lasts as computed.
Each kind of change breaks one of these assumptions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from companion.mission.facts import Fact

MORE_DRAIN = 0.25
"""The extra drain in the table: wind, or an aged battery."""


@dataclass(frozen=True, slots=True)
class EventTurns:
    """An event of the mission becomes true or false.

    Attributes:
        event: by name.
        holds: whether it is true afterwards; a pulse becomes true and false.
    """

    kind: ClassVar[str] = "event"
    event: str
    holds: bool

    @property
    def subject(self) -> str:
        """The changed thing, by its name in the mission."""
        return self.event

    def __str__(self) -> str:
        return f"{self.event} {'comes' if self.holds else 'passes'}"


@dataclass(frozen=True, slots=True)
class BeliefLost:
    """A belief is withdrawn: the skill that assumes it fails, if it is under way."""

    kind: ClassVar[str] = "belief"
    belief: Fact

    @property
    def subject(self) -> str:
        """The changed thing, by its name in the mission."""
        return str(self.belief)

    def __str__(self) -> str:
        return f"{self.belief} withdrawn"


@dataclass(frozen=True, slots=True)
class ChargerLost(BeliefLost):
    """A belief about a charger is withdrawn."""

    kind: ClassVar[str] = "charger"


@dataclass(frozen=True, slots=True)
class SiteLost:
    """No route leads to a place any more; a vehicle that is there may leave it."""

    kind: ClassVar[str] = "site"
    place: str

    @property
    def subject(self) -> str:
        """The changed thing, by its name in the mission."""
        return self.place

    def __str__(self) -> str:
        return f"no way to {self.place}"


@dataclass(frozen=True, slots=True)
class DrainUp:
    """From now on everything takes more energy than the mission says.

    Attributes:
        share: how much more, as a share.
    """

    kind: ClassVar[str] = "drain"
    share: float = MORE_DRAIN

    @property
    def subject(self) -> str:
        """The changed thing."""
        return "drain"

    def __str__(self) -> str:
        return f"all takes {100 * self.share:.0f} % more"


@dataclass(frozen=True, slots=True)
class ChargeAtFloor:
    """The battery has just enough to land at the nearest safe place with the reserve left."""

    kind: ClassVar[str] = "charge"

    @property
    def subject(self) -> str:
        """The changed thing."""
        return "charge"

    def __str__(self) -> str:
        return "charge for a safe place alone"


Change = EventTurns | BeliefLost | ChargerLost | SiteLost | DrainUp | ChargeAtFloor
