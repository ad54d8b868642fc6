"""What was seen from the vehicle lies where the vehicle was at the picture's time."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from fakes import FakeVehicle
from states import changed

from companion.flight_events.reports import ReportRefused
from companion.geometry import GlobalOrigin
from companion.mission.signals import REPORT, Signal
from companion.outcomes import Refusal
from companion.vehicle.detections import Detections
from companion.vehicle.ports.state import VehicleState
from companion.vehicle.sightings import (
    FAR_M,
    HISTORY_S,
    SeenFromVehicle,
    SeenOnEarth,
    Sightings,
    sighting_of,
)

PERSON, COUNT = Signal(REPORT, "person", ""), Signal(REPORT, "count", "")
ZERO = GlobalOrigin(47.397742, 8.545594, 488.0)


def state_at(time_s: float) -> VehicleState:
    """It flies north at 2 m/s, and turns to the right at 0.1 rad/s."""
    state = FakeVehicle((0.0, 0.0, -5.0)).take_off(5.0).state
    assert state is not None
    position, yaw_rad = (2.0 * time_s, 1.0, -5.0), 0.1 * time_s
    return changed(
        state,
        position=position,
        yaw_rad=yaw_rad,
        motion_measured_s=time_s,
        attitude_measured_s=time_s,
    )


@pytest.fixture
def sightings() -> Sightings:
    """After 20 s."""
    sightings = Sightings()
    for tick in range(401):
        sightings.follow(state_at(tick * 0.05))
    return sightings


@pytest.mark.parametrize("seen_s", [11.0, 15.0, 19.975, 20.0])
@pytest.mark.parametrize("zero_s", [None, 5000.0])
def test_a_picture_is_put_where_the_vehicle_was(
    sightings: Sightings, seen_s: float, zero_s: float | None
) -> None:
    seen = SeenFromVehicle(4.0, -1.5, (seen_s + (zero_s or 0.0)) * 1e9)
    at = sightings.locate(seen, 20.0, zero_s, None)
    yaw, north = 0.1 * seen_s, 2.0 * seen_s
    expected = (
        north + 4.0 * math.cos(yaw) + 1.5 * math.sin(yaw),
        1.0 + 4.0 * math.sin(yaw) - 1.5 * math.cos(yaw),
    )
    assert at == pytest.approx(expected, abs=1e-5)


def test_without_a_time_it_was_seen_now(sightings: Sightings) -> None:
    at = sightings.locate(SeenFromVehicle(0.0, 0.0, None), 20.0, None, None)
    assert at == pytest.approx((40.0, 1.0))


@pytest.mark.parametrize(
    ("seen", "why"),
    [
        (SeenFromVehicle(1.0, 0.0, 22e9), "its time is 2.0 s ahead"),
        (SeenFromVehicle(1.0, 0.0, (20 - HISTORY_S - 1) * 1e9), "it is 11.0 s old"),
        (SeenFromVehicle(1.0, 0.0, 1.7e18), "ahead: monotonic_ns is CLOCK_MONOTONIC"),
        (SeenFromVehicle(FAR_M, 1.0, None), "more than 200 m from the vehicle"),
        (SeenOnEarth(47.0, 8.0), "has not said where on the earth it is"),
    ],
)
def test_what_cannot_be_put_anywhere_is_refused(sightings: Sightings, seen: Any, why: str) -> None:
    refused = sightings.locate(seen, 20.0, None, None)
    assert isinstance(refused, Refusal) and why in refused.reason


def test_while_the_position_is_in_doubt_nothing_is_put_anywhere(sightings: Sightings) -> None:
    sightings.follow(None)
    refused = sightings.locate(SeenFromVehicle(1.0, 0.0, None), 22.0, None, None)
    assert refused == Refusal("where the vehicle is, is not known")


def test_a_latitude_and_longitude_are_those_of_the_earth(sightings: Sightings) -> None:
    latitude, longitude, _ = ZERO.to_global((30.0, -12.0, 0.0))
    at = sightings.locate(SeenOnEarth(latitude, longitude), 20.0, None, ZERO)
    assert at == pytest.approx((30.0, -12.0), abs=1e-3)
    assert isinstance(sightings.locate(SeenOnEarth(91.0, 0.0), 20.0, None, ZERO), Refusal)


def test_a_heading_that_passes_south_is_between_its_neighbours() -> None:
    sightings = Sightings()
    for time_s, yaw_rad in ((0.0, math.pi - 0.1), (1.0, -math.pi + 0.1)):
        sightings.follow(changed(state_at(time_s), yaw_rad=yaw_rad, position=(0, 0, -5)))
    at = sightings.locate(SeenFromVehicle(1.0, 0.0, 0.5e9), 1.0, None, None)
    assert at == pytest.approx((-1.0, 0.0), abs=1e-9)


# -- reports ---------------------------------------------------------------------------------------


def read(report: object) -> tuple[Detections, dict[str, Any]]:
    detections = Detections([PERSON, COUNT], placed={"person"})
    readings = detections.read([json.dumps({"person": report, "count": 2}).encode()])
    assert [reading for reading in readings if reading != (PERSON, 0.0)] == [(COUNT, 2.0)]
    return detections, detections.take_sightings()


def test_a_position_is_a_sighting_and_taken_once() -> None:
    detections, seen = read({"forward_m": 3, "right_m": 1.5, "monotonic_ns": 7})
    assert seen == {"person": SeenFromVehicle(3.0, 1.5, 7.0)}
    assert detections.take_sightings() == {} and detections.news() == []


@pytest.mark.parametrize("nothing", [0, False, 0.0])
def test_nothing_seen_is_no_mistake(nothing: object) -> None:
    detections, seen = read(nothing)
    assert seen == {} and detections.news() == []


@pytest.mark.parametrize(
    ("report", "why"),
    [
        (1, "person: it finds a place, and needs a position"),
        ([1, 2], "person: it finds a place, and needs a position"),
        ({}, "person: a position is forward_m"),
        ({"forward_m": 1}, "person: a position is forward_m"),
        ({"forward_m": 1, "right_m": 1, "up": 1}, "person: a position is forward_m"),
        ({"lat_deg": 1, "lon_deg": 1, "monotonic_ns": 1}, "person: a position is"),
        ({"forward_m": "1", "right_m": 1}, "person: forward_m is not a number"),
        ({"forward_m": True, "right_m": 1}, "person: forward_m is not a number"),
        ({"forward_m": float("nan"), "right_m": 1}, "person: forward_m is not a number"),
        ({"forward_m": 10**400, "right_m": 1}, "person: forward_m is not a number"),
    ],
)
def test_what_is_no_position_is_refused(report: object, why: str) -> None:
    detections, seen = read(report)
    (news,) = detections.news()
    assert seen == {} and isinstance(news, ReportRefused) and why in news.text


def test_a_number_that_is_asked_for_may_not_be_a_position() -> None:
    detections = Detections([COUNT], placed={"person"})
    assert detections.read([b'{"count": {"forward_m": 1, "right_m": 1}}']) == []
    assert sighting_of({"forward_m": 1, "right_m": 1}) == SeenFromVehicle(1.0, 1.0, None)
    assert "neither a number nor a truth value" in detections.news()[0].text
