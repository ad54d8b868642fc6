"""Asking what happened: the events of a flight by their class and fields."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeGuard, TypeVar

from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.plans import PlanMade, PlanReplaced
from companion.flight_events.skills import PlaceReached

E = TypeVar("E", bound=FlightEvent)


class Replan(NamedTuple):
    """Why there is another plan, and its lasso."""

    reason: str
    lasso: str


class Happened:
    """Something that keeps what happened.

    Attributes:
        reports: what happened so far, with times.
    """

    reports: list[Stamped]

    @property
    def events(self) -> list[FlightEvent]:
        """What people are told of."""
        return [stamped.event for stamped in self.reports if stamped.event.is_told]

    @property
    def story(self) -> list[FlightEvent | str | Replan]:
        """What people are told of; of plans the lasso alone, e.g. "move(H, A), (wait)^w"."""
        return [_in_short(event) for event in self.events]

    @property
    def places(self) -> list[str]:
        """The places that were reached, in order."""
        return [event.place for event in self.of(PlaceReached)]

    def of(self, kind: type[E], **fields: Any) -> list[E]:
        """The events of a class, or a base class, that have these values in some fields."""
        return [event for event in (s.event for s in self.reports) if _is(event, kind, fields)]

    def one(self, kind: type[E], **fields: Any) -> E:
        """The only one of them."""
        (event,) = self.of(kind, **fields)
        return event

    def time_of(self, kind: type[FlightEvent], **fields: Any) -> float:
        """When the first of them happened."""
        return next(s.time_s for s in self.reports if _is(s.event, kind, fields))


def _in_short(event: FlightEvent) -> FlightEvent | str | Replan:
    match event:
        case PlanMade():
            return str(event.plan)
        case PlanReplaced():
            return Replan(event.reason, str(event.plan))
    return event


def _is(event: FlightEvent, kind: type[E], fields: dict[str, Any]) -> TypeGuard[E]:
    has_all = all(getattr(event, name, ...) == value for name, value in fields.items())
    return isinstance(event, kind) and has_all
