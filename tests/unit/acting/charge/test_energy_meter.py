"""What actions take is measured from their beginning to their end, or as far as they came."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from states import changed, flying

from companion.acting.charge.energy_meter import UNITS_PER_J, EnergyMeter
from companion.flight_events.energy import EnergyUsed
from companion.mission.steps import Fly, Wait
from companion.planning.energy.ratio_estimate import KnownRatios
from companion.tick import TICK_S

POWER_W = 180.0
LEG_S = 70.0


class Stretch:
    """Legs, and a charge, of a flight that takes another power than its plan says.

    Args:
        more: what it takes of what is predicted.
        is_told: whether the autopilot tells voltage and current.
        ages: what the gauge counts of what is taken.
    """

    def __init__(self, more: float, is_told: bool = True, ages: float = 1.0) -> None:
        self._power_w, self._ages, self.level = POWER_W * more, ages, 6000.0
        state = changed(flying(), power_w=self._power_w if is_told else None, percent=50)
        self.reports: list[Any] = []
        self.ahead = math.nan
        self.execute: tuple[Fly | Wait, ...] = (Fly("A"),)
        flight: Any = SimpleNamespace(
            vehicle=SimpleNamespace(state=state),
            task=SimpleNamespace(running=None, completed=0),
            progress=SimpleNamespace(is_landed_by_plan=False),
            note=lambda entry: None,
            report=self.reports.append,
            now_s=0.0,
        )
        energy: Any = SimpleNamespace(
            known=KnownRatios(),
            model=SimpleNamespace(factor=1.0, full=7000),
            charge=SimpleNamespace(middle=lambda: round(self.level)),
            left_to=lambda *_: self.ahead,
        )
        self.flight, self.energy = flight, energy
        self.meter = EnergyMeter(flight, energy)

    def leg(self, seconds: float = LEG_S, is_completed: bool = True) -> Stretch:
        """An action that is to take so long; it is cut short in the middle if not completed."""
        drain = POWER_W * seconds * UNITS_PER_J
        task = self.flight.task
        about = {"destination": "A", "execute": self.execute}
        task.running = SimpleNamespace(drain=drain, charger=None, **about)
        flown_s = seconds if is_completed else seconds / 2
        for _ in range(round(flown_s / TICK_S)):
            self.ahead = drain / 2
            self._tick(self._power_w)
        task.running = None
        task.completed += is_completed
        self._tick(0.0)
        return self

    def charge(self) -> Stretch:
        self.flight.task.running = SimpleNamespace(charger=object())
        self._tick(0.0)
        return self

    def _tick(self, power_w: float) -> None:
        self.flight.now_s += TICK_S
        self.level -= power_w * TICK_S * UNITS_PER_J * self._ages
        self.meter.step()


@pytest.mark.parametrize(("is_told", "least"), [(True, 1.25), (False, 1.2)])
def test_what_flights_take_is_learnt_by_current_or_gauge(is_told: bool, least: float) -> None:
    stretch = Stretch(1.3, is_told).leg().leg().charge()
    assert least < stretch.energy.known.mean < 1.32
    (used,) = stretch.reports
    assert isinstance(used, EnergyUsed)
    assert used.used_wh == pytest.approx(POWER_W * 1.3 * 2 * LEG_S / 3600, rel=0.02)
    assert used.expected_wh == pytest.approx(used.used_wh / 1.3, rel=0.02)  # as known before it


def test_a_pack_that_has_aged_is_told_by_its_gauge() -> None:
    known = Stretch(1.0, ages=1.25).leg().leg().leg().charge().energy.known
    assert known.flying.mean == pytest.approx(1.0, abs=0.02)
    assert known.gauge.mean > 1.15


def test_a_leg_that_is_cut_short_counts_as_far_as_it_came() -> None:
    known = Stretch(1.3).leg(2 * LEG_S, is_completed=False).charge().energy.known
    assert known.flying.mean == pytest.approx(1.3, abs=0.05)


def test_a_gauge_that_jumps_begins_the_measurement_anew() -> None:
    stretch = Stretch(1.0, is_told=False).leg()
    stretch.level -= 0.3 * stretch.energy.model.full
    stretch.leg().charge()
    (used,) = stretch.reports
    assert used.used_wh == pytest.approx(POWER_W * LEG_S / 3600, rel=0.02)  # of the leg after it
    assert stretch.energy.known.mean == pytest.approx(1.0, abs=0.05)


def test_one_of_which_nobody_knows_how_far_it_came_does_not_count() -> None:
    stretch = Stretch(1.3)
    stretch.energy.left_to = lambda *_: None
    stretch.leg(2 * LEG_S, is_completed=False).charge()
    assert stretch.energy.known == KnownRatios() and not stretch.reports


def test_nor_does_one_that_waits_which_may_have_waited_already() -> None:
    stretch = Stretch(1.3)
    stretch.execute = Fly("A"), Wait(20.0)
    stretch.leg(2 * LEG_S, is_completed=False).charge()
    assert stretch.energy.known == KnownRatios() and not stretch.reports
