"""How far a mission reaches from where its vehicle is armed, against the autopilot's own fence."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from fakes import FakeVehicle
from synthetic import FENCE

from companion.acting.sortie.preflight.failsafe_check import FailsafeCheck
from companion.geometry import Ned, NorthEast
from companion.outcomes import Failed, Progress


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
        ((0.0, 0.0), ((7.5, 7.5, 0.0),), 12.73),
        ((3.0, 3.0), ((3.0, 3.0, 0.0), (0.0, 3.0, -1.0)), 8.746),
    ],
)
def test_it_reaches_to_the_furthest_corner_from_wherever_it_is_armed(
    stands: NorthEast, homes: tuple[Ned, ...], least_m: float, flight: Any
) -> None:
    flight.vehicle.change(position=(*stands, 0.0))
    flight.vehicle.parameters["GF_MAX_HOR_DIST"] = least_m - 0.01
    refused = FailsafeCheck(flight, accepts_weak=False, homes=homes).tick()
    assert isinstance(refused, Failed) and f"up to {least_m:.1f} m away" in refused.reason
    flight.vehicle.parameters["GF_MAX_HOR_DIST"] = least_m + 0.01
    assert FailsafeCheck(flight, accepts_weak=False, homes=homes).tick() is Progress.DONE


@pytest.mark.parametrize("parameter", ["MIS_TAKEOFF_ALT", "RTL_RETURN_ALT"])
def test_what_climbs_from_a_roof_stays_below_the_ceiling_from_there(
    parameter: str, flight: Any
) -> None:
    flight.vehicle.parameters |= {"GF_ACTION": 3.0, "RTL_RETURN_ALT": 0.0, parameter: 2.6}
    homes = ((3.0, 3.0, -1.5), (0.0, 3.0, 0.0))
    refused = FailsafeCheck(flight, accepts_weak=False, homes=homes).tick()
    assert isinstance(refused, Failed)
    assert f"{parameter} is 2.6; set 2.5 or less" in refused.reason
    assert "so high first, also from a roof of 1.5 m" in refused.reason or (
        "so high at least, also from a roof of 1.5 m" in refused.reason
    )
    flight.vehicle.parameters[parameter] = 2.5
    assert FailsafeCheck(flight, accepts_weak=False, homes=homes).tick() is Progress.DONE


def test_it_is_told_where_the_operator_accepts_it(flight: Any) -> None:
    flight.vehicle.parameters["GF_MAX_VER_DIST"] = 4.0
    assert FailsafeCheck(flight, accepts_weak=True).tick() is Progress.DONE
    assert "GF_MAX_VER_DIST is 4" in flight.reports[0].text
