"""The drag is learnt from flights of a point mass with drag, in wind, its velocity in error."""

from __future__ import annotations

import math
from random import Random

import pytest

from companion.motion.drag_estimate import GAP_S, DragEstimate
from sitl.flight.estimate import Wander, WanderingError

STEP_S = 0.05


def fly(
    estimate: DragEstimate,
    drag_per_s: float,
    wind: tuple[float, float] = (0.0, 0.0),
    seconds: float = 30.0,
    wander: WanderingError | None = None,
) -> None:
    """Legs there and back in changing directions, at up to 2 m/s."""
    velocity = [0.0, 0.0]
    for tick in range(round(seconds / STEP_S)):
        now_s = tick * STEP_S
        angle = math.radians(60) * (now_s // 6)
        speed = 2.0 * min(1.0, (now_s % 6) / 1.5, (6 - now_s % 6) / 1.5)
        wanted = (speed * math.cos(angle), speed * math.sin(angle))
        thrust = [
            drag_per_s * (v - w) + (u - v) / STEP_S * 0.5
            for v, w, u in zip(velocity, wind, wanted, strict=True)
        ]
        error = (0.0, 0.0)
        if wander is not None:
            wander.step(STEP_S)
            north, east = wander.velocity
            error = (north, east)
        told = (velocity[0] + error[0], velocity[1] + error[1])
        estimate.take(now_s, told, (thrust[0], thrust[1]))
        for axis in (0, 1):
            velocity[axis] += (thrust[axis] - drag_per_s * (velocity[axis] - wind[axis])) * STEP_S


@pytest.mark.parametrize("drag_per_s", [0.0, 0.1, 0.4, 1.0])
@pytest.mark.parametrize("wind", [(0.0, 0.0), (3.0, -1.0)])
def test_the_drag_is_learnt_whatever_the_wind(drag_per_s: float, wind: tuple[float, float]) -> None:
    estimate = DragEstimate()
    fly(estimate, drag_per_s, wind)
    assert estimate.per_s == pytest.approx(drag_per_s, abs=0.06)


def test_most_of_it_is_known_after_a_leg() -> None:
    estimate = DragEstimate()
    fly(estimate, 1.0, seconds=4.0)
    assert estimate.per_s > 0.7


@pytest.mark.parametrize("seed", range(5))
def test_it_is_learnt_by_a_velocity_that_wanders(seed: int) -> None:
    estimate = DragEstimate()
    fly(estimate, 0.7, seconds=60.0, wander=Wander(0.25, 0.3).level_error(Random(seed)))
    assert estimate.per_s == pytest.approx(0.7, abs=0.2)


def test_a_vehicle_without_drag_that_hovers_is_told_nothing() -> None:
    estimate = DragEstimate()
    wander = Wander(0.25, 0.3).level_error(Random(1))
    for tick in range(1200):
        wander.step(STEP_S)
        north, east = wander.velocity
        estimate.take(tick * STEP_S, (north, east), (0.0, 0.0))
    assert estimate.per_s < 0.1


def test_a_silence_and_a_pause_teach_nothing() -> None:
    estimate = DragEstimate()
    for tick in range(40):
        estimate.take(tick * 2 * GAP_S, (2.0 * (tick % 2), 0.0), (9.0, 0.0))
        estimate.pause()
    assert estimate.per_s == 0.0
