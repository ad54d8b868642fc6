"""Turns what is heard into facts: events of the mission begin and end, and beliefs come back."""

from __future__ import annotations

from collections.abc import Sequence

from companion.acting.event_detector import EventDetector
from companion.acting.executive import Executive
from companion.acting.flight import Flight
from companion.flight_events.facts import BeliefRestored, MissionEventChanged
from companion.mission.signals import Signal


class Perception:
    """Keeps the facts of a flight as they are heard.

    Args:
        flight: whose task has the facts.
        executive: says whether there is a plan, and makes another one if a belief comes back.
        detector: detects the mission's events.
    """

    def __init__(self, flight: Flight, executive: Executive, detector: EventDetector) -> None:
        self._flight, self._executive, self._detector = flight, executive, detector
        self._events = executive.planner.mission.events

    def take(self, readings: Sequence[tuple[Signal, float]]) -> None:
        """Takes received readings; also without any, time may change facts."""
        flight, events = self._flight, self._events
        restores: frozenset[str] = frozenset()
        for name, holds in self._detector.update(flight.now_s, flight.hear(readings)):
            flight.task.take(events[name], holds)
            flight.report(MissionEventChanged(name, holds))
            restores |= events[name].restores if holds else frozenset()
        is_waiting = not self._executive.may_have_plan
        for belief in flight.task.restore(flight.now_s, is_waiting, restores):
            flight.report(BeliefRestored(belief))
            self._executive.deliberation.assumptions.note_restored_beliefs()
