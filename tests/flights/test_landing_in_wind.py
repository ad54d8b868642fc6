"""A vehicle that swings in gusts lands in the middle of its room, not at the wall it swings to."""

from __future__ import annotations

import pytest
from lockstep import Lockstep
from shipped import MISSIONS
from test_leaning import low, windy

from companion.acting.landing_wait import LandingWait
from companion.api.simulating import world_of
from companion.mission.loader import load_mission
from companion.vehicle.port import Progress
from sitl.flight.estimate import Wander

LOW_M, WIND_MPS = 1.0, 5.0
RADIUS_M = 0.35


class Landed(Lockstep):
    """Return_home at 1 m, with PX4's drag and a position that wanders, in wind.

    Attributes:
        least_m: the least room beside the vehicle while it lands.
    """

    def __init__(self, seed: int) -> None:
        mission = load_mission(MISSIONS / "return_home.yaml")
        world = windy(world_of(mission), WIND_MPS, airframe="px4_sih", wander=Wander(0.25, 0.3))
        super().__init__(low(mission, LOW_M), world, seed=seed)
        true_map, self.least_m = self.simulation.true_map, 9.0
        assert true_map is not None
        while not self.companion.has_ended:
            self.tick()
            if self.simulation.mode == "AUTO.LAND":
                here = self.simulation.flight.position[:2]
                self.least_m = min(self.least_m, true_map.clearance_m(here) - RADIUS_M)


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(n, marks=pytest.mark.long) for n in (0, 2, 3, 4))]
)
def test_it_keeps_half_a_metre_from_walls(seed: int) -> None:
    flown = Landed(seed)
    assert flown.exit_code == 0 and flown.least_m > 0.5


def test_handed_over_at_once_it_comes_to_a_wall(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LandingWait, "tick", lambda _: Progress.DONE)
    assert Landed(1).least_m < 0.2
