"""What the autopilot believes: exact with good GPS, bounded with noise, growing without GPS."""

from __future__ import annotations

import math
import random
from itertools import pairwise
from statistics import fmean

import pytest

from companion.geometry import GlobalOrigin
from sitl.flight.estimate import (
    CLAIMED_M,
    VELOCITY_WALK,
    WANDER_S,
    Estimator,
    GpsQuality,
    Wander,
)
from sitl.flight.physics import FlightState, Physics

TRUTH = Physics(origin=GlobalOrigin(47.4, 8.5, 0.0), start=(3.0, -2.0, -5.0)).state


def believe(estimator: Estimator, seconds: float, dt_s: float = 0.1) -> FlightState:
    start_s = estimator.time_since_fix_s
    belief = estimator.step(TRUTH, start_s)
    for i in range(1, round(seconds / dt_s) + 1):
        belief = estimator.step(TRUTH, start_s + i * dt_s)
    return belief


def test_good_gps_is_the_truth_itself() -> None:
    estimator = Estimator(random.Random(1))
    assert all(estimator.step(TRUTH, 0.004 * i) is TRUTH for i in range(100))


def test_noise_wanders_with_its_deviation_and_its_correlation() -> None:
    """A Gauss-Markov process: variance s^2, correlation exp(-t / tau)."""
    estimator = Estimator(random.Random(3), GpsQuality(noise_m=0.5))
    errors = []
    for i in range(100_000):  # 30 000 s are 500 correlation times
        errors.append(estimator.step(TRUTH, 0.3 * i).position[0] - TRUTH.position[0])
    variance = fmean(e * e for e in errors)
    # The relative deviation of the variance is sqrt(2 tau / T) = 6 %.
    assert math.sqrt(variance) == pytest.approx(0.5, rel=0.1)
    for lag_s in (6.0, 30.0, 60.0):
        lag = round(lag_s / 0.3)
        correlation = fmean(a * b for a, b in zip(errors, errors[lag:], strict=False)) / variance
        assert correlation == pytest.approx(math.exp(-lag_s / WANDER_S), abs=0.1)


def test_the_step_length_does_not_matter() -> None:
    def deviation(dt_s: float) -> float:
        ends = []
        for seed in range(600):
            estimator = Estimator(random.Random(seed), GpsQuality())
            estimator.gps = GpsQuality(noise_m=1.0)
            ends.append(believe(estimator, 20.0, dt_s).position[1] - TRUTH.position[1])
        return math.sqrt(fmean(e * e for e in ends))

    expected = math.sqrt(1 - math.exp(-2 * 20.0 / WANDER_S))
    assert deviation(0.5) == pytest.approx(expected, rel=0.1)
    assert deviation(4.0) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("seconds", [5.0, 20.0])
def test_dead_reckoning_drifts_as_an_integrated_random_walk(seconds: float) -> None:
    drifts, speeds = [], []
    for seed in range(600):
        estimator = Estimator(random.Random(seed), GpsQuality(is_lost=True))
        belief = believe(estimator, seconds)
        drifts += [b - t for b, t in zip(belief.position[:2], TRUTH.position[:2], strict=True)]
        speeds += [b - t for b, t in zip(belief.velocity[:2], TRUTH.velocity[:2], strict=True)]
        assert estimator.time_since_fix_s == pytest.approx(seconds)
    assert math.sqrt(fmean(d * d for d in drifts)) == pytest.approx(
        VELOCITY_WALK * math.sqrt(seconds**3 / 3), rel=0.1
    )
    assert math.sqrt(fmean(s * s for s in speeds)) == pytest.approx(
        VELOCITY_WALK * math.sqrt(seconds), rel=0.1
    )
    assert abs(fmean(drifts)) < 0.15 * VELOCITY_WALK * math.sqrt(seconds**3 / 3)


def test_height_and_attitude_stay_true_without_gps() -> None:
    estimator = Estimator(random.Random(1), GpsQuality(is_lost=True, noise_m=2.0))
    belief = believe(estimator, 30.0)
    assert math.dist(belief.position, TRUTH.position) > 0.5
    assert belief == TRUTH._replace(
        position=(*belief.position[:2], TRUTH.position[2]),
        velocity=(*belief.velocity[:2], TRUTH.velocity[2]),
    )


def test_a_fix_after_a_loss_takes_the_belief_back() -> None:
    estimator = Estimator(random.Random(1))
    assert estimator.step(TRUTH, 0.0) is TRUTH
    estimator.gps = GpsQuality(is_lost=True)
    first = estimator.step(TRUTH, 0.004)
    assert math.dist(first.position, TRUTH.position) < 1e-3  # no jump at the loss
    lost = estimator.step(TRUTH, 10.0)
    assert lost.velocity != TRUTH.velocity
    estimator.gps = GpsQuality()
    assert estimator.step(TRUTH, 10.004) is TRUTH
    assert estimator.time_since_fix_s == 0.0


