"""How far a mission reaches from where its vehicle is armed, against the autopilot's own fence."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from fakes import FakeVehicle
from synthetic import FENCE

from companion.acting.preflight.failsafe_check import FailsafeCheck
from companion.geometry import NorthEast
from companion.vehicle.port import Failed, Progress


@pytest.fixture
def flight() -> Any:
    limits = SimpleNamespace(fence=FENCE, up_m=(1.0, 4.0))
    reports: list[Any] = []
    return SimpleNamespace(
        vehicle=FakeVehicle(), now_s=0.0, limits=limits, report=reports.append, reports=reports
    )


@pytest.mark.parametrize(
    ("stands", "homes", "least_m"),
    [
        ((0.0, 0.0), (), 10.61),  # to (7.5, 7.5)
        ((3.0, 3.0), (), 6.37),
        ((0.0, 0.0), ((7.5, 7.5),), 12.73),
        ((3.0, 3.0), ((3.0, 3.0), (0.0, 3.0)), 8.746),
    ],
)
def test_it_reaches_to_the_furthest_corner_from_wherever_it_is_armed(
    stands: NorthEast, homes: tuple[NorthEast, ...], least_m: float, flight: Any
) -> None:
    flight.vehicle.change(position=(*stands, 0.0))
    flight.vehicle.parameters["GF_MAX_HOR_DIST"] = least_m - 0.01
    refused = FailsafeCheck(flight, accepts_weak=False, homes=homes).tick()
    assert isinstance(refused, Failed) and f"up to {least_m:.1f} m away" in refused.reason
    flight.vehicle.parameters["GF_MAX_HOR_DIST"] = least_m + 0.01
    assert FailsafeCheck(flight, accepts_weak=False, homes=homes).tick() is Progress.DONE


def test_it_is_told_where_the_operator_accepts_it(flight: Any) -> None:
    flight.vehicle.parameters["GF_MAX_VER_DIST"] = 4.0
    assert FailsafeCheck(flight, accepts_weak=True).tick() is Progress.DONE
    assert "GF_MAX_VER_DIST is 4" in flight.reports[0].text
