"""A plan of QGroundControl is imported, flown, and what was flown is exported for maps."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from commands import Companion
from plan_files import (
    HOME,
    HOME_AMSL_M,
    RETURN,
    TAKE_OFF,
    at,
    circle,
    item,
    plan,
    polygon,
    square,
    waypoint,
)

from companion.geometry import is_in_polygon
from companion.plans.route_plan import LatLon, metres_between

WAY = ((30, 0), (30, 40), (0, 40))
ZONE = square(5, north_m=12)
"""On the straight way from home to the first waypoint."""


@pytest.fixture
def run(tmp_path: Path, companion: Companion) -> Path:
    """The folder of the flight."""
    areas = [polygon(square(90)), polygon(ZONE, inclusion=False)]
    items = [TAKE_OFF, *(waypoint(*point) for point in WAY), item(93, 3, frame=2), RETURN]
    content = plan(*items, polygons=areas, circles=[circle(HOME, 120)])
    (tmp_path / "field.plan").write_text(json.dumps(content), encoding="utf-8")
    assert companion("import", tmp_path / "field.plan", "-o", tmp_path / "field.yaml").code == 0
    flown = companion(
        *("sim", tmp_path / "field.yaml", "--speed", "max", "--monitor", "off"),
        *("--log-dir", tmp_path / "runs"),
    )
    assert flown.code == 0, flown.out + flown.err
    assert "task satisfied, landed" in flown.out
    (folder,) = (each for each in (tmp_path / "runs").iterdir() if not each.is_symlink())
    return folder


def features(path: Path) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for feature in json.loads(path.read_text(encoding="utf-8"))["features"]:
        geometry = feature["geometry"]["coordinates"]
        found.setdefault(feature["properties"]["kind"], []).append(geometry)
    return found


def nearest_to(point: LatLon, way: list[LatLon]) -> int:
    """The index of the point of a way that comes nearest."""
    return min(range(len(way)), key=lambda index: metres_between(way[index], point))


def test_an_imported_plan_is_flown_and_exported(
    run: Path, tmp_path: Path, companion: Companion
) -> None:
    """Through the waypoints, in their order, round the exclusion, and home."""
    map_ = tmp_path / "flown.geojson"
    ended = companion("export", run, "-o", map_)
    assert ended.code == 0 and ended.out == f"written    {map_}\n", ended.err
    (line,) = features(map_)["flown"]
    way = [(latitude, longitude) for longitude, latitude in line]
    nearest = [min(range(len(way)), key=lambda i: metres_between(way[i], at(*p))) for p in WAY]
    assert nearest == sorted(nearest)
    for index, point in zip(nearest, WAY, strict=True):
        assert metres_between(way[index], at(*point)) < 2.0
    assert all(metres_between(end, HOME) < 1.0 for end in (way[0], way[-1]))
    zone = [(corner[0], corner[1]) for corner in ZONE]
    assert len(way) > 100 and not any(is_in_polygon(point, zone) for point in way)

    path = tmp_path / "flown.plan"
    assert companion("export", run, "-o", path).code == 0
    mission = json.loads(path.read_text(encoding="utf-8"))["mission"]
    assert mission["plannedHomePosition"] == pytest.approx([*HOME, HOME_AMSL_M], abs=0.5)
    assert [entry["command"] for entry in mission["items"]] == [22, 16, 16, 16, 20]
    for entry, point in zip(mission["items"][1:4], WAY, strict=True):
        assert metres_between(tuple(entry["params"][4:6]), at(*point)) < 0.01
