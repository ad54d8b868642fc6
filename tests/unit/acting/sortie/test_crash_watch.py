"""Signs of a crash on the wire, and what is none: landings, hard or with a wandering estimate."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from random import Random

import pytest
from states import changed, flying

from companion.acting.sortie.crash_watch import DISARMED_S, OVERTURNED_S, Crash, CrashWatch
from companion.geometry import Ned
from companion.vehicle.ports.state import VehicleState
from companion.vehicle_profile import VehicleProfile
from sitl.flight.estimate import Wander

TICK_S = 0.05
FLYING = flying()


def watch(states: Iterable[VehicleState]) -> Crash | None:
    """The last sign."""
    watch, crash = CrashWatch(VehicleProfile()), None
    for tick, state in enumerate(states):
        now_s = TICK_S * tick
        crash = watch.step(now_s, changed(state, motion_received_s=now_s, boot_s=now_s))
    return crash


def at(velocities: Iterable[Ned], state: VehicleState = FLYING) -> Iterator[VehicleState]:
    return (changed(state, velocity=velocity) for velocity in velocities)


def seconds(state: VehicleState, duration_s: float) -> list[VehicleState]:
    return [state] * round(duration_s / TICK_S)


DISARMED = changed(FLYING, is_armed=False)
ON_GROUND = replace(FLYING, is_landed=True)
DONE = replace(DISARMED, is_landed=True)
SINKING = changed(FLYING, velocity=(0.0, 0.0, 0.7))


@pytest.mark.parametrize("descent_mps", [0.3, 0.7, 1.0, 1.5])
def test_a_landing_is_none_however_hard_its_touch_down(descent_mps: float) -> None:
    sinking = changed(FLYING, velocity=(0.0, 0.0, descent_mps))
    bounce = list(at([(0.0, 0.0, -0.3), (0.2, 0.0, 0.2)]))
    landing = [*seconds(sinking, 1.0), *bounce, *seconds(FLYING, 1.0), *seconds(ON_GROUND, 2.0)]
    assert watch([*landing, *seconds(DONE, 5.0)]) is None


def test_a_landing_that_is_told_just_after_the_disarming_is_none() -> None:
    late = seconds(DISARMED, DISARMED_S - 0.1)
    assert (
        watch([*seconds(SINKING, 1.0), *seconds(FLYING, 1.0), *late, *seconds(DONE, 5.0)]) is None
    )


def test_disarmed_in_the_air_is_one_although_the_vehicle_is_said_to_land_later() -> None:
    fallen = [*seconds(DISARMED, 0.9), *seconds(DONE, 2.0)]
    assert watch([*seconds(FLYING, 1.0), *fallen]) is Crash.DISARMED


def test_a_fall_is_seen_before_the_heartbeat_that_tells_of_the_disarming() -> None:
    fall = at((0.0, 0.0, 9.8 * TICK_S * i) for i in range(10))
    assert watch([*seconds(FLYING, 1.0), *fall, *seconds(DONE, 2.0)]) is Crash.FALL


def test_a_clock_that_begins_anew_is_no_impact() -> None:
    """After a reboot of the autopilot; 3 s later its clock says again what it said before."""
    watch, crash = CrashWatch(VehicleProfile()), None
    for tick in range(140):
        now_s = TICK_S * tick
        before = now_s < 3.0
        state = changed(FLYING, velocity=(2.0 if before else 0.0, 0.0, 0.0))
        measured_s = now_s if before else now_s - 3.0
        crash = watch.step(now_s, changed(state, motion_received_s=now_s, boot_s=measured_s))
    assert crash is None


def test_a_wall_stops_the_vehicle_at_once_and_brakes_do_not() -> None:
    cruise = list(at([(2.0, 0.0, 0.0)] * 20))
    assert watch([*cruise, *seconds(FLYING, 1.0)]) is Crash.IMPACT
    braking = at((2.0 - 5.0 * TICK_S * i, 0.0, 0.0) for i in range(9))
    assert watch([*cruise, *braking, *seconds(FLYING, 1.0)]) is None


def test_a_silence_between_two_velocities_is_no_jump() -> None:
    watch = CrashWatch(VehicleProfile())
    for now_s, north_mps in ((0.0, 2.0), (0.05, 2.0), (0.1, 2.0), (0.9, 0.0)):
        velocity = (north_mps, 0.0, 0.0)
        state = changed(FLYING, motion_received_s=now_s, boot_s=now_s, velocity=velocity)
        assert watch.step(now_s, state) is None


def test_a_vehicle_that_lies_on_its_back_is_overturned_in_the_air_and_on_the_ground() -> None:
    over = math.radians(100.0)
    for lying in (changed(FLYING, tilt_rad=over), changed(ON_GROUND, tilt_rad=over)):
        assert watch([*seconds(FLYING, 1.0), *seconds(lying, OVERTURNED_S + 0.2)]) is (
            Crash.OVERTURNED
        )
    steep = changed(FLYING, tilt_rad=math.radians(45.0))
    assert watch([*seconds(FLYING, 1.0), *seconds(steep, 5.0)]) is None


def test_a_later_sign_may_follow_an_impact_and_none_follows_a_fall() -> None:
    cruise = list(at([(2.0, 0.0, 0.0)] * 20))
    assert watch([*cruise, *seconds(FLYING, 1.0), *seconds(DISARMED, 1.0)]) is Crash.DISARMED
    fall = [changed(FLYING, velocity=(0.0, 0.0, 4.0))]
    assert watch([*seconds(FLYING, 1.0), *fall, *seconds(DISARMED, 1.0)]) is Crash.FALL


def test_an_estimate_that_wanders_jumps_nowhere() -> None:
    for seed in range(20):
        wander = Wander(0.25, 0.3).level_error(Random(seed))
        velocities: list[Ned] = []
        for _ in range(1000):
            wander.step(TICK_S)
            north, east = wander.velocity
            velocities.append((north, east, 0.7))
        assert watch(at(velocities)) is None


def test_before_the_vehicle_was_in_the_air_nothing_is_judged() -> None:
    assert watch([*seconds(DONE, 1.0), *seconds(ON_GROUND, 1.0), *seconds(DONE, 5.0)]) is None
