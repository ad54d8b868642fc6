"""What flights really take is learnt: bad news at once, good news slowly, within limits."""

from __future__ import annotations

from random import Random

import pytest

from companion.acting.journal import EnergyLearnt, FlightBegun, PhaseBegun, put_together
from companion.flight_events.sortie import Phase
from companion.planning.energy.model import FACTOR
from companion.planning.energy.ratio_estimate import LEAST, MOST, KnownRatios, RatioEstimate

NOISE = 0.03


def learnt(truth: float, measurements: int, known: RatioEstimate | None = None) -> RatioEstimate:
    chance, found = Random(1), known or KnownRatios().flying
    for _ in range(measurements):
        found = found.after(chance.gauss(truth, NOISE), NOISE, 60.0)
    return found


def test_plans_begin_with_the_figures_and_what_they_may_be_off_by() -> None:
    assert KnownRatios().to_plan_with == pytest.approx(FACTOR)


@pytest.mark.parametrize("truth", [0.85, 0.95, 1.0, 1.1, 1.25, 2.0])
def test_it_settles_at_what_is_true(truth: float) -> None:
    settled = learnt(truth, 30)
    assert settled.mean == pytest.approx(truth, abs=0.04) and settled.deviation < 0.02


def test_more_is_believed_at_once_and_less_slowly() -> None:
    assert learnt(1.3, 1).mean > 1.25
    assert learnt(0.8, 1).mean > 0.88


@pytest.mark.parametrize(("measured", "limit"), [(9.0, MOST), (0.0, LEAST)])
def test_there_are_limits(measured: float, limit: float) -> None:
    known = RatioEstimate(1.0, 0.025)
    for _ in range(50):
        known = known.after(measured, NOISE, 60.0)
    assert known.mean == limit
    assert LEAST <= KnownRatios(known).to_plan_with <= MOST


def test_a_flight_that_is_gone_on_with_knows_it() -> None:
    begun, last = FlightBegun("a", "a.yaml", "", 0.0), EnergyLearnt(1.2, 0.02, 1.1, 0.03)
    armed, first = PhaseBegun(Phase.ARMING), EnergyLearnt(1.3, 0.1, 1.0, 0.1)
    flight = put_together([(0.0, begun), (1.0, armed), (60.0, first), (99.0, last)])
    assert flight is not None and flight.energy == last
