"""What all behaviours of a flight share: its reports."""

from __future__ import annotations

from rig import Rig
from synthetic import mission

from companion.flight_events.event import Stamped
from companion.flight_events.sortie import ControlRegained, StopRequested


def test_a_report_has_the_time_of_its_tick_and_one_from_beside_the_flight_its_own() -> None:
    flight = Rig(mission("F at(A)")).flight
    flight.now_s = 2.0
    flight.report(StopRequested())
    flight.add_report(Stamped(1.5, ControlRegained()))
    assert flight.reports == [Stamped(2.0, StopRequested()), Stamped(1.5, ControlRegained())]


def test_what_has_happened_is_collected_once() -> None:
    flight = Rig(mission("F at(A)")).flight
    flight.report(StopRequested())
    assert flight.collect_reports() == [Stamped(0.0, StopRequested())]
    assert flight.collect_reports() == []
