"""A vehicle that swings towards a wall is not handed over to the autopilot's landing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from py_trees.common import Status
from rig import Rig
from synthetic import mission

from companion.acting.behaviour_tree.landing import LandVehicle
from companion.acting.landing_wait import LONGEST_S, STEADY_S, LandingWait
from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid
from companion.motion.trajectory import Sample
from companion.outcomes import Progress
from companion.tick import TICK_S
from companion.vehicle.ports.goals import Goal
from companion.vehicle.ports.state import Mode

WALL_EAST_M = 1.5
"""Where a wall begins; the vehicle hovers at 0, and needs 0.6 m."""
BESIDE: Ned = (0.0, 1.0, -2.0)
STILL: Ned = (0.0, 0.0, 0.0)


def beside_a_wall() -> Rig:
    occupied = np.zeros((60, 60), dtype=np.bool_)
    occupied[:, 35:38] = True
    grid = OccupancyGrid(occupied, 0.1, (-2.0, -2.0))
    rig = Rig(replace(mission("F at(A)"), grid=grid))
    rig.flight.routes.find(10**6)
    rig.vehicle.change(mode=Mode.OFFBOARD, position=(0.0, 0.0, -2.0))
    rig.flight.guidance.hold_here()
    return rig


@pytest.mark.parametrize(
    ("position", "velocity", "awaited"),
    [
        ((0.0, 0.0, -2.0), STILL, Progress.DONE),
        ((0.0, 0.4, -2.0), STILL, Progress.DONE),
        (BESIDE, STILL, Progress.RUNNING),
        ((0.0, 0.4, -2.0), (0.0, 0.5, 0.0), Progress.RUNNING),
        ((0.0, 0.0, -2.0), (0.0, 0.5, 0.0), Progress.DONE),
        ((0.0, 0.0, -2.0), (1.5, 0.0, 0.0), Progress.DONE),
        (BESIDE, (0.0, -0.5, 0.0), Progress.RUNNING),
    ],
)
def test_it_is_held_while_it_is_or_will_be_nearer_to_a_wall_than_its_setpoint(
    position: Ned, velocity: Ned, awaited: Progress
) -> None:
    rig = beside_a_wall()
    rig.vehicle.change(position=position, velocity=velocity)
    assert LandingWait(rig.flight).tick() is awaited


def test_what_lands_beside_a_wall_is_no_nearer_to_it_than_it_shall_be() -> None:
    rig = beside_a_wall()
    rig.vehicle.change(position=BESIDE)
    rig.flight.guidance.hold_here()
    assert LandingWait(rig.flight).tick() is Progress.DONE


def test_it_is_held_where_it_shall_be_and_for_no_longer_than_ten_seconds() -> None:
    rig = beside_a_wall()
    told = rig.flight.guidance.setpoint
    rig.vehicle.change(position=BESIDE)
    wait, ticks = LandingWait(rig.flight), 0
    while wait.tick() is Progress.RUNNING:
        assert rig.flight.guidance.setpoint == told
        ticks += 1
        rig.flight.now_s += TICK_S
    assert ticks == round(LONGEST_S / TICK_S)


def test_who_is_not_ours_to_hold_is_not_waited_for() -> None:
    rig = beside_a_wall()
    rig.vehicle.change(position=BESIDE, mode=Mode.LOITER)
    assert LandingWait(rig.flight).tick() is Progress.DONE
    rig.vehicle.state = None
    assert LandingWait(rig.flight).tick() is Progress.DONE


def test_what_has_been_handed_over_is_not_held_again() -> None:
    """Also not on the ground, where a PX4 without motors is in OFFBOARD again."""
    rig = beside_a_wall()
    wait = LandingWait(rig.flight)
    assert wait.tick() is Progress.DONE
    rig.vehicle.change(position=BESIDE)
    sent = len(rig.vehicle.flown)
    assert wait.tick() is Progress.DONE and len(rig.vehicle.flown) == sent


def test_a_skill_that_lands_waits_too_each_time_anew() -> None:
    rig = beside_a_wall()
    land = LandVehicle(rig.flight, "land")
    for _ in range(2):
        rig.vehicle.pursued.clear()
        rig.vehicle.change(position=BESIDE, mode=Mode.OFFBOARD, is_landed=False)
        rig.flight.guidance.fly(Sample((0.0, 0.0, -2.0), STILL, STILL, is_finished=True))
        land.tick_once()
        assert (land.status, rig.vehicle.pursued) == (Status.RUNNING, [])
        rig.vehicle.change(position=(0.0, 0.0, -2.0))
        land.tick_once()
        assert (land.status, rig.vehicle.pursued) == (
            Status.RUNNING,
            [],
        )  # the middle of a swing
        rig.flight.now_s += STEADY_S
        land.tick_once()
        assert (land.status, rig.vehicle.pursued) == (Status.SUCCESS, [Goal.LANDED])