def test_noise_that_ends_fades_to_the_truth() -> None:
    estimator = Estimator(random.Random(1), GpsQuality(noise_m=1.0))
    estimator.step(TRUTH, 0.0)
    before = math.hypot(*estimator.error)
    estimator.gps = GpsQuality()
    estimator.step(TRUTH, WANDER_S)
    assert math.hypot(*estimator.error) == pytest.approx(before / math.e)
    assert estimator.step(TRUTH, 20 * WANDER_S) is TRUTH


def test_the_same_seed_is_the_same_error() -> None:
    def track(seed: int) -> list[FlightState]:
        estimator = Estimator(random.Random(seed), GpsQuality(noise_m=0.5))
        return [estimator.step(TRUTH, 0.1 * i) for i in range(50)]

    assert track(5) == track(5) != track(6)


@pytest.mark.long
def test_wander_has_its_deviations_in_position_and_velocity() -> None:
    """As PX4's filter: 0.25 m and 0.3 m/s, and the velocity's error moves the position."""
    estimator = Estimator(random.Random(4), wander=Wander(0.25, 0.3))
    positions, velocities = [], []
    for i in range(100_000):
        belief = estimator.step(TRUTH, 0.02 * i)
        positions.append(math.dist(belief.position, TRUTH.position))
        velocities.append(math.dist(belief.velocity, TRUTH.velocity))
    assert math.sqrt(fmean(e * e for e in positions)) == pytest.approx(0.25, rel=0.1)
    assert math.sqrt(fmean(e * e for e in velocities)) == pytest.approx(0.3, rel=0.1)
    assert 0.5 < max(positions) < 1.1
    steps = [abs(b - a) for a, b in pairwise(positions)]
    assert max(steps) < 0.03  # no jumps


def test_the_same_seed_wanders_the_same_way() -> None:
    def beliefs(seed: int) -> list[FlightState]:
        estimator = Estimator(random.Random(seed), wander=Wander(0.25, 0.3))
        return [estimator.step(TRUTH, 0.1 * i) for i in range(50)]

    assert beliefs(1) == beliefs(1) != beliefs(2)


def test_the_accuracy_that_is_told_follows_the_errors() -> None:
    def accuracy_m(estimator: Estimator, seconds: float = 0.0) -> float:
        believe(estimator, seconds)
        return estimator.accuracy_m

    good = accuracy_m(Estimator(random.Random(1)))
    assert good == CLAIMED_M
    assert accuracy_m(Estimator(random.Random(1), wander=Wander(0.25, 0.3))) == pytest.approx(
        math.hypot(good, 0.25)
    )
    noisy = Estimator(random.Random(1), GpsQuality(noise_m=2.0))
    assert accuracy_m(noisy) > 2.0 * math.sqrt(2)
    lost = Estimator(random.Random(1), GpsQuality(is_lost=True))
    assert accuracy_m(lost, 20.0) > 7.0
    lost.gps = GpsQuality()
    lost.step(TRUTH, 30.0)
    assert lost.accuracy_m == good


@pytest.mark.long
def test_a_height_wanders_with_its_deviation_and_is_what_its_velocity_makes_of_it() -> None:
    estimator = Estimator(random.Random(5), wander=Wander(0.25, 0.3, height_m=0.5))
    dt_s = 0.02
    seen = [estimator.step(TRUTH, dt_s * i) for i in range(100_000)]  # 100 time constants
    errors = [belief.position[2] - TRUTH.position[2] for belief in seen]
    assert math.sqrt(fmean(e * e for e in errors)) == pytest.approx(0.5, rel=0.1)
    rises = [(b - a) / dt_s for a, b in pairwise(errors)]
    off_mps = [belief.velocity[2] - TRUTH.velocity[2] for belief in seen]
    assert max(abs(a - b) for a, b in zip(rises, off_mps, strict=False)) < 0.2
    assert estimator.accuracy_m == pytest.approx(math.hypot(CLAIMED_M, 0.25))


def test_a_height_wanders_only_where_that_is_asked_for() -> None:
    level, all_three = (
        Estimator(random.Random(5), wander=Wander(0.25, 0.3, height_m)) for height_m in (0.0, 0.5)
    )
    for estimator in (level, all_three):
        believe(estimator, 10.0)
    assert level.seen(TRUTH).position[2] == TRUTH.position[2]
    assert all_three.seen(TRUTH).position[2] != TRUTH.position[2]
