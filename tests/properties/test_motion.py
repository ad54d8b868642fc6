"""Distance fields and routes against brute force and optima by other means.

Geometry is checked here by other means than in the program: cells by the separating axis
theorem on all cells at once, distances over all pairs, optima by a visibility graph.
"""

from __future__ import annotations

import math
from itertools import pairwise

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest
from drawn import drawn
from drawn_grids import WIDE, Array, brute_force_distance, distance_to_leg, draw_position, grids
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import ndimage

from companion.motion.clearance_choice import DETOUR
from companion.motion.clearance_level import ENOUGH_SHARE
from companion.motion.free_space import ENTRY_M
from companion.motion.grid import OccupancyGrid
from companion.motion.line_of_sight import LineOfSight
from companion.motion.path import Path
from companion.motion.region import Disc
from companion.motion.regions import Regions
from companion.motion.routes import PlaceRegion, RouteMap
from companion.motion.voronoi import passages

FAST = drawn(60)


def meets(a: Array, b: Array, cells: Array, grown: float) -> npt.NDArray[np.bool_]:
    """Whether segments a-b (n, 2) meet squares (m, 2), each side moved outwards: (n, m) bool.

    Separating axes of a segment and a square: rows, columns and the segment's normal.
    """
    half = 0.5 + grown
    middle = (a + b)[:, None] / 2 - (cells[None] + 0.5)
    reach = np.abs(b - a)[:, None] / 2
    leg = (b - a)[:, None]
    across = np.abs(leg[..., 0] * middle[..., 1] - leg[..., 1] * middle[..., 0])
    is_near = np.all(np.abs(middle) <= half + reach, axis=-1)
    return np.asarray(is_near & (across <= half * np.abs(leg).sum(axis=-1)))


@FAST
@given(grids())
def test_the_distance_field_equals_brute_force(grid: OccupancyGrid) -> None:
    np.testing.assert_allclose(grid.distance_m, brute_force_distance(grid), atol=1e-12)


