"""Files of strangers: whatever is in them, they become a mission or are refused; nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from drawn import drawn
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plan_files import TAKE_OFF, circle, imported, item, plan, polygon, square, waypoint

from companion import load_mission
from companion.errors import MissionError
from companion.plans.draft import MAX_AREAS, MAX_RALLY
from companion.plans.draft_places import Given
from companion.plans.files import MAX_BYTES, READERS
from companion.plans.route_plan import MAX_POINTS

UP = Given(up_m=20.0, payload=100)
WHOLE = plan(
    TAKE_OFF,
    waypoint(30, 0, hold_s=3),
    item(178, 1, 4, frame=2),
    item(2000, 0, 0, 1, frame=2),
    waypoint(30, 40, 500.0, frame=0),
    item(177, 2, -1, frame=2),
    polygons=[polygon(square(90)), polygon(square(4, north_m=-30), inclusion=False)],
    circles=[circle(square(1)[0], 80)],
    rally=[[*square(20)[0], 9]],
)
ODD = st.sampled_from(
    [None, True, -1, 0, 1, 3.7, 91, 1e300, 10**400, "", "x", "\x1b[2J", [], [None], {}, {"a": 1}]
)


def paths(data: Any, keys: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something stands in a tree."""
    found = [keys] if keys else []
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            found += paths(value, (*keys, key))
    return found


def changed(data: Any, keys: tuple[Any, ...], value: Any) -> Any:
    """The same tree with another value there, or without the key if that is an Ellipsis."""
    if not keys:
        return value
    copy = dict(data) if isinstance(data, dict) else list(data)
    if len(keys) == 1 and value is ...:
        del copy[keys[0]]
    else:
        copy[keys[0]] = changed(copy[keys[0]], keys[1:], value)
    return copy


@settings(drawn(80), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.sampled_from(paths(WHOLE)), value=st.one_of(st.just(...), ODD))
def test_a_plan_with_anything_anywhere_is_read_or_refused(
    where: tuple[Any, ...], value: Any, tmp_path: Path
) -> None:
    try:
        text, _ = imported(tmp_path, changed(WHOLE, where, value), "field.plan", UP)
    except MissionError as refused:
        assert str(refused).startswith(f"{tmp_path}/field.plan: ") and "\x1b" not in str(refused)
    else:
        assert "\x1b" not in text


def test_the_whole_plan_is_read(tmp_path: Path) -> None:
    assert imported(tmp_path, WHOLE, "field.plan", UP)


@settings(drawn(60), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(ending=st.sampled_from(sorted(READERS)), data=st.binary(max_size=60))
def test_bytes_are_read_or_refused(ending: str, data: bytes, tmp_path: Path) -> None:
    with pytest.raises(MissionError):
        imported(tmp_path, data, f"field{ending}", UP)


@pytest.mark.parametrize("ending", sorted(READERS))
def test_a_file_that_is_too_large_is_not_read(ending: str, tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=f"larger than {MAX_BYTES} bytes"):
        imported(tmp_path, b" " * (MAX_BYTES + 1), f"field{ending}")


def test_many_items_are_refused_before_each_is_compared_with_each(tmp_path: Path) -> None:
    way = [item(16, 0, 0, 0, 0, 47.4, 8.5 + 1e-4 * index, 20) for index in range(MAX_POINTS + 1)]
    with pytest.raises(MissionError, match=f"more than {MAX_POINTS}"):
        imported(tmp_path, plan(*way))
    with pytest.raises(MissionError, match="leads to more than 60 places"):
        imported(tmp_path, plan(*way[:400]))


def test_many_points_and_corners_of_a_map_are_refused(tmp_path: Path) -> None:
    line = [[8.5 + 1e-5 * index, 47.4] for index in range(MAX_POINTS + 1)]
    for kind, corners in (("LineString", line), ("Polygon", [line])):
        with pytest.raises(MissionError, match=f"more than {MAX_POINTS}"):
            imported(tmp_path, {"type": kind, "coordinates": corners}, "map.geojson", UP)
    points = " ".join(f"{east},{north}" for east, north in line)
    path = f"<LineString><coordinates>{points}</coordinates></LineString>"
    with pytest.raises(MissionError, match=f"more than {MAX_POINTS}"):
        imported(tmp_path, f"<kml><Placemark>{path}</Placemark></kml>", "map.kml", UP)


def test_many_corners_and_areas_of_a_fence_are_refused(tmp_path: Path) -> None:
    drawn = plan(TAKE_OFF, polygons=[polygon([*square(90)] * 100)])
    with pytest.raises(MissionError, match="polygon 1: is a polygon of more than 250 corners"):
        imported(tmp_path, drawn)
    areas = [polygon(square(90), inclusion=False)] * (MAX_AREAS + 1)
    with pytest.raises(MissionError, match=f"more than {MAX_AREAS}"):
        imported(tmp_path, plan(TAKE_OFF, polygons=areas))


def test_of_many_rally_points_some_are_safe_places(tmp_path: Path) -> None:
    rally = [[*square(90)[0][:1], 8.5446 + 1e-5 * index * 3, 9] for index in range(MAX_RALLY + 9)]
    text, draft = imported(tmp_path, plan(TAKE_OFF, waypoint(-90, 90), rally=rally))
    assert f"{len(rally)} rally points: the first {MAX_RALLY} are safe places" in draft.notes
    assert len(load_mission(text).safe_places) == 1 + MAX_RALLY


def test_a_key_that_is_twice_among_many_is_found_at_once(tmp_path: Path) -> None:
    keys = ",".join(f'"k{index}":1' for index in range(100_000))
    with pytest.raises(MissionError, match="has the key 'k99999' twice"):
        imported(tmp_path, f'{{{keys},"k99999":1}}')
