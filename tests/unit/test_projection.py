"""Latitude and longitude become metres as in PX4; PROJ is the authority (tests/data/aeqd.tsv)."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import GlobalOrigin

TABLE = Path(__file__).parents[1] / "data" / "aeqd.tsv"
latitudes, longitudes = st.floats(-85, 85), st.floats(-180, 180)
metres = st.floats(-10_000, 10_000)


def rows() -> list[dict[str, float]]:
    lines = [line for line in TABLE.read_text().splitlines() if not line.startswith("#")]
    return [
        {key: float(value) for key, value in row.items()}
        for row in csv.DictReader(lines, delimiter="\t")
    ]


def test_points_are_where_proj_has_them() -> None:
    table = rows()
    assert len(table) == 96
    for row in table:
        origin = GlobalOrigin(row["lat_0"], row["lon_0"], 0.0)
        north, east, _ = origin.to_local(row["lat"], row["lon"], 0.0)
        assert (north, east) == pytest.approx((row["north"], row["east"]), abs=1e-5)


@given(latitudes, longitudes, metres, metres, st.floats(-100, 100))
def test_there_and_back_is_the_same_point(
    latitude: float, longitude: float, north: float, east: float, down: float
) -> None:
    origin = GlobalOrigin(latitude, longitude, 488.0)
    back = origin.to_local(*origin.to_global((north, east, down)))
    assert back == pytest.approx((north, east, down), abs=1e-3)


@given(latitudes, longitudes, metres, metres)
def test_a_longitude_lies_on_the_earth_also_across_the_180th_meridian(
    latitude: float, longitude: float, north: float, east: float
) -> None:
    assert abs(GlobalOrigin(latitude, longitude, 0.0).to_global((north, east, 0.0))[1]) <= 180


def test_the_place_east_of_the_180th_meridian_is_in_the_west() -> None:
    origin = GlobalOrigin(-16.8, 179.9999, 0.0)
    longitude = origin.to_global((0.0, 100.0, 0.0))[1]
    assert longitude == pytest.approx(-179.99916, abs=1e-4)
    assert origin.to_local(-16.8, longitude, 0.0)[:2] == pytest.approx((0.0, 100.0), abs=1e-3)
