"""Events about facts that the vehicle does not choose: the mission's events, and beliefs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc

BeliefName = Annotated[str, Doc("as the mission spells it, e.g. `canUpload(r1)`")]
BeliefsInShort = Annotated[str, Doc("the beliefs in short, e.g. `trans_ok(*, B)`")]


@dataclass(frozen=True, slots=True)
class MissionEventChanged(FlightEvent):
    """An event of the mission became true or false."""

    kind = "event"
    template = "{words}"

    event: Annotated[str, Doc("as the mission spells it, e.g. `lowBattery`")]
    holds: Annotated[bool, Doc("whether the event's fact has become true")]

    @property
    def words(self) -> str:
        """The change in words."""
        return in_words(self.event, self.holds)


@dataclass(frozen=True, slots=True)
class PlaceLost(FlightEvent):
    """The vehicle is no longer at the place where the task assumes it."""

    kind = "lost"
    template = "no longer at {place}: {away_m} m away"

    place: Annotated[str, Doc("the place")]
    away_m: Annotated[float, Doc("metres from it, rounded to 0.1 m")]


@dataclass(frozen=True, slots=True)
class BeliefWithdrawn(FlightEvent):
    """A belief was withdrawn."""

    kind = "withdrawn"
    template = "belief {belief} withdrawn"

    belief: BeliefName


@dataclass(frozen=True, slots=True)
class BeliefRestored(FlightEvent):
    """A belief was restored."""

    kind = "restored"
    template = "belief {belief} restored"

    belief: BeliefName


@dataclass(frozen=True, slots=True)
class PlacesCutOff(FlightEvent):
    """Beliefs were withdrawn, since the sensed map has no route for their moves."""

    kind = "map"
    template = "no route on the map as sensed: {summary} withdrawn"

    summary: BeliefsInShort
    withdrawn: Annotated[tuple[str, ...], Doc("a list of the beliefs that were withdrawn")]


@dataclass(frozen=True, slots=True)
class PlacesConnected(FlightEvent):
    """Beliefs were restored, since the sensed map has a route for their moves again."""

    kind = "map"
    template = "there is a route again: {summary} restored"

    summary: BeliefsInShort
    restored: Annotated[tuple[str, ...], Doc("a list of the beliefs that were restored")]


def in_words(event: str, holds: bool) -> str:
    """An event of the mission in words.

    >>> in_words("targetFound", True), in_words("lowBattery", False)
    ('target found', 'no longer low battery')
    """
    words = "".join(f" {c.lower()}" if c.isupper() else c for c in event).replace("_", " ").strip()
    return words if holds else f"no longer {words}"
