"""A flight of one mission: what is opened for it, and what its record says if no vehicle comes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from notes import Notes
from synthetic import mission

from companion.errors import LinkTimeout, MissionError
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import RunFailed
from companion.flights import only_flight as subject
from companion.flights.only_flight import only_flight
from companion.flights.options import USUAL_OPTIONS
from companion.skills.runner import FunctionRunner


class Closing(FunctionRunner):
    """Notes when it is closed."""

    is_closed = False

    def close(self) -> None:
        super().close()
        Closing.is_closed = True


def fail(error: Exception, ticks: int = 0, notes: Notes | None = None, **options: Any) -> None:
    """A flight that is ended by an error while it waits to hear how high the ground is."""
    flown = mission("F at(A)")
    places = {**flown.places, "A": replace(flown.places["A"], amsl_m=490.0)}
    flying = only_flight(
        replace(flown, places=places), notes or Notes(), USUAL_OPTIONS, folder=None, **options
    )
    with flying as companion:
        for number in range(ticks):
            companion.step(0.05 * number, [])
        raise error


def test_a_flight_without_a_vehicle_is_recorded_with_its_end() -> None:
    notes = Notes()
    with pytest.raises(LinkTimeout):
        fail(LinkTimeout("no vehicle"), ticks=21, notes=notes)
    assert notes.reports == [Stamped(1.0, RunFailed("no vehicle", LinkTimeout.exit_code))]


def test_one_that_can_be_resumed_has_no_end() -> None:
    notes = Notes()
    flown: Any = SimpleNamespace(seen=None)
    with pytest.raises(LinkTimeout):
        fail(LinkTimeout("no vehicle"), notes=notes, journalled=flown)
    assert notes.reports == []


def test_another_error_is_no_end_of_the_flight() -> None:
    notes = Notes()
    with pytest.raises(MissionError):
        fail(MissionError("something else"), notes=notes)
    assert notes.reports == []


def test_the_processes_of_functions_end_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subject, "FunctionRunner", Closing)
    with pytest.raises(LinkTimeout):
        fail(LinkTimeout("no vehicle"))
    assert Closing.is_closed
