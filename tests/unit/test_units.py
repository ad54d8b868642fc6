"""Units as people write them: what is written in a key's own unit instead."""

from __future__ import annotations

import pytest

from companion.documents.numbers import number_meant
from companion.documents.units import unit_of_key


@pytest.mark.parametrize(
    ("key", "text", "meant"),
    [
        ("speed_mps", "30 km/h", "write metres per second: 8.33."),
        ("speed_mps", "10 kn", "write metres per second: 5.14."),
        ("speed_mps", "10 MPH", "write metres per second: 4.47."),
        ("speed_mps", "5 m/s", "write the number alone: 5."),
        ("speed_mps", "5 furlongs", "write a number of metres per second."),
        ("acceleration_mps2", "0.5 g", "write metres per second squared: 4.9."),
        ("acceleration_mps2", "2 m/s²", "write the number alone: 2."),
        ("up_m", "12 ft", "write metres: 3.66."),
        ("up_m", "1500 ft", "write metres: 457.2."),
        ("cell_m", "25cm", "write metres: 0.25."),
        ("patience_s", "5 min", "write seconds: 300."),
        ("patience_s", "1.5 h", "write seconds: 5400."),
        ("timeout_s", "500 ms", "write seconds: 0.5."),
        ("timeout_s", "5 m", "write a number of seconds."),
        ("heading_deg", "1.57 rad", "write degrees: 90."),
        ("lat_deg", "0.82724 rad", "write degrees: 47.397."),
        ("lat_deg", "33.45 S", "write the number alone: -33.45."),
        ("lon_deg", "8.5°E", "write the number alone: 8.5."),
        ("capacity_wh", "0.1 kWh", "write watt-hours: 100."),
        ("reserve", "20 %", "write the number alone: 20."),
        ("tries", "3 times", "write the number alone: 3."),
        ("tries", "3 s", "write a number without a unit."),
    ],
)
def test_the_number_is_told_in_the_unit_of_the_key(key: str, text: str, meant: str) -> None:
    assert number_meant(text, (key,)) == meant


def test_a_number_in_a_list_has_the_unit_of_the_list() -> None:
    assert number_meant("15 ft", ("limits", "up_m", 1)) == "write metres: 4.57."


def test_what_varies_has_the_unit_of_its_name() -> None:
    assert number_meant("18 km/h", ("vary", "wind.east_mps", 1)) == "write metres per second: 5."


def test_each_unit_at_the_end_of_a_key_of_the_files_is_known() -> None:
    ends = ("m mps mps2 mps3 s deg dps radps wh w a hz percent").split()
    assert all(unit_of_key(f"key_{end}") for end in ends)
