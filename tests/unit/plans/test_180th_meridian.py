"""A file means on the 180th meridian what it means elsewhere, and comes back as it left."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from plan_files import RETURN, TAKE_OFF, imported, item, plan, polygon

from companion import load_mission
from companion.api.drawings import mission_drawing
from companion.geometry import GlobalOrigin
from companion.mission.model import Mission
from companion.plans.draft_places import Given
from companion.plans.geojson_writing import geojson_text
from companion.plans.qgc_writing import plan_text
from companion.plans.route_plan import LatLon

FENCE = ((-80.0, -80.0), (-80.0, 80.0), (80.0, 80.0), (80.0, -80.0))
ZONE = ((30.0, -4.0), (30.0, 4.0), (38.0, 4.0), (38.0, -4.0))
BEYOND = tuple((north + 300, east) for north, east in ZONE)
PLACES = ((20.0, 0.0), (20.0, 60.0), (-40.0, 60.0))
UP = Given(up_m=20.0)

OnEarth = Callable[[tuple[float, float]], LatLon]


def on_earth(longitude_deg: float, beyond: bool = False) -> OnEarth:
    """Takes metres about a home there to degrees; beyond 180, if asked for, as some maps do."""
    home = GlobalOrigin(-16.8, longitude_deg, 0.0)

    def degrees(point: tuple[float, float]) -> LatLon:
        latitude, longitude, _ = home.to_global((*point, 0.0))
        return latitude, longitude + 360.0 if beyond and longitude < 0 else longitude

    return degrees


def a_plan(at: OnEarth) -> str:
    way = [item(16, 0, 0, 0, None, *at(place), 20) for place in PLACES]
    zones = [polygon([at(c) for c in zone], inclusion=False) for zone in (ZONE, BEYOND)]
    areas = {"polygons": [polygon([at(c) for c in FENCE]), *zones], "rally": [[*at((-40, 0)), 20]]}
    begins = {"plannedHomePosition": [*at((0, 0)), 10]}
    return json.dumps(plan(TAKE_OFF, *way, RETURN, **areas, **begins))


def a_map(at: OnEarth) -> str:
    def feature(kind: str, shape: str, coordinates: Any) -> dict[str, Any]:
        about = {"kind": kind, "up_m": 20}
        geometry = {"type": shape, "coordinates": coordinates}
        return {"type": "Feature", "properties": about, "geometry": geometry}

    def ring(corners: tuple[tuple[float, float], ...]) -> list[list[list[float]]]:
        return [[[*at(corner)][::-1] for corner in (*corners, corners[0])]]

    line = [[*at(place)][::-1] for place in ((0.0, 0.0), *PLACES)]
    features = [
        feature("fence", "Polygon", ring(FENCE)),
        *(feature("keep_out", "Polygon", ring(zone)) for zone in (ZONE, BEYOND)),
        feature("route", "LineString", line),
        feature("rally", "Point", [*at((-40, 0))][::-1]),
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


def a_kml(at: OnEarth) -> str:
    def listed(*points: tuple[float, float]) -> str:
        return (
            f"<coordinates>{' '.join('{1!r},{0!r}'.format(*at(p)) for p in points)}</coordinates>"
        )

    def ring(corners: tuple[tuple[float, float], ...]) -> str:
        return f"<LinearRing>{listed(*corners, corners[0])}</LinearRing>"

    outer = f"<outerBoundaryIs>{ring(FENCE)}</outerBoundaryIs>"
    holes = "".join(f"<innerBoundaryIs>{ring(zone)}</innerBoundaryIs>" for zone in (ZONE, BEYOND))
    line = f"<LineString>{listed((0.0, 0.0), *PLACES)}</LineString>"
    shapes = (f"<Polygon>{outer}{holes}</Polygon>", line)
    return f"<kml>{''.join(f'<Placemark>{shape}</Placemark>' for shape in shapes)}</kml>"


FILES = [("field.plan", a_plan), ("field.geojson", a_map), ("field.kml", a_kml)]


def in_metres(mission: Mission) -> list[float]:
    """All that lies anywhere."""
    areas = [mission.limits.fence, *mission.limits.keep_out.values()]
    places = [place.position for place in mission.places.values()]
    return [metres for points in (*areas, places) for point in points for metres in point]


@pytest.mark.parametrize(("name", "content"), FILES)
@pytest.mark.parametrize("beyond", [False, True])
@pytest.mark.parametrize(
    "longitude_deg", [179.9995, pytest.param(-179.9995, marks=pytest.mark.long), 180.0]
)
def test_a_file_means_there_what_it_means_elsewhere(
    name: str, content: Callable[[OnEarth], str], beyond: bool, longitude_deg: float, tmp_path: Path
) -> None:
    elsewhere, told = imported(tmp_path, content(on_earth(8.5)), name, UP)
    there, also_told = imported(tmp_path, content(on_earth(longitude_deg, beyond)), name, UP)
    assert told.notes == also_told.notes
    there_in_metres = in_metres(load_mission(there))
    assert there_in_metres == pytest.approx(in_metres(load_mission(elsewhere)), abs=0.01)
    limits = also_told.data["limits"]
    corners = [c for area in (limits["fence"], *limits["keep_out"].values()) for c in area]
    longitudes = [p["lon_deg"] for p in also_told.data["places"].values()]
    assert all(abs(longitude) <= 180 for longitude in (*longitudes, *(c[1] for c in corners)))


@pytest.mark.parametrize(("name", "write"), [("a.plan", plan_text), ("a.geojson", geojson_text)])
@pytest.mark.parametrize(
    "longitude_deg", [179.9995, pytest.param(-179.9995, marks=pytest.mark.long), 180.0]
)
def test_what_is_exported_there_is_imported_again(
    name: str, write: Callable[..., str], longitude_deg: float, tmp_path: Path
) -> None:
    text, _ = imported(tmp_path, a_plan(on_earth(longitude_deg)))
    mission = load_mission(text)
    written = write(mission_drawing(mission, None))
    again = load_mission(imported(tmp_path, written, name)[0])
    assert set(again.limits.keep_out) == {"polygon_2"}
    assert sorted(in_metres(again)) == pytest.approx(sorted(in_metres(mission)), abs=0.01)
