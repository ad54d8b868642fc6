"""What may turn out otherwise while a plan is flown: a class for each kind of change.

One change at a time, at one position of the plan. A plan assumes that events keep their values,
that beliefs hold, that ways lead to its places, and that the battery lasts as reckoned; each kind
takes one of these away.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from companion.mission.facts import Fact

MORE_DRAIN = 0.25
"""Of the table: wind, or a battery that has aged."""


@dataclass(frozen=True, slots=True)
class EventTurns:
    """An event of the mission comes, or passes.

    Attributes:
        event: by name.
        holds: whether it does afterwards; a pulse comes and passes.
    """

    kind: ClassVar[str] = "event"
    event: str
    holds: bool

    @property
    def subject(self) -> str:
        """What changes, by its name in the mission."""
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
        """What changes, by its name in the mission."""
        return str(self.belief)

    def __str__(self) -> str:
        return f"{self.belief} withdrawn"


@dataclass(frozen=True, slots=True)
class ChargerLost(BeliefLost):
    """The same of a belief about a charger."""

    kind: ClassVar[str] = "charger"


@dataclass(frozen=True, slots=True)
class SiteLost:
    """No way leads to a place any more; a vehicle that is there may leave it."""

    kind: ClassVar[str] = "site"
    place: str

    @property
    def subject(self) -> str:
        """What changes, by its name in the mission."""
        return self.place

    def __str__(self) -> str:
        return f"no way to {self.place}"


@dataclass(frozen=True, slots=True)
class DrainUp:
    """All that is done takes more of the battery than the mission says, from now on.

    Attributes:
        share: so much more.
    """

    kind: ClassVar[str] = "drain"
    share: float = MORE_DRAIN

    @property
    def subject(self) -> str:
        """What changes."""
        return "drain"

    def __str__(self) -> str:
        return f"all takes {100 * self.share:.0f} % more"


@dataclass(frozen=True, slots=True)
class ChargeAtFloor:
    """The battery has just enough to land at the nearest safe place, its reserve left."""

    kind: ClassVar[str] = "charge"

    @property
    def subject(self) -> str:
        """What changes."""
        return "charge"

    def __str__(self) -> str:
        return "charge for a safe place alone"


Change = EventTurns | BeliefLost | ChargerLost | SiteLost | DrainUp | ChargeAtFloor
