"""Docks that may be missed are warned of, where a position is not exact."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from fakes import FakeVehicle
from shipped import MISSIONS

from companion.acting.sortie.preflight.dock_check import DockCheck, needs_docks
from companion.flight_events.landing import DockMayBeMissed
from companion.mission.loader import load_mission
from companion.outcomes import Progress


@pytest.mark.parametrize(("accuracy_m", "beside_m"), [(0.1, None), (0.29, 1.2), (3.0, 1.8)])
def test_how_far_beside_it_may_land(accuracy_m: float, beside_m: float | None) -> None:
    told: list[Any] = []
    vehicle = FakeVehicle()
    vehicle.change(accuracy_m=accuracy_m)
    flight: Any = SimpleNamespace(vehicle=vehicle, report=told.append)
    assert DockCheck(flight).tick() is Progress.DONE
    assert told == ([] if beside_m is None else [DockMayBeMissed(beside_m)])


@pytest.mark.parametrize(
    ("name", "are_needed"),
    [
        ("persistent_patrol", True),
        ("endless_patrol", True),
        ("rooftop", False),
        ("corridor", False),
    ],
)
def test_which_missions_need_docks(name: str, are_needed: bool) -> None:
    assert needs_docks(load_mission(MISSIONS / f"{name}.yaml")) is are_needed
