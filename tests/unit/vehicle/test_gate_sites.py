"""The gate where the mission lands on markers: a way down is open over a site, and only so far."""

from __future__ import annotations

from dataclasses import replace

import at_the_gate
import pytest
from at_the_gate import NOW_S, heard
from states import changed, heard_at

from companion.outcomes import Refusal
from companion.vehicle.gate import LandingSite, Request, admit
from companion.vehicle.ports.setpoints import Setpoint, hold_at

ENVELOPE = replace(
    at_the_gate.ENVELOPE,
    fence=((0.0, 0.0), (0.0, 20.0), (10.0, 20.0), (10.0, 0.0)),
    fence_margin_m=0.0,
)
STATE = heard_at(NOW_S, heard(position=(5.0, 15.0, -2.0), velocity=(0.0, 0.0, 0.0)))
GROUND = LandingSite((5.0, 15.0), 2.0, -0.5)
ROOF = LandingSite((5.0, 15.0), 2.0, 2.5)
OUT_OF_BAND = Refusal("outside the altitude band")


def refusal(
    site: LandingSite,
    up_m: float,
    *,
    is_landing: bool = True,
    east_m: float = 15.0,
    vehicle_up_m: float | None = None,
) -> Refusal | None:
    position = (5.0, east_m, -up_m)
    here_m = up_m + 0.25 if vehicle_up_m is None else vehicle_up_m
    state = changed(STATE, position=(5.0, east_m, -here_m))
    setpoint = Setpoint(position, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5)
    verdict = admit(
        Request(setpoint, NOW_S, is_landing=is_landing),
        state,
        NOW_S,
        replace(ENVELOPE, sites=(site,)),
    )
    if verdict.refusal is not None:
        assert verdict.setpoint == hold_at(state.motion.position, state.attitude.yaw_rad)
    return verdict.refusal


@pytest.mark.parametrize(
    ("up_m", "is_open"), [(0.5, True), (0.0, True), (-0.5, True), (-0.51, False)]
)
def test_over_a_site_a_landing_leads_below_the_band(up_m: float, is_open: bool) -> None:
    assert refusal(GROUND, up_m) == (None if is_open else OUT_OF_BAND)


def test_what_is_no_landing_stays_in_the_band() -> None:
    assert refusal(GROUND, 0.25, is_landing=False) == OUT_OF_BAND


def test_nothing_is_a_landing_unless_that_is_said() -> None:
    low = Setpoint((5.0, 15.0, -0.25), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5)
    envelope = replace(ENVELOPE, sites=(GROUND,))
    assert admit(Request(low, NOW_S), STATE, NOW_S, envelope).refusal == OUT_OF_BAND


@pytest.mark.parametrize(("east_m", "is_open"), [(17.0, True), (17.01, False), (12.99, False)])
def test_beside_a_site_the_band_ends_where_it_did(east_m: float, is_open: bool) -> None:
    assert refusal(GROUND, 0.25, east_m=east_m) == (None if is_open else OUT_OF_BAND)


@pytest.mark.parametrize(("up_m", "is_open"), [(2.5, True), (2.49, False), (1.0, False)])
def test_over_a_roof_a_landing_leads_no_lower_than_the_roof(up_m: float, is_open: bool) -> None:
    assert refusal(ROOF, up_m) == (None if is_open else OUT_OF_BAND)


def test_the_upper_end_of_the_band_is_that_of_a_landing_too() -> None:
    assert refusal(ROOF, 4.01, vehicle_up_m=4.0) == OUT_OF_BAND


@pytest.mark.parametrize(("up_m", "is_open"), [(0.3, True), (0.25, True), (0.24, False)])
def test_a_vehicle_below_the_band_may_be_sent_up_and_no_lower(up_m: float, is_open: bool) -> None:
    """It was on its way down to a marker when something interrupted that."""
    found = refusal(ROOF, up_m, is_landing=False, vehicle_up_m=0.25)
    assert found == (None if is_open else OUT_OF_BAND)
