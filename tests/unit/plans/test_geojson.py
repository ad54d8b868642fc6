"""GeoJSON as missions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from plan_files import HOME, at, imported, square

from companion import load_mission
from companion.errors import MissionError
from companion.plans.draft import Draft
from companion.plans.draft_places import Given
from companion.plans.route_plan import metres_between

UP = Given(home=HOME, up_m=20.0)
HIGH = Given(up_m=20.0)
BEND = ((0, 0), (0, 9), (9, 9), (0, 0))


def feature(shape: str, coordinates: Any, **properties: Any) -> dict[str, Any]:
    geometry = {"type": shape, "coordinates": coordinates}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def lon_lat(north_m: float, east_m: float, *third: float) -> list[float]:
    latitude, longitude = at(north_m, east_m)
    return [longitude, latitude, *third]


def ring(reach_m: float) -> list[list[float]]:
    corners = [[longitude, latitude] for latitude, longitude in square(reach_m)]
    return [*corners, corners[0]]


def collection(*features: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"type": "FeatureCollection", "features": list(features)} | more


def refusal(folder: Path, content: Any, given: Given = UP) -> str:
    with pytest.raises(MissionError) as error:
        imported(folder, content, "map.geojson", given)
    return str(error.value).removeprefix(f"{folder}/map.geojson: ")


def test_points_have_their_names_heights_and_radii(tmp_path: Path) -> None:
    drawn = collection(
        feature("Point", lon_lat(0, 0), name="Base", kind="home", up_m=8),
        feature("Point", lon_lat(30, 0), name="North gate", up_m=12, radius_m=3),
        feature("Point", lon_lat(30, 40), name="7", up_m=15),
    )
    text, draft = imported(tmp_path, drawn, "map.geojson")
    places = load_mission(text).places
    assert places["Home"].position == pytest.approx((0, 0, -8), abs=0.001)
    assert places["North_gate"].position == pytest.approx((30, 0, -12), abs=0.001)
    assert places["North_gate"].inner_m == 3.0 and "_7" in places
    assert draft.data["task"]["route"] == "F at(North_gate) & F at(_7)"


LINE = feature("LineString", [lon_lat(30, 0), lon_lat(30, 40)])


@pytest.mark.parametrize("name", ["Home", "home", " HOME "])
@pytest.mark.parametrize("is_first", [True, False])
def test_a_point_named_home_is_where_the_mission_begins(
    name: str, is_first: bool, tmp_path: Path
) -> None:
    home = feature("Point", lon_lat(0, 0), name=name, up_m=8)
    drawn = collection(*((home, LINE) if is_first else (LINE, home)))
    text, draft = imported(tmp_path, drawn, "map.geojson", HIGH)
    places = load_mission(text).places
    assert list(places) == ["Home", "W1", "W2"]
    assert places["Home"].position == pytest.approx((0, 0, -8), abs=0.001)
    assert metres_between(position_of(draft, "Home"), HOME) < 0.01
    assert any(f"home is feature {2 - is_first} (" in line for line in draft.notes)


def test_what_is_said_of_home_goes_before_a_name(tmp_path: Path) -> None:
    named = feature("Point", lon_lat(0, 9), name="Home")
    base = feature("Point", lon_lat(0, 0), name="Base", kind="home")
    place = feature("Point", lon_lat(0, 9), name="Home", kind="place")
    for drawn in (collection(named, LINE, base), collection(base, LINE, place)):
        draft = imported(tmp_path, drawn, "map.geojson", HIGH)[1]
        assert metres_between(position_of(draft, "Home"), HOME) < 0.01
        assert metres_between(position_of(draft, "Home_"), at(0, 9)) < 0.01
    given = Given(home=at(-9, 0), up_m=20.0)
    draft = imported(tmp_path, collection(named, LINE), "map.geojson", given)[1]
    assert metres_between(position_of(draft, "Home"), at(-9, 0)) < 0.01
    assert "home in the file is 13 m from --home, which counts" in draft.notes
    assert list(draft.data["places"]) == ["Home", "W1", "W2"]


def test_a_mission_begins_at_one_point(tmp_path: Path) -> None:
    named = feature("Point", lon_lat(0, 9), name="home")
    said = refusal(tmp_path, collection(named, named, LINE))
    assert said.startswith("feature 2 (home): is a second point named Home")
    base = feature("Point", lon_lat(0, 0), name="Base", kind="home")
    said = refusal(tmp_path, collection(base, LINE, base))
    assert said.startswith("feature 3 (Base): is a second point of the kind home")


def position_of(draft: Draft, place: str) -> tuple[float, float]:
    entry = draft.data["places"][place]
    return entry["lat_deg"], entry["lon_deg"]


def test_heights_above_the_ellipsoid_are_not_used(tmp_path: Path) -> None:
    drawn = collection(feature("Point", lon_lat(30, 0, 540.0), name="A"))
    text, draft = imported(tmp_path, drawn, "map.geojson", UP)
    assert load_mission(text).places["A"].position[2] == pytest.approx(-20)
    above = "540 m above the ellipsoid (third coordinate)"
    instead = "in place of that 20 m above home, by --up-m"
    assert f"not used: 1 altitude of the file, {above}; {instead}" in draft.notes
    assert f"its altitude is {above}" in refusal(tmp_path, drawn, Given(home=HOME))
    for point in (lon_lat(30, 0, 0.0), lon_lat(30, 0)):
        draft = imported(tmp_path, feature("Point", point), "map.geojson", UP)[1]
        assert not any("not used" in line for line in draft.notes)


@pytest.mark.parametrize("kind", ["rally", "place"])
def test_points_that_nothing_flies_to_have_a_known_height_too(kind: str, tmp_path: Path) -> None:
    line = feature("LineString", [lon_lat(0, 0), lon_lat(30, 0)])
    drawn = collection(line, feature("Point", lon_lat(0, 30), amsl_m=510, kind=kind))
    said = refusal(tmp_path, drawn, UP)
    assert said.startswith("feature 2: its altitude is above the sea, and nothing says how high")
    known = Given(home=HOME, home_amsl_m=488.0, up_m=20.0)
    assert load_mission(imported(tmp_path, drawn, "map.geojson", known)[0])


def test_polygons_say_what_they_are_unless_there_is_one(tmp_path: Path) -> None:
    point = feature("Point", lon_lat(30, 0))
    limits = load_mission(
        imported(tmp_path, collection(point, feature("Polygon", [ring(90)])), "map.geojson", UP)[0]
    ).limits
    assert max(north for north, _ in limits.fence) == pytest.approx(90, abs=0.01)
    pond = feature("Polygon", [ring(9)], name="Pond", kind="keep_out")
    home = Given(home=at(30, 30), up_m=20.0)
    drawn = collection(point, feature("Polygon", [ring(90)], kind="fence"), pond)
    limits = load_mission(imported(tmp_path, drawn, "map.geojson", home)[0]).limits
    assert list(limits.keep_out) == ["Pond"]
    said = refusal(tmp_path, collection(point, *[feature("Polygon", [ring(r)]) for r in (80, 90)]))
    assert said.startswith("feature 3: is one of several polygons")


def test_shapes_of_many_parts_are_their_parts(tmp_path: Path) -> None:
    """Mapping tools save a layer of polygons, even of one, as MultiPolygons."""
    points = feature("MultiPoint", [lon_lat(30, 0), lon_lat(30, 40)], name="Tree")
    fence = feature("MultiPolygon", [[ring(90)]], kind="fence")
    parts = [[[lon_lat(n + i, n + j) for i, j in BEND]] for n in (50, 70)]
    ponds = feature("MultiPolygon", parts, kind="keep_out")
    mission = load_mission(
        imported(tmp_path, collection(points, fence, ponds), "map.geojson", UP)[0]
    )
    assert list(mission.places) == ["Home", "Tree_1", "Tree_2"]
    assert list(mission.limits.keep_out) == ["zone_2", "zone_3"]
    assert max(north for north, _ in mission.limits.fence) == pytest.approx(90, abs=0.01)
    line = feature("MultiLineString", [[lon_lat(30, 0), lon_lat(30, 40)]])
    assert "W2" in imported(tmp_path, line, "map.geojson", UP)[0]
    said = refusal(tmp_path, feature("MultiPolygon", [[ring(80)], [ring(90)]]))
    assert said.startswith("part 2 of feature 1: is one of several polygons")


def test_a_line_that_begins_at_home_leads_from_there(tmp_path: Path) -> None:
    line = feature("LineString", [lon_lat(0, 0), lon_lat(0, 0.5), lon_lat(30, 0), lon_lat(30, 40)])
    _, draft = imported(tmp_path, line, "map.geojson", UP)
    assert draft.data["task"]["route"] == "ordered_visit(W3, W4)"


def test_a_bare_geometry_is_read_too(tmp_path: Path) -> None:
    line = {"type": "LineString", "coordinates": [lon_lat(30, 0), lon_lat(30, 40)]}
    for content in (line, feature("LineString", line["coordinates"])):
        text, _ = imported(tmp_path, content, "map.json", UP)
        assert list(load_mission(text).places) == ["Home", "W1", "W2"]


@pytest.mark.parametrize(
    ("content", "what"),
    [
        ("", "is not JSON: Expecting value, line 1, column 1"),
        ("[1, 2]", "is JSON, but no object"),
        ('{"type": "Feature", "type": "Feature"}', "has the key 'type' twice in one object"),
        ('{"type": NaN}', "has the number NaN"),
        ('{"a": ' * 60 + "1" + "}" * 60, "nests deeper than 40 levels"),
        ("[" * 200_000, "nests deeper than 40 levels"),
        ('{"type": ' + "9" * 5000 + "}", "is not JSON that can be read"),
        (collection(feature("Point", [8.5])), "feature 1: a position is not a list of 2 numbers"),
        (collection(feature("Point", ["8", "47"])), "feature 1: a position is not a number"),
        ('{"type": "Point", "coordinates": [8.5, 1e400]}', "feature 1: a position is too large"),
        (collection(feature("Point", [8.5, 97.0])), "feature 1: latitude 97, longitude 8.5"),
        (collection(feature("MultiPolygon", [])), "feature 1: is a MultiPolygon without parts"),
        (collection(feature("MultiPoint", [[8.5]])), "feature 1: a position is not a list"),
        (
            collection(feature("MultiPolygon", [7])),
            "feature 1: has coordinates that are not a list",
        ),
        (collection(feature("GeometryCollection", [])), "feature 1: is a GeometryCollection, not"),
        (collection(feature("Polygon", [])), "feature 1: is a polygon without corners"),
        (collection(feature("Polygon", [[[8, 47], [8, 47]]])), "feature 1: a polygon of 1 corners"),
        (collection(feature("Point", [8, 47], name=3)), "feature 1: name is not a text"),
        (collection(feature("Point", [8, 47], kind="tree")), "feature 1: is of the kind 'tree'"),
        (collection({"type": "Feature"}), "feature 1: has no geometry"),
        (collection("point"), "feature 1: is not an object"),  # type: ignore[arg-type]
        (collection(crs={"properties": {"name": "EPSG:2056"}}), "coordinates that are not WGS 84"),
    ],
)
def test_what_cannot_be_meant_is_refused(content: Any, what: str, tmp_path: Path) -> None:
    assert what in refusal(tmp_path, content)
