"""A vehicle that gusts move about keeps more from walls: what it is seen to be off its way."""

from __future__ import annotations

import pytest
from lockstep import Lockstep
from shipped import MISSIONS
from test_leaning import low, windy

from companion.flight_events.skills import ClearanceChanged, SkillCompleted
from companion.flights.simulated_world import world_of
from companion.mission.loader import load_mission
from sitl.flight.estimate import Wander

OFF_M = 0.4


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 13))
def test_past_a_pillar_at_1_m_in_4_mps(seed: int) -> None:
    """The way leads 2 m wide between a pillar and a box, and on along a wall."""
    mission = load_mission(MISSIONS / "inspection.yaml")
    about = {"airframe": "px4_sih", "wander": Wander(0.25, 0.3)}
    flight = Lockstep(low(mission, 1.0), windy(world_of(mission), 4.0, **about), seed=seed)
    flight.until_the_end(600.0)
    assert flight.exit_code == 0 and flight.simulation.collisions == 0
    assert max(changed.off_m for changed in flight.of(ClearanceChanged)) > OFF_M


def test_without_wind_and_with_an_exact_position_nothing_is_added() -> None:
    mission = load_mission(MISSIONS / "inspection.yaml")
    flight = Lockstep(mission, world_of(mission)).until_reported(SkillCompleted)
    assert not flight.of(ClearanceChanged)
