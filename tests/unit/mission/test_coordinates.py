"""A mission in latitude and longitude means the same as one in metres, or says why it cannot."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from companion.errors import MissionError
from companion.geometry import GlobalOrigin, enu_from_ned
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.places import PointOfInterest

HOME = GlobalOrigin(47.397742, 8.545594, 488.0)
SKILLS: dict[str, Any] = {
    "move": {
        "parameters": {"from": "Place", "to": "Place"},
        "precondition": "at(from)",
        "effect": "at(to) & !at(from)",
        "execute": "fly(to)",
        "look_at": {"east_m": 30, "north_m": -20},
    }
}
IN_METRES: dict[str, Any] = {
    "version": 1,
    "name": "field",
    "map": {"east_m": [-90, 90], "north_m": [-90, 90], "cell_m": 1},
    "limits": {"speed_mps": 5, "up_m": [2, 30], "fence": [[-80, -80], [80, -80], [70, 80]]},
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 5},
        "A": {"east_m": 40, "north_m": -60, "up_m": 12},
    },
    "sets": {"Place": ["Home", "A"]},
    "skills": SKILLS,
    "initially": ["at(Home)"],
    "task": {"patrol": "G (F at(A) & F at(Home))"},
}


def degrees(east_m: float, north_m: float, about: GlobalOrigin = HOME) -> tuple[float, float]:
    return about.to_global((north_m, east_m, 0.0))[:2]


def in_degrees(about: GlobalOrigin = HOME) -> dict[str, Any]:
    """The same mission in latitude and longitude."""
    mission = copy.deepcopy(IN_METRES) | {"frame": "wgs84"}
    fence = mission["limits"]["fence"]
    mission["limits"]["fence"] = [
        list(degrees(east_m, north_m, about)) for east_m, north_m in fence
    ]
    for entry in (*mission["places"].values(), mission["skills"]["move"]["look_at"]):
        latitude, longitude = degrees(entry.pop("east_m"), entry.pop("north_m"), about)
        entry |= {"lat_deg": latitude, "lon_deg": longitude}
    return mission


def with_place(**entry: float) -> dict[str, Any]:
    """The mission in degrees, with an A of its own."""
    mission = in_degrees()
    mission["places"]["A"] = entry
    return mission


def points(mission: Mission) -> list[float]:
    look = mission.skills["move"].look_at
    assert isinstance(look, PointOfInterest)
    corners = [metres for corner in mission.limits.fence for metres in corner]
    places = [metres for place in mission.places.values() for metres in place.position]
    return [*corners, *places, *look.position]


@given(st.floats(-80, 80), st.floats(-180, 180).filter(bool))
@example(47.4, 180.0)
@example(-16.8, -180.0)
@example(-16.8, 179.9999)
def test_degrees_mean_what_metres_mean_anywhere_on_the_earth(lat: float, lon: float) -> None:
    metres = load_mission(IN_METRES)
    there = load_mission(in_degrees(GlobalOrigin(lat, lon, 0.0)))
    assert points(there) == pytest.approx(points(metres), abs=0.01)
    assert metres.anchor is None and there.anchor is not None
    assert (there.anchor.latitude_deg, there.anchor.longitude_deg) == pytest.approx((lat, lon))


def test_metres_are_counted_from_where_the_mission_begins() -> None:
    mission = in_degrees()
    mission["initially"] = ["at(A)"]
    mission["map"] = {"east_m": [-140, 60], "north_m": [-40, 160], "cell_m": 1}
    loaded = load_mission(mission)
    east, north, up = enu_from_ned(loaded.places["Home"].position)
    assert (east, north, up) == pytest.approx((-40, 60, 5), abs=0.01)
    assert loaded.places["A"].position[:2] == (0.0, 0.0)


def test_places_above_the_sea_lie_in_the_middle_until_home_is_known() -> None:
    latitude, longitude = degrees(40, -60)
    entry = {"lat_deg": latitude, "lon_deg": longitude, "amsl_m": 508.0}
    loaded = load_mission(with_place(**entry))
    assert loaded.places["A"].position[2] == pytest.approx(-16.0)
    assert loaded.places["A"].amsl_m == 508.0
    assert loaded.anchor is not None and loaded.anchor.altitude_m == pytest.approx(492.0)


FAR = degrees(0, 123_000)
A = dict(zip(("lat_deg", "lon_deg"), degrees(40, -60), strict=True))
WRONG: list[tuple[dict[str, Any], str, str]] = [
    ({"lat_deg": 0, "lon_deg": 0, "up_m": 5}, "A is at latitude 0, longitude 0", "degrees"),
    ({"lat_deg": 91, "lon_deg": 8, "up_m": 5}, "lat_deg is 91, expected at most 90", "north"),
    ({"lat_deg": 47, "lon_deg": -181, "up_m": 5}, "lon_deg is -181", "Degrees east"),
    ({**A, "up_m": 5, "amsl_m": 500}, "place A has both up_m and amsl_m", "or amsl_m"),
    (A, "place A has no altitude", "write up_m"),
    ({**A, "up_m": 5, "east_m": 3}, "A has east_m, and the frame is wgs84", "lat_deg and lon_deg"),
    ({"east_m": 3, "north_m": 3, "up_m": 5}, "A has east_m, and the frame is wgs84", "lat_deg"),
    ({"lat_deg": 47.4, "up_m": 5}, "the key lon_deg is missing in places.A", "WGS 84"),
    (
        {"lat_deg": FAR[0], "lon_deg": FAR[1], "up_m": 5},
        "place A is 123 km from Home",
        "nothing of a mission lies more than 10 km from Home",
    ),
    (
        {"lat_deg": A["lon_deg"], "lon_deg": A["lat_deg"], "up_m": 5},
        "km from Home",
        "latitude and longitude are exchanged",
    ),
]


@pytest.mark.parametrize(("entry", "what", "hint"), WRONG, ids=[what for _, what, _ in WRONG])
def test_a_place_that_cannot_be_meant_is_refused_where_it_stands(
    entry: dict[str, Any], what: str, hint: str
) -> None:
    with pytest.raises(MissionError) as caught:
        load_mission(with_place(**entry))
    assert what in str(caught.value) and hint in str(caught.value)
    assert "places.A" in str(caught.value)


def refusal(mission: dict[str, Any]) -> str:
    with pytest.raises(MissionError) as caught:
        load_mission(mission)
    return str(caught.value)


def test_degrees_need_the_frame_that_they_are_in() -> None:
    told = refusal(in_degrees() | {"frame": "enu"})
    assert "has lat_deg, and the frame is enu" in told or "limits.fence" in told
    metres = copy.deepcopy(IN_METRES)
    metres["places"]["A"] = {**A, "up_m": 5}
    assert "A has lat_deg, and the frame is enu" in refusal(metres)
    assert "add frame: wgs84 to the mission" in refusal(metres)
    metres["places"]["A"] = {"east_m": 40, "north_m": -60, "amsl_m": 500}
    assert "A has amsl_m, and the frame is enu" in refusal(metres)


def test_corners_in_metres_are_no_degrees() -> None:
    told = refusal(in_degrees() | {"limits": IN_METRES["limits"]})
    assert "km from Home" in told and "limits.fence[0]" in told
    limits = in_degrees()["limits"] | {"fence": [[500, 0], [500, 80], [0, 80]]}
    assert "[500, 0] lies nowhere on the earth" in refusal(in_degrees() | {"limits": limits})


def test_altitudes_that_fit_no_home_are_refused() -> None:
    mission = in_degrees()
    mission["places"]["A"] = {**A, "amsl_m": 560}
    del mission["places"]["Home"]["up_m"]
    mission["places"]["Home"]["amsl_m"] = 500
    assert "do not fit between 2 and 30 m above any home" in refusal(mission)


def test_advice_is_in_the_coordinates_of_the_mission() -> None:
    latitude, longitude = degrees(85, 0)
    told = refusal(with_place(lat_deg=latitude, lon_deg=longitude, up_m=5))
    corner = "[{:.6f}, {:.6f}]".format(*degrees(-80, -80))
    assert "place A is outside the fence" in told and corner in told
