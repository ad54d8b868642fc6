"""What is written for other programs: .plan as it is read again, GeoJSON by its standard."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from drawn import drawn
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from plan_files import HOME, RETURN, TAKE_OFF, imported, item, plan, polygon, square, waypoint

from companion import load_mission
from companion.api.drawings import mission_drawing
from companion.errors import CompanionError
from companion.geometry import GlobalOrigin, horizontal_distance
from companion.plans.drawing import Drawing
from companion.plans.geojson_writing import geojson_text
from companion.plans.qgc_writing import plan_text
from companion.plans.route_plan import metres_between

FENCE = [polygon(square(150)), polygon(square(6, north_m=-40), inclusion=False)]
WAY = (waypoint(30, 0, hold_s=4), waypoint(30, 40, 35.0), waypoint(0, 40))
PLAIN = (waypoint(30, 0), waypoint(30, 40, 35.0), waypoint(0, 40))


def drawing(folder: Path, *items: dict[str, Any], **more: Any) -> Drawing:
    text, _ = imported(folder, plan(*items, **({"polygons": FENCE} | more)))
    return mission_drawing(load_mission(text), None)


def flown_items(text: str) -> list[tuple[int, int, list[float | None]]]:
    return [(i["command"], i["frame"], i["params"]) for i in json.loads(text)["mission"]["items"]]


POINTS = st.lists(
    st.tuples(st.integers(-14, 14), st.integers(2, 14), st.floats(0, 4), st.floats(5, 90)),
    min_size=1,
    max_size=5,
    unique_by=lambda point: point[:2],
)


ON_EARTH = st.tuples(st.floats(0.01, 66), st.floats(-180, 180), st.sampled_from([-1, 1])).map(
    lambda drawn: (drawn[0] * drawn[2], drawn[1])
)
AREA = ((-160, -30), (-160, 160), (160, 160), (160, -30))


@settings(drawn(8), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(drawn=POINTS, home=ON_EARTH)
@example(drawn=[(3, 4, 0.0, 20.0), (-5, 9, 0.0, 30.0)], home=(-16.8, 179.9995))
@example(drawn=[(3, 4, 0.0, 20.0), (-5, 9, 0.0, 30.0)], home=(-16.8, -179.9999))
def test_positions_survive_the_way_to_a_mission_and_back_to_a_centimetre(
    drawn: list[tuple[int, int, float, float]], home: tuple[float, float], tmp_path: Path
) -> None:
    about = GlobalOrigin(*home, 0.0)
    points = [
        (*about.to_global((9 * n + off, 9 * e + off, 0.0))[:2], up_m) for n, e, off, up_m in drawn
    ]
    way = [item(16, 0, 0, 0, None, *point) for point in points]
    fence = [about.to_global((n, e, 0.0))[:2] for n, e in AREA]
    begins = {"plannedHomePosition": [*home, 10]}
    rally = [[*about.to_global((50.0 + 10 * at, -10.0, 0.0))[:2], 0] for at in range(2)]
    content = plan(TAKE_OFF, *way, RETURN, polygons=[polygon(fence)], rally=rally, **begins)
    mission = load_mission(imported(tmp_path, content)[0])
    back = json.loads(plan_text(mission_drawing(mission, None)))
    kept = [entry["params"][4:] for entry in back["mission"]["items"] if entry["command"] == 16]
    assert len(kept) == len(points)
    for point, after in zip(points, kept, strict=True):
        assert metres_between(point[:2], (after[0], after[1])) < 0.01
        assert after[2] == pytest.approx(point[2], abs=0.01)
    corners = back["geoFence"]["polygons"][0]["polygon"]
    assert all(metres_between(a, b) < 0.01 for a, b in zip(fence, corners, strict=True))
    assert metres_between(home, back["mission"]["plannedHomePosition"][:2]) < 0.01
    assert mission.safe_places == ("Home", "R1", "R2")
    for before, point in zip(rally, back["rallyPoints"]["points"], strict=True):
        assert metres_between((before[0], before[1]), point[:2]) < 0.01 and point[2] == 0.0


def test_a_mission_in_degrees_stays_where_it_is_whatever_home_is_said(tmp_path: Path) -> None:
    text, _ = imported(tmp_path, plan(TAKE_OFF, waypoint(30, 0, 520.0) | {"frame": 0}, RETURN))
    mission = load_mission(text)
    drawn = mission_drawing(mission, GlobalOrigin(*HOME, 488.0))
    begins = json.loads(plan_text(drawn))["mission"]["plannedHomePosition"]
    assert begins == pytest.approx([*HOME, 488.0])
    assert drawn.places == mission_drawing(mission, None).places
    again, _ = imported(tmp_path, plan_text(drawn), "again.plan")
    assert load_mission(again).places["W2"].amsl_m == 520.0
    with pytest.raises(CompanionError, match=r"in degrees, and begins \d+ m from the --home"):
        mission_drawing(mission, GlobalOrigin(10.0, 10.0, 488.0))


def test_a_plan_has_takeoff_waypoints_holds_and_return(tmp_path: Path) -> None:
    text = plan_text(drawing(tmp_path, TAKE_OFF, *WAY, RETURN))
    found = flown_items(text)
    assert [(command, frame) for command, frame, _ in found] == [
        (22, 3),
        (16, 3),
        (16, 3),
        (16, 3),
        (20, 2),
    ]
    assert [params[0] for _, _, params in found[1:4]] == [4, 0, 0]
    assert [params[6] for _, _, params in found[1:4]] == pytest.approx([20, 35, 20])
    fence = json.loads(text)["geoFence"]["polygons"]
    assert [area["inclusion"] for area in fence] == [True, False]
    assert json.loads(text)["rallyPoints"]["points"] == []


def test_a_loop_is_a_jump_without_an_end_to_its_first_item(tmp_path: Path) -> None:
    jump = item(177, 3, -1, frame=2)
    text = plan_text(drawing(tmp_path, TAKE_OFF, waypoint(-20, 0), *PLAIN, jump))
    *_, last = json.loads(text)["mission"]["items"]
    assert last["command"] == 177 and last["params"][1] == -1
    looped = [e for e in json.loads(text)["mission"]["items"] if e["doJumpId"] >= last["params"][0]]
    assert len(looped) == 4
    again, _ = imported(tmp_path, text, "again.plan")
    assert "patrolling(" in again


def test_a_mission_that_only_takes_off_and_lands_has_these_items(tmp_path: Path) -> None:
    text = plan_text(drawing(tmp_path, TAKE_OFF, RETURN))
    assert [(command, frame) for command, frame, _ in flown_items(text)] == [(22, 3), (20, 2)]


def test_a_landing_elsewhere_is_one(tmp_path: Path) -> None:
    text = plan_text(
        drawing(tmp_path, TAKE_OFF, WAY[0], item(21, 0, 0, 0, None, *square(40)[2], 0))
    )
    command, _, params = flown_items(text)[-1]
    assert command == 21 and metres_between(tuple(params[4:6]), tuple(square(40)[2])) < 0.01  # type: ignore[arg-type]


def test_heights_above_the_sea_are_written_so(tmp_path: Path) -> None:
    text = plan_text(drawing(tmp_path, TAKE_OFF, waypoint(30, 0, 512.5, frame=0), RETURN))
    assert flown_items(text)[1][1] == 0 and flown_items(text)[1][2][6] == 512.5


# -- GeoJSON ---------------------------------------------------------------------------------------


def features(text: str) -> dict[str, list[dict[str, Any]]]:
    found: dict[str, list[dict[str, Any]]] = {}
    for feature in json.loads(text)["features"]:
        found.setdefault(feature["properties"]["kind"], []).append(feature)
    return found


def turned(corners: list[list[float]]) -> float:
    """Twice the area in x, y: more than 0 if it runs counterclockwise (the shoelace formula)."""
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(corners))


@pytest.mark.parametrize("is_reversed", [False, True])
def test_geojson_keeps_the_rules_of_its_standard(is_reversed: bool, tmp_path: Path) -> None:
    """RFC 7946: positions are lon, lat (3.1.1), rings are closed and counterclockwise (3.1.6)."""
    areas = [polygon(a["polygon"][:: -1 if is_reversed else 1], a["inclusion"]) for a in FENCE]
    text = geojson_text(drawing(tmp_path, TAKE_OFF, *WAY, RETURN, polygons=areas))
    collection = json.loads(text)
    assert set(collection) == {"type", "features"} and collection["type"] == "FeatureCollection"
    for feature in collection["features"]:
        assert set(feature) == {"type", "properties", "geometry"} and feature["type"] == "Feature"
        assert set(feature["geometry"]) == {"type", "coordinates"}
    found = features(text)
    assert found["home"][0]["geometry"]["coordinates"] == pytest.approx([HOME[1], HOME[0]])
    for zone in (*found["fence"], *found["keep_out"]):
        ((*corners, last),) = zone["geometry"]["coordinates"]
        assert len(corners) == 4 and corners[0] == last
        assert turned([*corners, last]) > 0


def test_geojson_has_places_fence_and_the_way_of_the_plan(tmp_path: Path) -> None:
    found = features(geojson_text(drawing(tmp_path, TAKE_OFF, *WAY, RETURN)))
    assert [p["properties"]["name"] for p in found["place"]] == ["W2", "W3", "W4"]
    assert [p["properties"]["up_m"] for p in found["place"]] == [20, 35, 20]
    names = {
        tuple(p["geometry"]["coordinates"]): p["properties"]["name"]
        for p in (*found["home"], *found["place"])
    }
    (line,) = found["route"]
    way = [names[tuple(point)] for point in line["geometry"]["coordinates"]]
    assert way == ["Home", "W2", "W3", "W4", "Home"]
    assert "loop" not in found and "flown" not in found


@pytest.mark.parametrize("last", [RETURN, item(177, 2, -1, frame=2)])
def test_what_is_exported_is_imported_again(last: dict[str, Any], tmp_path: Path) -> None:
    mission = load_mission(imported(tmp_path, plan(TAKE_OFF, *PLAIN, last, polygons=FENCE))[0])
    text = geojson_text(mission_drawing(mission, None))
    again = load_mission(imported(tmp_path, text, "again.geojson")[0])
    for line, formula in mission.task.items():  # a lap may begin anywhere, in either direction
        assert set(str(again.task[line]).split(" & ")) == set(str(formula).split(" & "))
    for name, place in mission.places.items():
        assert math.dist(place.position, again.places[name].position) < 0.01
    zones = zip(mission.limits.keep_out.values(), again.limits.keep_out.values(), strict=True)
    for one, other in ((mission.limits.fence, again.limits.fence), *zones):
        assert all(min(horizontal_distance(c, d) for d in other) < 0.01 for c in one)


def test_safe_places_are_rally_points_in_a_drawing(tmp_path: Path) -> None:
    """One that the plan visits is a place as well; as a point of the route it has its height."""
    rally = [[*square(40)[2], 0], [*square(30)[0], 12]]
    shown = drawing(tmp_path, TAKE_OFF, waypoint(40, 40), RETURN, rally=rally)
    assert shown.safe == ("W2", "R2")
    points = json.loads(plan_text(shown))["rallyPoints"]["points"]
    assert [point[2] for point in points] == [0.0, 0.0]
    features = json.loads(geojson_text(shown))["features"]
    kinds = [(f["properties"].get("name"), f["properties"]["kind"]) for f in features]
    points = [("Home", "home"), ("W2", "place"), ("W2", "rally"), ("R2", "rally")]
    assert [each for each in kinds if each[1] in ("home", "place", "rally")] == points
    again = load_mission(imported(tmp_path, geojson_text(shown), "again.geojson")[0])
    assert again.safe_places == ("Home", "W2", "R2")
    assert again.places["R2"].position[2] == pytest.approx(-12)
