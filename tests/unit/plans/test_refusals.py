"""What a refusal names: the item that is wrong, its true reason, and what to do about it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from plan_files import HOME, RETURN, TAKE_OFF, at, imported, item, plan, polygon, square, waypoint

from companion import load_mission
from companion.errors import MissionError
from companion.plans.draft_places import Given

WAY = (TAKE_OFF, waypoint(30, 0), waypoint(30, 40), RETURN)
LOOK = item(195, 0, 0, 0, 0, *at(50, 0), 10.0)
UP = Given(up_m=20.0)
CAMERA = Given(payload=100)


def refusal(
    folder: Path, content: Any, given: Given = CAMERA, *leave_out: str, name: str = "field.plan"
) -> str:
    with pytest.raises(MissionError) as error:
        imported(folder, content, name, given, *leave_out)
    return str(error.value).removeprefix(f"{folder}/{name}: ")


# -- what goes to a payload ------------------------------------------------------------------------


def test_a_position_goes_to_a_payload_with_its_altitude_above_the_sea(tmp_path: Path) -> None:
    for frame, altitude_m in ((3, 10.0), (0, 498.0)):
        look = LOOK | {"frame": frame}
        look["params"] = [*LOOK["params"][:6], altitude_m]
        text, draft = imported(tmp_path, plan(*WAY[:2], look, RETURN), "field.plan", CAMERA)
        assert load_mission(text)
        assert "MAV_CMD_DO_SET_ROI_LOCATION, 0, 0, 0, 0, 47.3981" in text and ", 498)" in text
        told = "item 3: 10 m above home is sent as 498 m above the sea"
        assert (told in draft.notes) == (frame == 3)


@pytest.mark.parametrize("amsl_m", [None, 0])
def test_where_nothing_says_how_high_home_lies_it_is_asked(
    amsl_m: float | None, tmp_path: Path
) -> None:
    """Ground stations write 0 where they do not know the terrain."""
    unknown = plan(*WAY[:2], LOOK, RETURN, plannedHomePosition=[*HOME, amsl_m])
    said = refusal(tmp_path, unknown)
    assert said.startswith("item 3: MAV_CMD_DO_SET_ROI_LOCATION goes to a payload with an altitude")
    assert "--home LAT,LON,AMSL" in said
    known = Given(home=HOME, home_amsl_m=500.0, payload=100)
    assert ", 510)" in imported(tmp_path, unknown, "field.plan", known)[0]


def test_an_altitude_above_the_terrain_goes_to_no_payload(tmp_path: Path) -> None:
    said = refusal(tmp_path, plan(*WAY[:2], LOOK | {"frame": 10}))
    assert said.startswith("item 3: its altitude is above the terrain")


def test_only_commands_with_a_position_have_an_altitude(tmp_path: Path) -> None:
    shoot = item(203, 0, 0, 0, 0, 1, frame=2)  # the fifth parameter of DO_DIGICAM_CONTROL
    text, _ = imported(tmp_path, plan(*WAY[:2], shoot, RETURN), "field.plan", CAMERA)
    assert "MAV_CMD_DO_DIGICAM_CONTROL, 0, 0, 0, 0, 1)" in text


# -- speeds ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [2, 3])
def test_speeds_of_climbs_and_descents_are_none_of_flights(kind: int, tmp_path: Path) -> None:
    slow, fast = item(178, kind, 0.7, frame=2), item(178, 1, 4.0, frame=2)
    text, draft = imported(tmp_path, plan(TAKE_OFF, slow, fast, *WAY[1:]))
    assert load_mission(text).limits.speed_mps == 4.0
    assert "item 2: a speed of climbs or descents; left out" in draft.notes


# -- leaving out -----------------------------------------------------------------------------------


def test_what_shall_be_left_out_is_there(tmp_path: Path) -> None:
    for number in ("9", "2.1", "x"):
        said = refusal(tmp_path, plan(*WAY), CAMERA, number, "3")
        assert said.startswith(f"has no item '{number}' that could be left out")
    assert list(load_mission(imported(tmp_path, plan(*WAY), "a.plan", CAMERA, "3")[0]).places) == [
        "Home",
        "W2",
    ]


def test_of_a_survey_all_or_a_point_is_left_out(tmp_path: Path) -> None:
    points = [waypoint(30, 0), waypoint(30, 40), waypoint(40, 40)]
    survey = {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "version": 5,
        "TransectStyleComplexItem": {"Items": points},
    }
    for left_out, names in (("2.2", ["W2_1", "W2_3", "W3"]), ("2", ["W3"])):
        drawn = plan(TAKE_OFF, survey, waypoint(0, 20), RETURN)
        text, _ = imported(tmp_path, drawn, "a.plan", CAMERA, left_out)
        assert list(load_mission(text).places)[1:] == names


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("map.geojson", '{"type": "Point", "coordinates": [8.5, 47.4]}'),
        ("fence.txt", "47.4 8.5\n47.41 8.51\n47.41 8.49\n47.39 8.5\n"),
        ("map.kml", "<kml><Placemark/></kml>"),
    ],
)
def test_a_drawn_map_has_no_numbers_to_leave_out(name: str, content: str, tmp_path: Path) -> None:
    said = refusal(tmp_path, content, UP, "2", name=name)
    assert said.startswith("has no items with numbers, so that '2' cannot be left out")


# -- one reason each -------------------------------------------------------------------------------


def test_what_follows_a_refused_item_is_not_refused_for_it(tmp_path: Path) -> None:
    terrain = waypoint(30, 0) | {"frame": 10}
    landing, jump = item(21, 0, 0, 0, 0, *at(9, 9), 0), item(177, 1, -1, frame=2)
    for last in (landing, jump):
        said = refusal(tmp_path, plan(terrain, last))
        assert said.startswith("item 1: its altitude is above the terrain")


def test_a_height_is_refused_by_the_item_that_says_it(tmp_path: Path) -> None:
    low = waypoint(0, 0, 16.0) | {"frame": 0}
    assert refusal(tmp_path, plan(low, *WAY[1:])).startswith(
        "item 1: is at 16 m above the sea, and"
    )
    take_off = item(22, 0, 0, 0, None, 0, 0, 0.2)
    assert refusal(tmp_path, plan(take_off, *WAY[1:])).startswith("item 1: is at 0.2 m above home")


def test_all_heights_that_are_none_are_told_at_once(tmp_path: Path) -> None:
    sunk = [waypoint(30, east_m, 16.0) | {"frame": 0} for east_m in (0, 40)]
    said = refusal(tmp_path, plan(*sunk, waypoint(0, 40, 0.0), RETURN))
    assert [f"item {i}: is at" in said for i in (1, 2, 3)] == [True] * 3
    assert "--leave-out 3,7,\n" in said and "say how high home lies: --home LAT,LON,AMSL" in said


def test_a_landing_is_not_refused_for_the_waypoint_before_it(tmp_path: Path) -> None:
    landing = item(21, 0, 0, 0, None, *at(9, 9), 0)
    said = refusal(tmp_path, plan(TAKE_OFF, waypoint(30, 0, 0.0), landing))
    assert said.startswith("item 2: is at 0 m above home")
    text, _ = imported(tmp_path, plan(TAKE_OFF, waypoint(30, 0, 0.0), landing), "a.plan", UP, "2")
    assert list(load_mission(text).places) == ["Home", "W3"]


def test_of_a_drawn_map_nothing_is_told_to_be_left_out_by_number(tmp_path: Path) -> None:
    low = {"type": "Feature", "properties": {"up_m": 0.2}}
    low["geometry"] = {"type": "Point", "coordinates": [HOME[1], HOME[0]]}
    line = {"type": "LineString", "coordinates": [[HOME[1], HOME[0]]] * 2}
    both = {"type": "FeatureCollection", "features": [low, {"type": "Feature", "geometry": line}]}
    said = refusal(tmp_path, both, UP, name="map.geojson")
    assert said.startswith("feature 1: is at 0.2 m above home")
    assert "correct it in the program" in said and "--leave-out" not in said


def test_home_in_a_wrong_place_may_be_elsewhere(tmp_path: Path) -> None:
    beside = refusal(tmp_path, plan(polygons=[polygon(square(40, north_m=90))]), UP)
    zone = polygon(square(40, north_m=20), inclusion=False)
    within = refusal(tmp_path, plan(polygons=[polygon(square(90)), zone]), UP)
    edge = polygon(square(40, north_m=40.1), inclusion=False)
    near = refusal(tmp_path, plan(polygons=[polygon(square(90)), edge]), UP)
    assert beside.startswith("home: is outside the fence of the plan")
    assert within.startswith("home: is inside the exclusion area polygon_2")
    assert near.startswith("home: place Home is only 0.10 m from the keep-out zone polygon_2")
    assert all(
        "or say where the mission begins: --home LAT,LON" in s for s in (beside, within, near)
    )


def test_areas_are_refused_by_their_name_in_the_file(tmp_path: Path) -> None:
    crossed = [*square(90), at(-95, -80)]
    said = refusal(tmp_path, plan(*WAY, polygons=[polygon(crossed)]))
    assert said.startswith("fence polygon 1: ")
    zones = [
        polygon(square(90)),
        polygon([at(n - 60, e - 60) for n, e in ((0, 0), (9, 9), (9, 0), (0, 9))], False),
    ]
    assert refusal(tmp_path, plan(*WAY, polygons=zones)).startswith("fence polygon 2: ")


def test_a_polygon_without_an_area_is_refused(tmp_path: Path) -> None:
    for corners in ([at(9, 9)] * 4, [at(0, 0), at(20, 20), at(40, 40)]):
        said = refusal(tmp_path, plan(*WAY, polygons=[polygon(corners)]))
        assert said.startswith("fence polygon 1: has no area: its corners lie on one line")


# -- surveys ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "version"), [("StructureScan", 3), ("survey", 9), ("survey", 5)])
def test_what_no_survey_can_be_is_left_out_by_its_number(
    kind: str, version: int, tmp_path: Path
) -> None:
    scan = {"type": "ComplexItem", "complexItemType": kind, "version": version}
    scan["TransectStyleComplexItem"] = {}
    said = refusal(tmp_path, plan(*WAY[:2], scan, RETURN))
    assert said.startswith(f"item 3: {kind} ") and said.endswith("leave it out: --leave-out 3")


@pytest.mark.parametrize(
    ("style", "camera", "is_above_home"),
    [
        ({}, {"DistanceMode": 1}, True),
        ({}, {"DistanceMode": 2}, False),
        ({}, {"DistanceMode": 4}, False),
        ({"FollowTerrain": False}, {"DistanceToSurfaceRelative": True}, True),
        ({"FollowTerrain": True}, {"DistanceToSurfaceRelative": True}, False),
        ({}, {"DistanceToSurfaceRelative": False}, False),
    ],
)
def test_a_survey_that_is_only_drawn_is_above_home_or_refused(
    style: dict[str, Any], camera: dict[str, Any], is_above_home: bool, tmp_path: Path
) -> None:
    drawn = {
        "VisualTransectPoints": [at(30, 0), at(30, 40)],
        "CameraCalc": camera | {"DistanceToSurface": 35},
    }
    survey = {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "version": 5,
        "TransectStyleComplexItem": drawn | style,
    }
    if is_above_home:
        mission = load_mission(imported(tmp_path, plan(TAKE_OFF, survey, RETURN))[0])
        assert mission.places["W2_2"].position == pytest.approx((30, 40, -35), abs=0.001)
    else:
        said = refusal(tmp_path, plan(TAKE_OFF, survey))
        assert said.startswith("item 2: survey has no altitude above home")
