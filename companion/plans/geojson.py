"""GeoJSON (RFC 7946) as a flight plan: points, lines and polygons with their properties.

Coordinates are [lon, lat]. A third one is metres above the ellipsoid, which differs by tens of
metres from sea level; it is not used, and a note says so. Heights are properties: `up_m` above
home, `amsl_m` above sea level. Other properties: `name`, `kind` (shapes.py), `radius_m`. A
MultiPoint, MultiLineString or MultiPolygon stands for its parts; mapping tools save single polygons
as MultiPolygons.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from companion.plans.json_text import JsonObject, numbers, read_json
from companion.plans.route_plan import (
    Height,
    ItemRefused,
    LatLon,
    RoutePlan,
    UnusedHeight,
    check_degrees,
    check_points,
)
from companion.plans.shapes import DrawnHeight, Line, Point, Polygon, Shape, plan_of, word

WGS84 = ("CRS84", "4326")
SPLIT = "split it into features of one shape each"
PARTS = {"MultiPoint": "Point", "MultiLineString": "LineString", "MultiPolygon": "Polygon"}


def read_geojson(text: str) -> RoutePlan:
    """The plan of a GeoJSON file.

    Raises:
        ItemRefused: a mission cannot express it.
    """
    file = JsonObject(read_json(text), "")
    kind = file.text("type")
    if "crs" in file and not str(file.object("crs").object("properties").text("name")).endswith(
        WGS84
    ):
        raise ItemRefused("", "has coordinates that are not WGS 84", "save it in EPSG:4326")
    if kind == "FeatureCollection":
        features = file.list("features")
    elif kind == "Feature":
        features = [read_json(text)]
    else:
        features = [{"type": "Feature", "properties": {}, "geometry": read_json(text)}]
    entries = enumerate(features, 1)
    return plan_of("GeoJSON", [each for index, entry in entries for each in _shapes(entry, index)])


def _shapes(entry: Any, index: int) -> Iterator[Shape]:
    """The shapes of a feature."""
    feature = JsonObject(entry, f"feature {index}")
    if feature.text("type") != "Feature":
        raise ItemRefused(feature.item, "is not a Feature", "save the file again")
    properties = JsonObject(
        feature.object("properties").data if "properties" in feature else {}, feature.item
    )
    name = word(properties.text("name") if "name" in properties else "")
    item = f"feature {index}" + (f" ({name})" if name else "")
    geometry = JsonObject(feature.object("geometry").data, item)
    what = geometry.text("type")
    if what not in (*PARTS, *PARTS.values()):
        raise ItemRefused(item, f"is a {what[:40]}, not a Point, LineString or Polygon", SPLIT)
    coordinates = geometry.list("coordinates")
    if what not in PARTS:
        yield _shape(what, coordinates, JsonObject(properties.data, item), name, f"P{index}")
        return
    if not coordinates:
        raise ItemRefused(item, f"is a {what} without parts", "draw it anew")
    for number, part in enumerate(coordinates, 1):
        one = item if len(coordinates) == 1 else f"part {number} of {item}"
        end = "" if one == item else f"_{number}"
        about = JsonObject(properties.data, one)
        yield _shape(PARTS[what], _list(part, one), about, name and name + end, f"P{index}{end}")


def _shape(
    what: str, coordinates: list[Any], properties: JsonObject, name: str, point_name: str
) -> Shape:
    """One shape, by the name of its geometry in RFC 7946."""
    item = properties.item
    kind = properties.text("kind") if "kind" in properties else ""
    said = _height(properties)
    if what == "Point":
        radius_m = properties.number("radius_m") if "radius_m" in properties else None
        position, height = _corner(coordinates, item, said)
        return Point(item, name or point_name, kind, position, height, radius_m)
    if what == "LineString":
        check_points(len(coordinates))
        corners = tuple(_corner(each, item, said) for each in coordinates)
        return Line(item, name, kind, corners)
    check_points(sum(len(_list(one, item)) for one in coordinates))
    rings = [tuple(_position(each, item) for each in one) for one in coordinates]
    if not rings:
        raise ItemRefused(item, "is a polygon without corners", "draw it anew")
    return Polygon(item, name, kind, rings[0], tuple(rings[1:]))


def _list(value: Any, item: str) -> list[Any]:
    if not isinstance(value, list):
        raise ItemRefused(item, "has coordinates that are not a list", "save the file again")
    return value


def _position(value: Any, item: str) -> LatLon:
    return _corner(value, item, None)[0]


def _corner(value: Any, item: str, said: Height | None) -> tuple[LatLon, DrawnHeight]:
    """A position, and its height: that of the properties, or one that is not used."""
    longitude, latitude, *rest = numbers(value, item, "a position", 2)
    height: DrawnHeight = said
    if said is None and rest and rest[0] != 0:
        height = UnusedHeight(rest[0], " above the ellipsoid (third coordinate)")
    return check_degrees(item, latitude, longitude), height


def _height(properties: JsonObject) -> Height | None:
    if "up_m" in properties:
        return Height(properties.number("up_m"))
    return Height(properties.number("amsl_m"), True) if "amsl_m" in properties else None
