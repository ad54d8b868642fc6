"""When a dock is given up: it gives nothing, or too little, and there is another one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest
from py_trees.common import Status
from states import changed, standing

from companion.acting.behaviour_tree.landing import NO_CHARGE_S, ChargeBattery
from companion.acting.flight import Flight
from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import BatteryCharged, ChargeAwaited, ChargeCutShort

RATE = 0.1
"""Percent a second that the mission says; 120 s are 12 %."""


class Charging:
    """A vehicle on a dock, from 20 % to 60 %."""

    def __init__(self) -> None:
        self.patience_s, self.percent = 0.0, 20.0
        self.reports: list[FlightEvent] = []
        self.flight = SimpleNamespace(
            now_s=0.0,
            report=self.reports.append,
            vehicle=SimpleNamespace(state=changed(standing(), percent=20)),
            dock=self,
            task=SimpleNamespace(word=SimpleNamespace(is_called=False)),
        )
        self.leaf = ChargeBattery(cast(Flight, self.flight), 60, 30)
        self.leaf.initialise()

    def charging_s(self, before: float, after: float) -> float:
        return (after - before) / RATE

    def give(self, seconds: float, rate: float) -> Status:
        """What the leaf says after some time, or as soon as it ends."""
        for _ in range(round(seconds)):
            self.flight.now_s += 1.0
            self.percent += rate
            vehicle = self.flight.vehicle
            vehicle.state = changed(vehicle.state, percent=int(self.percent))
            if (status := self.leaf.update()) is not Status.RUNNING:
                return status
        return Status.RUNNING


def test_a_dock_that_keeps_its_rate_charges_to_the_end() -> None:
    assert Charging().give(600, RATE * 0.7) is Status.SUCCESS


@pytest.mark.parametrize(("rate", "after_s"), [(0.0, 122), (0.04, 243)])
def test_one_that_gives_nothing_or_too_little_is_given_up(rate: float, after_s: int) -> None:
    charging = Charging()
    assert charging.give(after_s - 2, rate) is Status.RUNNING
    assert charging.give(2, rate) is Status.FAILURE and not charging.reports


@pytest.mark.parametrize("cut_s", [0.75 * NO_CHARGE_S, 5 * NO_CHARGE_S])
def test_a_power_cut_is_no_slow_dock(cut_s: float) -> None:
    """Not even where the vehicle could go to another one as soon as it charges again."""
    charging = Charging()
    charging.patience_s = 900.0
    assert charging.give(30, RATE) is Status.RUNNING
    assert charging.give(cut_s, 0.0) is Status.RUNNING
    assert charging.give(15, RATE) is Status.RUNNING
    charging.patience_s = 0.0
    assert charging.give(600, RATE) is Status.SUCCESS
    told = [event for event in charging.reports if isinstance(event, ChargeAwaited)]
    assert len(told) == (cut_s > NO_CHARGE_S)


def test_where_there_is_no_other_one_it_stays_for_as_long_as_it_waits() -> None:
    charging = Charging()
    charging.patience_s = 300.0
    assert charging.give(500, 0.04) is Status.RUNNING and not charging.reports
    assert charging.give(NO_CHARGE_S + 240, 0.0) is Status.RUNNING
    assert charging.give(100, 0.0) is Status.FAILURE


def test_an_event_that_is_answered_ends_a_charge_with_enough_for_it() -> None:
    charging = Charging()
    charging.flight.task.word.is_called = True
    assert charging.give(95, RATE) is Status.RUNNING  # 29 %
    assert charging.give(10, RATE) is Status.SUCCESS
    assert charging.reports == [ChargeCutShort(30)]
    assert Charging().give(400, RATE) is Status.SUCCESS


def test_without_a_line_that_is_ready_no_event_ends_it() -> None:
    charging = Charging()
    charging.leaf = ChargeBattery(cast(Flight, charging.flight), 60)
    charging.leaf.initialise()
    charging.flight.task.word.is_called = True
    assert charging.give(400, RATE) is Status.SUCCESS
    assert charging.reports == [BatteryCharged(60)]