@FAST
@given(grids(), st.data())
def test_line_of_sight_agrees_with_separating_axes(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    rows, cols = grid.occupied.shape
    quarter = st.tuples(st.integers(0, 4 * rows), st.integers(0, 4 * cols))  # corners, edges too
    a, b = (np.array(data.draw(quarter)) / 4 for _ in range(2))
    framed = np.argwhere(np.pad(grid.occupied, 1, constant_values=True)) - 1.0
    expected = not meets(a[None], b[None], framed, grown=1e-7).any()
    assert bool(LineOfSight(~grid.occupied).is_clear(a, b)) is expected


@FAST
@given(grids(boxes=2), st.integers(0, 999))
def test_a_quick_look_dismisses_no_clear_leg_and_most_others(
    grid: OccupancyGrid, seed: int
) -> None:
    sight, chance = LineOfSight(~grid.occupied), np.random.default_rng(seed)
    a, b = chance.integers(0, 4 * np.array(grid.occupied.shape) + 1, (2, 200, 2)) / 4
    is_clear, may_be_clear = sight.is_clear(a, b), sight.may_be_clear(a, b)
    assert may_be_clear[is_clear].all()
    is_inside = ((a > 0) & (b > 0) & (a < grid.occupied.shape) & (b < grid.occupied.shape)).all(1)
    dismissed = np.count_nonzero(~may_be_clear & is_inside)
    blocked = np.count_nonzero(~is_clear & is_inside)
    assert dismissed >= 0.5 * blocked - 5  # of a few, chance may leave more


@FAST
@given(grids(), st.data())
def test_the_distance_of_a_position_is_that_to_the_nearest_edge(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    position = draw_position(data, grid, np.argwhere(np.ones_like(grid.occupied)).tolist())
    cells = np.argwhere(np.pad(grid.occupied, 1, constant_values=True)) - 1
    point = (np.array(position) - grid.origin) / grid.cell_m
    gaps = np.maximum(np.maximum(cells - point, point - cells - 1), 0)
    nearest_m = np.linalg.norm(gaps, axis=1).min() * grid.cell_m
    assert grid.clearance_m(position) == pytest.approx(nearest_m, abs=1e-9)
    assert grid.distance_m[grid.cell(position)] <= nearest_m + 1e-9
    for distance_m in (0.0, data.draw(st.floats(0, 2 * nearest_m + 1)), nearest_m + 1e-6):
        assert grid.is_within(position, distance_m) is (grid.clearance_m(position) < distance_m)


@FAST
@given(grids(edge=24), st.floats(0.5, 4.0), st.data())
def test_added_clearance_is_kept_where_there_is_room_and_closes_no_way(
    grid: OccupancyGrid, added: float, data: st.DataObject
) -> None:
    """A route exists exactly if one does without; with room it keeps all of it, or a large part."""
    least_m = grid.cell_m
    free = np.argwhere(brute_force_distance(grid) >= least_m).tolist()
    assume(free)
    start, goal = draw_position(data, grid, free), draw_position(data, grid, free)
    places = {"goal": PlaceRegion((*goal, -2.0), Disc(0.5), True)}
    routes = RouteMap(grid, places, WIDE, least_m)
    plain = routes.route((*start, -1.0), "goal")
    added_m = added * grid.cell_m
    routes.add_clearance(added_m)
    wide = routes.route((*start, -1.0), "goal")
    assert (wide is None) == (plain is None)
    if wide is None:
        return
    assert routes.is_clear(wide.waypoints)
    room = brute_force_distance(grid) >= least_m + added_m
    parts = ndimage.label(room)[0]
    if room[grid.cell(start)] and parts[grid.cell(start)] == parts[grid.cell(goal)]:
        all_of_it_m = RouteMap(grid, places, WIDE, least_m + added_m).distance_m(start, "goal")
        is_detour = all_of_it_m > DETOUR * math.dist(start, goal)
        kept_m = least_m + (ENOUGH_SHARE if is_detour else 1.0) * added_m
        for a, b in pairwise(wide.waypoints[:, :2]):
            for point in np.linspace(a, b, 20):
                assert grid.clearance_m((point[0], point[1])) >= kept_m - 1e-6


@FAST
@given(grids(edge=40, boxes=6), st.floats(2.0, 6.0), st.floats(0.5, 8.0))
def test_the_middles_of_passages_connect_what_its_free_cells_connect(
    grid: OccupancyGrid, least: float, added: float
) -> None:
    """Of two parts with all the clearance, wherever the way between them has less."""
    away, full = grid.distance_m / grid.cell_m, least + added
    middles, is_wide = passages(grid, 2 * least * grid.cell_m), ~grid.occupied & (away >= full)
    wide, count = ndimage.label(is_wide)
    first = [tuple(np.argwhere(wide == part)[0]) for part in range(1, count + 1)]
    for clearance in np.linspace(least, full, 4):
        is_free = ~grid.occupied & (away >= clearance)
        everywhere = ndimage.label(is_free)[0]
        in_passages = ndimage.label(is_wide | (middles & is_free))[0]
        for a, b in pairwise(first):
            is_same = everywhere[a] == everywhere[b]
            assert (in_passages[a] == in_passages[b]) == is_same


@FAST
@given(st.integers(0, 999))
def test_regions_around_a_path_are_all_that_its_legs_can_enter(seed: int) -> None:
    chance = np.random.default_rng(seed)
    names = tuple("ABCDEFGH")
    regions = Regions(names, chance.uniform(-20, 20, (8, 2)), chance.uniform(0.1, 6, 8))
    points = chance.uniform(-9, 9, (5, 2))
    around = regions.around(points)
    a, b = points[:, None], points[None]
    assert np.array_equal(around.are_entered(a, b), regions.are_entered(a, b))


@FAST
@given(grids(), st.sampled_from([0.0, 1.0, 1.4]), st.data())
def test_legs_keep_the_clearance_and_exist_where_cells_connect(
    grid: OccupancyGrid, clearance: float, data: st.DataObject
) -> None:
    clearance_m = clearance * grid.cell_m
    is_free = (brute_force_distance(grid) >= clearance_m) & ~grid.occupied
    assume(is_free.any())
    free = np.argwhere(is_free).tolist()
    start, goal = draw_position(data, grid, free), draw_position(data, grid, free)
    routes = RouteMap(
        grid, {"goal": PlaceRegion((*goal, -2.0), Disc(0.5), True)}, WIDE, clearance_m
    )
    route = routes.route((*start, -1.0), "goal")
    parts = ndimage.label(is_free)[0]
    if parts[grid.cell(start)] != parts[grid.cell(goal)]:
        assert route is None and routes.distance_m(start, "goal") == math.inf
        return
    assert route is not None
    assert route.waypoints[0].tolist() == [*start, -1.0]
    assert route.waypoints[-1].tolist() == [*goal, -2.0]
    points = (route.waypoints[:, :2] - grid.origin) / grid.cell_m
    not_free = np.argwhere(~np.pad(is_free, 1)) - 1.0
    assert not meets(points[:-1], points[1:], not_free, grown=-1e-6).any()
    for a, b in pairwise(points):
        for point in np.linspace(a, b, 50) * grid.cell_m + grid.origin:
            assert grid.clearance_m((point[0], point[1])) >= clearance_m - 1e-6


@drawn(25)
@given(grids(edge=14), st.data())
def test_lengths_are_close_to_the_optimum_of_a_visibility_graph(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    is_free = grid.distance_m >= 2 * grid.cell_m
    free = np.argwhere(is_free)
    assume(len(free) > 1)
    centres = free + 0.5
    first, second = np.triu_indices(len(free), 1)
    not_free = np.argwhere(~is_free).astype(np.float64)
    clear = np.concatenate(
        [
            ~meets(centres[i], centres[j], not_free, grown=1e-7).any(axis=1)
            for i, j in zip(np.array_split(first, 20), np.array_split(second, 20), strict=True)
        ]
    )
    lengths = np.linalg.norm(centres[first] - centres[second], axis=1) * grid.cell_m
    visible = nx.Graph()
    visible.add_nodes_from(range(len(free)))
    visible.add_weighted_edges_from(
        zip(first[clear].tolist(), second[clear].tolist(), lengths[clear].tolist(), strict=True)
    )
    goal = data.draw(st.integers(0, len(free) - 1))
    place = PlaceRegion((*grid.centre(*free[goal].tolist()), 0.0), Disc(0.0), False)
    routes = RouteMap(grid, {"goal": place}, WIDE, 2 * grid.cell_m)
    optimum = nx.single_source_dijkstra_path_length(visible, goal)
    for i, cell in list(enumerate(free.tolist()))[::5]:
        start = grid.centre(*cell)
        route = routes.route((*start, 0.0), "goal")
        assert (route is not None) == (i in optimum)
        if route is not None:
            assert Path(route).length_m <= 1.25 * optimum[i] + 1e-9  # corners may be moved outwards
            assert routes.distance_m(start, "goal") <= 1.03 * optimum[i] + 1e-9
            assert routes.distance_m(start, "goal") >= optimum[i] - 1e-9


@FAST
@given(grids(boxes=3), st.data())
def test_no_route_enters_the_region_of_another_place(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    free = np.argwhere(~grid.occupied).tolist()
    assume(free)
    start = draw_position(data, grid, free)
    radius = st.floats(0.1, 4.0).map(lambda cells: cells * grid.cell_m)
    places = {
        name: PlaceRegion((*draw_position(data, grid, free), 0.0), Disc(data.draw(radius)), True)
        for name in ("goal", "X", "Y")
    }
    route = RouteMap(grid, places, WIDE, grid.cell_m).route((*start, 0.0), "goal")
    assume(route is not None)
    assert route is not None
    for name in ("X", "Y"):
        centre, radius_m = (
            np.array(places[name].position[:2]),
            places[name].region.inner_m((0, 0, 0)),
        )
        legs = list(pairwise(route.waypoints[:, :2]))
        outside = [i for i, (a, _) in enumerate(legs) if np.linalg.norm(a - centre) >= radius_m]
        for a, b in legs[outside[0] :] if outside else []:  # once outside, outside for good
            assert distance_to_leg(a, b, centre) >= radius_m - 1e-9


@FAST
@given(grids(edge=30, boxes=3), st.data())
def test_routes_do_not_depend_on_what_the_map_was_before(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    cells = np.argwhere(np.ones_like(grid.occupied)).tolist()
    names = ("A", "B", "X")
    radius = st.floats(0.1, 3.0).map(lambda cells: cells * grid.cell_m)
    places = {
        name: PlaceRegion((*draw_position(data, grid, cells), 0.0), Disc(data.draw(radius)), True)
        for name in names
    }
    start = draw_position(data, grid, cells)
    routes = RouteMap(grid, places, WIDE, grid.cell_m)
    for _ in range(data.draw(st.integers(1, 4))):
        routes.distance_m(start, data.draw(st.sampled_from(names)))
        occupied = grid.occupied.copy()
        row, col = data.draw(st.sampled_from(cells))
        height, width = data.draw(st.sampled_from([(1, 1), (4, 4), (30, 1), (30, 15)]))
        occupied[row : row + height, col : col + width] = data.draw(st.booleans())
        grid = OccupancyGrid(occupied, grid.cell_m, grid.origin)
        routes.see(grid)
    new = RouteMap(grid, places, WIDE, grid.cell_m)
    for name in names:
        assert routes.distance_m(start, name) == pytest.approx(new.distance_m(start, name))
        route, expected = (each.route((*start, 0.0), name) for each in (routes, new))
        assert (route is None) == (expected is None)
        if route is not None and expected is not None:
            np.testing.assert_allclose(route.waypoints, expected.waypoints, rtol=0, atol=1e-9)


@FAST
@given(grids(), st.data())
def test_a_start_beside_the_free_cells_is_left_across_no_obstacle(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    is_free = grid.distance_m >= 2.5 * grid.cell_m
    band = np.argwhere(~is_free & ~grid.occupied).tolist()
    assume(is_free.any() and band)
    start = draw_position(data, grid, band)
    goal = draw_position(data, grid, np.argwhere(is_free).tolist())
    routes = RouteMap(
        grid, {"goal": PlaceRegion((*goal, 0.0), Disc(0.5), True)}, WIDE, 2.5 * grid.cell_m
    )
    route = routes.route((*start, 0.0), "goal")
    assume(route is not None)
    assert route is not None
    first = (route.waypoints[:2, :2] - grid.origin) / grid.cell_m
    assert np.linalg.norm(first[1] - first[0]) * grid.cell_m <= ENTRY_M + grid.cell_m
    occupied = np.argwhere(grid.occupied).astype(np.float64)
    assert not meets(first[:1], first[1:], occupied, grown=-1e-6).any()
    assert routes.is_clear(route.waypoints) or not any(
        routes.is_clear(np.vstack([start, grid.centre(*cell)]))
        for cell in np.argwhere(is_free).tolist()
        if math.dist(cell, grid.cell(start)) * grid.cell_m <= ENTRY_M
        and math.isfinite(routes.distance_m(grid.centre(*cell), "goal"))
    )
