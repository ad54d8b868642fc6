"""A vehicle whose charge nobody knows is not armed for a mission with a battery."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from fakes import FakeVehicle
from states import changed

from companion.acting.sortie.preflight.failsafe_check import ANSWER_TIMEOUT_S
from companion.acting.sortie.preflight.gauge_check import GaugeCheck
from companion.outcomes import Failed, Progress


@pytest.fixture
def flight() -> Any:
    return SimpleNamespace(vehicle=FakeVehicle(), now_s=0.0)


def test_a_charge_that_is_told_is_enough(flight: Any) -> None:
    assert GaugeCheck(flight).tick() is Progress.DONE


def test_one_that_comes_late_is_waited_for(flight: Any) -> None:
    state, check = flight.vehicle.state, GaugeCheck(flight)
    flight.vehicle.state = changed(state, battery_percent=None)
    assert check.tick() is Progress.RUNNING
    flight.now_s, flight.vehicle.state = 3.0, state
    assert check.tick() is Progress.DONE


def test_without_one_it_says_what_to_do(flight: Any) -> None:
    flight.vehicle.state = changed(flight.vehicle.state, battery_percent=None)
    check = GaugeCheck(flight)
    check.tick()
    flight.now_s = ANSWER_TIMEOUT_S + 1
    outcome = check.tick()
    assert isinstance(outcome, Failed) and "BAT1_CAPACITY" in outcome.reason
