"""Flights whose position is not exact: a GPS that wanders, and a PX4's own drag and wander.

The vehicle needs 45 cm around its centre: 35 of its own, and the 10 that are to stay free.
"""

from __future__ import annotations

from math import hypot, inf

import numpy as np
import pytest
from lockstep import SETPOINT, Lockstep
from scipy import ndimage
from shipped import MISSIONS

from companion.flight_events.skills import ClearanceChanged, PlaceReached, SkillFailed
from companion.flight_events.sortie import (
    Phase,
    PhaseEntered,
    SetpointRefused,
    VehicleCrashed,
)
from companion.mission.loader import load_mission
from companion.tick import TICK_S
from sitl.world.scenario import read_scenario

NEEDED_M = 0.45
FLOWN_S, ARRIVED_S = 30.0, 10.0
WANDER = "airframe: px4_sih\nwander: {}\n"
WANDER_OF_30_CM = "airframe: px4_sih\nwander: {position_m: 0.3}\n"
GPS = "  - {at_s: 0.1, gps: {noise_m: 0.25}}\n"


class FlightInError(Lockstep):
    """The first part of a shipped mission whose vehicle is not where it is taken to be.

    Attributes:
        least_m: the least true distance to a wall.
        phantoms: the most cells that were taken for occupied, half a metre from all that truly was.
        waits_s: how long each flight waited at its end until the vehicle was there.
    """

    def __init__(
        self, name: str, seed: int, differs: str = "", event: str = "", flown_s: float = FLOWN_S
    ) -> None:
        self.least_m, self.phantoms = inf, 0
        self.waits_s: list[float] = []
        text = (MISSIONS / f"{name}.sim.yaml").read_text(encoding="utf-8")
        text = text.replace("map: maps/", f"map: {MISSIONS}/maps/") + differs
        if event:
            head, _, rest = text.partition("happens:\n")
            text = f"{head}\nhappens:\n{event}{rest}"
        mission = load_mission(MISSIONS / f"{name}.yaml")
        super().__init__(mission, read_scenario(text), seed=seed)
        self.until_reported(PhaseEntered, phase=Phase.TASK)
        told, still_s, reached = mission.grid.occupied, 0.0, 0
        for _ in range(round(flown_s / TICK_S)):
            self.tick()
            if self.companion.has_ended:
                break
            if (now := len(self.of(PlaceReached))) > reached:
                self.waits_s.append(still_s)
                reached = now
            setpoint = next(
                s.message for s in reversed(self.said) if s.message.get_type() == SETPOINT
            )
            still_s = still_s + TICK_S if hypot(setpoint.vx, setpoint.vy) < 0.01 else 0.0
            true_map, run = self.simulation.true_map, self.companion._run
            assert true_map is not None and run is not None
            north, east, _ = self.simulation.flight.position
            self.least_m = min(self.least_m, true_map.clearance_m((north, east)))
            raised = run._surroundings.grid.occupied & ~told
            if raised.any():
                away = ndimage.distance_transform_edt(~true_map.occupied, sampling=true_map.cell_m)
                self.phantoms = max(self.phantoms, int(np.count_nonzero(away[raised] > 0.5)))

    @property
    def failed_moves(self) -> list[SkillFailed]:
        """Flights that did not reach their place."""
        return [event for event in self.of(SkillFailed) if event.action.startswith("move(")]


@pytest.mark.parametrize(
    "name", ["surveillance", pytest.param("inspection", marks=pytest.mark.long)]
)
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_with_noise_of_gps_it_keeps_away_from_walls_and_sees_no_others(
    name: str, seed: int
) -> None:
    flight = FlightInError(name, seed, event=GPS)
    assert flight.of(ClearanceChanged)
    assert not flight.of(SetpointRefused)
    assert flight.phantoms == 0
    assert flight.least_m >= NEEDED_M
    assert not flight.of(VehicleCrashed)


@pytest.mark.long
@pytest.mark.parametrize("name", ["surveillance", "hall_of_20"])
@pytest.mark.parametrize("seed", [0, 1])
def test_with_the_drag_and_the_wander_of_a_px4_it_keeps_off_the_walls(name: str, seed: int) -> None:
    flight = FlightInError(name, seed, differs=WANDER)
    assert flight.phantoms == 0
    assert flight.least_m >= NEEDED_M
    assert not flight.of(VehicleCrashed) and not flight.failed_moves
    assert len(flight.waits_s) >= 2 and max(flight.waits_s) <= ARRIVED_S


@pytest.mark.long
def test_of_a_hundred_arrivals_with_a_wander_of_30_cm_99_take_10_s_at_most() -> None:
    waits_s: list[float] = []
    for seed in range(12):
        name = ("surveillance", "hall_of_20")[seed % 2]
        flight = FlightInError(name, seed, differs=WANDER_OF_30_CM, flown_s=90.0)
        assert not flight.failed_moves and not flight.of(VehicleCrashed)
        waits_s += flight.waits_s
    assert len(waits_s) >= 100
    assert sum(wait_s <= ARRIVED_S for wait_s in waits_s) >= 0.99 * len(waits_s)
