"""Fences and exclusion areas of plans as the fence and the keep-out zones of missions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plan_files import HOME, TAKE_OFF, at, circle, imported, plan, polygon, square, waypoint

from companion import load_mission
from companion.errors import MissionError
from companion.geometry import GlobalOrigin, NorthEast, is_in_polygon
from companion.mission.otherwise import Otherwise
from companion.mission.places import Limits
from companion.plans.areas import circle as polygon_of
from companion.plans.areas import common
from companion.plans.draft import FENCE_MARGIN_M
from companion.plans.route_plan import ItemRefused, LatLon, PlanArea, metres_between

WAY = (TAKE_OFF, waypoint(30, 0), waypoint(30, 40))


def limits(folder: Path, **more: Any) -> Limits:
    return load_mission(imported(folder, plan(*WAY, **more))[0]).limits


def refusal(folder: Path, **more: Any) -> str:
    with pytest.raises(MissionError) as error:
        imported(folder, plan(*WAY, **more))
    return str(error.value).removeprefix(f"{folder}/field.plan: ")


def are_near(corners: tuple[NorthEast, ...], others: Sequence[NorthEast]) -> bool:
    """Whether two lists have the same corners, in any order, to a centimetre."""
    return len(corners) == len(others) and all(
        any(math.dist(corner, other) < 0.01 for other in others) for corner in corners
    )


def test_the_fence_is_the_inclusion_polygon(tmp_path: Path) -> None:
    fence = limits(tmp_path, polygons=[polygon(square(80))]).fence
    assert are_near(fence, [(-80, -80), (-80, 80), (80, 80), (80, -80)])


def test_a_polygon_that_is_not_convex_is_a_fence(tmp_path: Path) -> None:
    corners = [(-50, -50), (-50, 90), (90, 90), (90, -50), (10, -10)]
    fence = limits(tmp_path, polygons=[polygon([at(*corner) for corner in corners])]).fence
    assert are_near(fence, corners)


def test_without_a_fence_a_box_around_all_places_is_one(tmp_path: Path) -> None:
    m = FENCE_MARGIN_M
    assert are_near(
        limits(tmp_path).fence, [(-m, -m), (-m, 40 + m), (30 + m, 40 + m), (30 + m, -m)]
    )
    assert any("has no fence" in line for line in imported(tmp_path, plan(*WAY))[1].notes)


@pytest.mark.parametrize("version", [None, 1, 3])
@pytest.mark.parametrize("areas", ["polygon", "polygons", "circles"])
def test_a_fence_of_another_version_is_not_left_out_without_a_word(
    tmp_path: Path, version: int | None, areas: str
) -> None:
    of_file = {"version": version, areas: [polygon(square(80))]}
    _, draft = imported(tmp_path, plan(*WAY) | {"geoFence": of_file})
    assert "fence: of a version that QGroundControl ignores; left out" in draft.notes


def test_several_inclusions_are_what_all_share(tmp_path: Path) -> None:
    areas = [polygon(square(80)), polygon(square(80, north_m=50))]
    assert are_near(
        limits(tmp_path, polygons=areas).fence, [(-30, -80), (-30, 80), (80, 80), (80, -80)]
    )


def test_a_circle_around_a_polygon_changes_nothing(tmp_path: Path) -> None:
    corners = [(-50, -50), (-50, 90), (90, 90), (90, -50), (10, -10)]
    areas = {"polygons": [polygon([at(*c) for c in corners])], "circles": [circle(HOME, 400)]}
    assert are_near(limits(tmp_path, **areas).fence, corners)


def test_inclusions_that_share_no_one_area_are_refused(tmp_path: Path) -> None:
    apart = [polygon(square(80)), polygon(square(80, north_m=500))]
    assert refusal(tmp_path, polygons=apart).startswith("fence polygon 2: nothing is inside it")
    dented = [(-50, -50), (-50, 90), (90, 90), (90, -50), (10, 60)]
    parts = [polygon([at(*c) for c in dented]), polygon(square(70))]
    assert "may have several parts" in refusal(tmp_path, polygons=parts)


def test_exclusions_are_keep_out_zones(tmp_path: Path) -> None:
    areas = [polygon(square(80)), polygon(square(5, north_m=-40), inclusion=False)]
    found = limits(tmp_path, polygons=areas, circles=[circle(at(-40, 40), 6, inclusion=False)])
    assert list(found.keep_out) == ["polygon_2", "circle_1"]
    assert are_near(found.keep_out["polygon_2"], [(-45, -5), (-45, 5), (-35, 5), (-35, -5)])
    north_east = [(-40 + 6 * math.cos(a), 40 + 6 * math.sin(a)) for a in (0.05, 1, 2, 3, 4, 5, 6)]
    assert all(is_in_polygon(point, found.keep_out["circle_1"]) for point in north_east)


def test_places_are_inside_the_fence_and_outside_the_zones(tmp_path: Path) -> None:
    said = refusal(tmp_path, polygons=[polygon(square(35))])
    assert said.startswith("item 3: is outside the fence of the plan")
    zone = polygon(square(8, north_m=30), inclusion=False)
    said = refusal(tmp_path, polygons=[polygon(square(80)), zone])
    assert said.startswith("item 2: is inside the exclusion area polygon_2")
    near = polygon(square(8, north_m=38.2), inclusion=False)
    said = refusal(tmp_path, polygons=[polygon(square(80)), near])
    assert said.startswith("item 2: place W2 is only 0.20 m from the keep-out zone polygon_2")


def test_an_exclusion_beyond_the_fence_is_told(tmp_path: Path) -> None:
    far = polygon(square(8, north_m=200), inclusion=False)
    text, draft = imported(tmp_path, plan(*WAY, polygons=[polygon(square(80)), far]))
    assert load_mission(text).limits.keep_out == {}
    assert "fence polygon 2: lies outside the fence; left out" in draft.notes


def test_rally_points_are_safe_places(tmp_path: Path) -> None:
    rally = [[*at(-10, 0), 15], [*at(-10, 20), 0], [*at(300, 0), 15]]
    text, draft = imported(tmp_path, plan(*WAY, polygons=[polygon(square(80))], rally=rally))
    mission = load_mission(text)
    assert mission.places["R1"].position == pytest.approx((-10, 0, -15), abs=0.001)
    assert mission.places["R2"].position == pytest.approx((-10, 20, -20), abs=0.001)
    assert "R1" not in mission.sets["Place"]
    assert mission.safe_places == ("Home", "R1", "R2")
    assert "otherwise: {land_at: [Home, R1, R2]}" in text
    assert "rally point 1: the safe place R1, to land at without a plan" in draft.notes
    assert "rally point 3: is outside the fence of the plan; left out" in draft.notes


def test_a_rally_point_at_a_place_is_that_place_and_one_at_home_is_none(tmp_path: Path) -> None:
    rally = [[*at(0.3, 0), 15], [*at(-20, 0.3), 15], [*at(-20, 0), 0]]
    content = plan(TAKE_OFF, waypoint(-20, 0), polygons=[polygon(square(80))], rally=rally)
    mission = load_mission(imported(tmp_path, content)[0])
    assert mission.safe_places == ("Home", "W2")
    assert list(mission.places) == ["Home", "W2"]
    alone = plan(TAKE_OFF, waypoint(-20, 0), polygons=[polygon(square(80))], rally=rally[:1])
    assert load_mission(imported(tmp_path, alone)[0]).otherwise is Otherwise.RETURN_HOME


def test_without_a_fence_the_box_holds_rally_points_but_for_those_far_away(tmp_path: Path) -> None:
    rally = [[*at(0, 300), 15], [*at(0, 6000), 15]]
    _, draft = imported(tmp_path, plan(TAKE_OFF, waypoint(-20, 0), rally=rally))
    assert draft.data["otherwise"] == {"land_at": ["Home", "R1"]}
    assert "rally point 2: is outside the fence of the plan; left out" in draft.notes


def test_fences_and_rally_points_of_version_1_are_ignored_with_a_word(tmp_path: Path) -> None:
    old = plan(*WAY)
    old["geoFence"] = {"version": 1, "polygon": [list(at(1, 1))]}
    old["rallyPoints"] = {"version": 1, "points": [[*at(0, 5), 10]]}
    told = imported(tmp_path, old)[1].notes
    assert sum("ignore" in line for line in told) == 2


@given(st.floats(1, 5000), st.booleans(), st.floats(0, 7))
def test_a_circle_is_inside_where_it_is_kept_in_and_around_where_it_is_kept_out(
    radius_m: float, is_inclusion: bool, angle: float
) -> None:
    corners = polygon_of("circle", HOME, radius_m, is_inclusion)
    ratios = [metres_between(HOME, corner) / radius_m for corner in corners]
    bound = 1.0 if is_inclusion else 1 / math.cos(math.pi / len(corners))
    assert ratios == pytest.approx([bound] * len(corners), rel=1e-4)
    edge_m = (1.001 if is_inclusion else 0.999) * radius_m
    point = at(edge_m * math.cos(angle), edge_m * math.sin(angle))
    assert is_in_polygon(point, corners) != is_inclusion


OFFSETS = st.tuples(st.floats(-60, 60), st.floats(-60, 60), st.integers(3, 9), st.floats(20, 90))


@given(
    st.lists(OFFSETS, min_size=2, max_size=4),
    st.lists(st.tuples(st.floats(-90, 90), st.floats(-90, 90)), min_size=20, max_size=20),
)
def test_what_is_common_is_what_is_inside_all(
    drawn: list[tuple[float, float, int, float]], points: list[NorthEast]
) -> None:
    areas = [PlanArea("area", "area", _regular(*form), True) for form in drawn]
    inside = [p for p in points if all(is_in_polygon(at(*p), area.corners) for area in areas)]
    try:
        shared = common(areas).corners
    except ItemRefused:  # what is common is smaller than a square metre
        assert all(_triangle_m2(*three) < 1.0 for three in combinations(inside, 3))
        return
    for point in points:
        near = any(
            abs(_gap_m(point, a, b)) < 0.05
            for a, b in zip(shared, (*shared[1:], shared[0]), strict=True)
        )
        assert near or (point in inside) == is_in_polygon(at(*point), shared)


def test_an_area_cut_by_others_is_still_known_to_be_convex() -> None:
    """A cut through an edge leaves a corner a millimetre beside the line, on its inner side."""
    drawn = ((53, 6, 73), (0, 3, 41.875), (53, 6, 73), (0, 3, 20))
    areas = [PlanArea("area", "area", _regular(0, east, *form), True) for east, *form in drawn]
    assert is_in_polygon(at(0, 0), common(areas).corners)


def _regular(north: float, east: float, sides: int, reach_m: float) -> tuple[LatLon, ...]:
    angles = [2 * math.pi * i / sides for i in range(sides)]
    return tuple(at(north + reach_m * math.cos(a), east + reach_m * math.sin(a)) for a in angles)


def _triangle_m2(a: NorthEast, b: NorthEast, c: NorthEast) -> float:
    return abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2


def _gap_m(point: NorthEast, a: LatLon, b: LatLon) -> float:
    """Distance of a point from the line through two corners."""
    p, q, r = at(*point), a, b
    scale = math.cos(math.radians(HOME[0]))
    (x, y), (dx, dy) = (
        ((p[1] - q[1]) * scale * 111_195, (p[0] - q[0]) * 111_195),
        ((r[1] - q[1]) * scale * 111_195, (r[0] - q[0]) * 111_195),
    )
    return (dx * y - dy * x) / max(1e-9, math.hypot(dx, dy))


@pytest.mark.parametrize("apart_m", [0.0, 1e-9, 0.001])
def test_of_corners_in_one_place_one_stays(apart_m: float) -> None:
    """Where the corners of two areas coincide, what they share has both."""
    near = (40 + apart_m, apart_m)
    corners = tuple(at(*corner) for corner in ((40, 0), near, (-20, 35), (-20, 0), (-20, -35)))
    shared = common([PlanArea("area", "area", corners, True)]).corners
    local = [GlobalOrigin(*HOME, 0.0).to_local(*corner, 0.0)[:2] for corner in shared]
    assert are_near(tuple(local), [(40, 0), (-20, 35), (-20, -35)])


def test_a_small_circle_keeps_its_shape() -> None:
    corners = polygon_of("circle", HOME, 0.4, True)
    shared = common([PlanArea("area", "area", corners, True)]).corners
    assert all(metres_between(HOME, corner) == pytest.approx(0.4, abs=0.01) for corner in shared)
    assert 5 < len(shared) < len(corners) and is_in_polygon(HOME, shared)
