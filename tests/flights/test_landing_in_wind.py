"""A vehicle that swings in gusts lands in the middle of its room, not at the wall it swings to."""

from __future__ import annotations

import pytest
from lockstep import Lockstep
from meadow import stay
from shipped import MISSIONS
from test_leaning import low, windy

from companion.acting.landing_wait import LandingWait
from companion.flight_events.sortie import ControlTakenBack, Phase, PhaseEntered
from companion.flights.simulated_world import world_of
from companion.mission.loader import load_mission
from companion.outcomes import Progress
from sitl.flight.estimate import Wander

LOW_M, WIND_MPS = 1.0, 5.0
RADIUS_M = 0.35


class Landing(Lockstep):
    """Return_home at 1 m, with PX4's drag and a position that wanders, in wind.

    Attributes:
        least_m: the least room beside the vehicle while it lands.
    """

    def __init__(self, seed: int, *, resumes: bool = False) -> None:
        mission = load_mission(MISSIONS / "return_home.yaml")
        world = windy(world_of(mission), WIND_MPS, airframe="px4_sih", wander=Wander(0.25, 0.3))
        super().__init__(low(mission, LOW_M), world, seed=seed, resumes=resumes)
        self.least_m = 9.0

    def tick(self) -> None:
        super().tick()
        true_map = self.simulation.true_map
        if self.simulation.mode == "AUTO.LAND" and true_map is not None:
            here = self.simulation.flight.position[:2]
            self.least_m = min(self.least_m, true_map.clearance_m(here) - RADIUS_M)


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(n, marks=pytest.mark.long) for n in (0, 2, 3, 4))]
)
def test_it_keeps_half_a_metre_from_walls(seed: int) -> None:
    flown = Landing(seed).until_the_end(400.0)
    assert flown.exit_code == 0 and flown.least_m > 0.5


@pytest.mark.long
def test_handed_over_at_once_it_comes_nearer(monkeypatch: pytest.MonkeyPatch) -> None:
    """On the whole; which flights swing just then is chance."""
    seeds = (1, 4, 6, 7)
    waited_m = sum(Landing(seed).until_the_end(400.0).least_m for seed in seeds)
    monkeypatch.setattr(LandingWait, "tick", lambda _: Progress.DONE)
    at_once_m = sum(Landing(seed).until_the_end(400.0).least_m for seed in seeds)
    assert at_once_m < waited_m - 0.5


def held_in_its_landing() -> Landing:
    """The first one that swings then, 1.5 s after it was to land."""
    for seed in range(1, 10):
        flight = Landing(seed, resumes=True)
        flight.until_reported(PhaseEntered, phase=Phase.LANDING).run(1.5)
        if flight.simulation.mode == "OFFBOARD":
            return flight
    raise AssertionError("none is held")


@pytest.mark.long
def test_killed_while_it_is_held_it_lands_when_it_is_started_again() -> None:
    flight = held_in_its_landing()
    flight.kill()
    flight.run(2.5)
    flight.restart()
    flight.until_the_end(400.0)
    assert flight.exit_code == 0 and flight.simulation.collisions == 0
    assert flight.one(ControlTakenBack) and not flight.simulation.is_armed


def hop(room_m: float, wind_mps: float, seed: int) -> Lockstep:
    """Lands at A and takes off again, with PX4's drag and a wall downwind."""
    walls = [{"east_m": [20 + room_m, 20.5 + room_m], "north_m": [-6, 6]}]
    area = {"east_m": [-20, 40], "north_m": [-20, 20]}
    world = {"version": 1, "airframe": "px4_sih", "map": area | {"walls": walls}}
    wind = {"east_mps": wind_mps, "turbulence_mps": 0.2}
    mission = stay("land()", "wait(2)", "take_off()")
    flight = Lockstep(mission, world_of(mission, world | {"wind": wind}), seed=seed)
    return flight.until_the_end(200.0)


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(n, marks=pytest.mark.long) for n in range(2, 9))]
)
def test_four_metres_downwind_of_a_dock_are_enough_to_take_off(seed: int) -> None:
    """The autopilot's climb is carried off by up to 3 m: nearer to a wall it ends there."""
    assert hop(1.2, 4.0, seed).simulation.collisions > 0
    flight = hop(4.0, 4.0, seed)
    assert flight.exit_code == 0 and flight.simulation.collisions == 0
