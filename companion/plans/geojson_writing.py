"""Writes a drawing as GeoJSON (RFC 7946): one feature per place, area and line, with its `kind`.

    home, place, rally    a point, with name, radius_m, and up_m or amsl_m; a safe place that the
        plan visits gives two of them, a place and a rally point
    fence, keep_out    a polygon, counterclockwise and closed
    route, loop    the route flown once, and the one flown again and again
    flown    the vehicle's track

Coordinates are [lon, lat] in degrees, to a tenth of a millimetre. There is no third one: it would
be the height above the ellipsoid, which a mission does not know.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any

from companion.plans.areas import is_counterclockwise
from companion.plans.drawing import Drawing, DrawnPlace, DrawnVisit
from companion.plans.route_plan import LatLon

DIGITS = 9


def geojson_text(drawing: Drawing) -> str:
    """The text of a GeoJSON file."""
    visited = {visit.place for visit in (*drawing.prefix, *drawing.loop)}
    features = [
        _point(place, "home" if name == drawing.start else "place")
        for name, place in drawing.places.items()
        if name in visited or name not in drawing.safe
    ]
    features += [_point(drawing.places[name], "rally") for name in drawing.safe]
    features.append(_polygon(drawing.fence, {"name": "fence", "kind": "fence"}))
    for name, zone in drawing.keep_out.items():
        features.append(_polygon(zone, {"name": name, "kind": "keep_out"}))
    start = (DrawnVisit(drawing.start), *drawing.prefix)
    features += _line("route", _way(drawing, start))
    if drawing.loop:
        features += _line("loop", _way(drawing, (drawing.loop[-1], *drawing.loop)))
    features += _line("flown", drawing.flown)
    collection = {"type": "FeatureCollection", "features": features}
    return json.dumps(collection, indent=1, allow_nan=False) + "\n"


def _way(drawing: Drawing, visits: Iterable[DrawnVisit]) -> list[LatLon]:
    return [drawing.places[visit.place].position for visit in visits]


def _point(place: DrawnPlace, kind: str) -> dict[str, Any]:
    key = "amsl_m" if place.height.is_amsl else "up_m"
    about = {
        "name": place.name,
        "kind": kind,
        key: round(place.height.metres, 3),
        "radius_m": round(place.radius_m, 3),
    }
    return _feature("Point", _position(place.position), about)


def _polygon(corners: Sequence[LatLon], about: dict[str, Any]) -> dict[str, Any]:
    """A closed ring by the right-hand rule (RFC 7946, 3.1.6)."""
    ring = list(corners if is_counterclockwise(corners) else reversed(corners))
    return _feature("Polygon", [[_position(corner) for corner in (*ring, ring[0])]], about)


def _line(kind: str, way: Sequence[LatLon]) -> list[dict[str, Any]]:
    """A line; none for fewer than two points (RFC 7946, 3.1.4)."""
    if len(way) < 2:
        return []
    return [_feature("LineString", [_position(point) for point in way], {"kind": kind})]


def _feature(kind: str, coordinates: list[Any], about: dict[str, Any]) -> dict[str, Any]:
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "properties": about, "geometry": geometry}


def _position(point: LatLon) -> list[float]:
    latitude, longitude = point
    return [round(longitude, DIGITS), round(latitude, DIGITS)]
