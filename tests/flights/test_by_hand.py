"""A mission whose tree was written by hand flies as the planned one does."""

from __future__ import annotations

from pathlib import Path

from lockstep import Lockstep

from companion.mission.loader import load_mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"


def test_it_visits_the_places_of_the_planned_mission_in_the_same_order() -> None:
    visits = []
    for name in ("surveillance", "by_hand"):
        flight = Lockstep(
            load_mission(MISSIONS / f"{name}.yaml"),
            read_scenario(MISSIONS / f"{name}.sim.yaml"),
            seed=1,
        ).until_the_end()
        assert flight.exit_code == 0
        assert flight.simulation.collisions == 0
        visits.append(flight.places)
    assert visits[0] == visits[1]
