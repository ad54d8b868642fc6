"""The figure of a flight: what is in it, and names that can be read."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox
from synthetic import mission

from companion import load_mission
from companion.geometry import NorthEast
from companion.record.backdrop import Backdrop, backdrop_of
from companion.record.figure import draw_flight, figure_of
from companion.record.labels import write_names
from companion.record.trail import Trail

ROOFTOP = Path(__file__).parents[3] / "missions" / "rooftop.yaml"
ROOM = backdrop_of(mission("F at(A)"))
POND: tuple[NorthEast, ...] = ((2.0, 2.0), (2.0, 4.0), (4.0, 4.0))


def flown(plans: int) -> Trail:
    """North, then a step to the east for each plan."""
    trail = Trail()
    for number in range(plans):
        trail.begin(f"replan {number}: {'nobody has answered in time, ' * 3}")
        for north_m in np.arange(0.0, 6.0, 0.1).tolist():
            trail.add((north_m, 0.5 * number, -2.0))
    return trail


def boxes(axis: Axes) -> list[Bbox]:
    """Where words stand in a panel, in pixels."""
    assert isinstance(axis.figure, Figure)
    axis.figure.draw_without_rendering()
    return [text.get_window_extent() for text in axis.texts if text.get_text()]


def overlapping(found: Iterable[Bbox]) -> int:
    return sum(Bbox.intersection(a, b) is not None for a, b in combinations(found, 2))


@pytest.mark.parametrize(
    ("room", "areas"),
    [
        pytest.param(ROOM, [], marks=pytest.mark.long),
        (replace(ROOM, keep_out=(POND,)), ["keep out"]),
    ],
)
def test_the_legend_says_what_is_drawn(room: Backdrop, areas: list[str]) -> None:
    for plans in (1, 2):
        (legend,) = figure_of(room, flown(plans)).legends
        told = [text.get_text() for text in legend.get_texts()]
        way = ["flown with this plan", *["before"] * (plans > 1)]
        ends = ["where it begins", "where it ends"]
        assert told == [*way, *ends, "fence", *areas, "place, its region"]


def test_arrows_lead_where_it_flew() -> None:
    (axis,) = figure_of(ROOM, flown(1)).axes
    arrows = [text for text in axis.texts if not text.get_text()]
    assert arrows
    for arrow in arrows:
        assert isinstance(arrow, Annotation)
        head, tail = arrow.xy, arrow.get_position()
        assert head[0] == tail[0] and head[1] > tail[1]


@pytest.mark.long
def test_long_titles_are_broken_and_stay_in_their_panel() -> None:
    figure = figure_of(ROOM, flown(5))
    figure.draw_without_rendering()
    titles = [axis.title.get_window_extent() for axis in figure.axes]
    assert all("\n" in axis.get_title() for axis in figure.axes)
    assert overlapping(titles) == 0


@pytest.mark.long
def test_a_title_of_two_lines_has_room_above_a_panel_that_is_as_high_as_it_can_be() -> None:
    figure = figure_of(backdrop_of(load_mission(ROOFTOP)), flown(2))
    figure.draw_without_rendering()
    titles = [axis.title.get_window_extent() for axis in figure.axes]
    assert all(title.y1 <= figure.bbox.y1 for title in titles), titles


def panel() -> Axes:
    figure = Figure(figsize=(5.0, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.add_subplot()
    axis.set_xlim(0.0, 10.0)
    axis.set_ylim(0.0, 8.0)
    figure.draw_without_rendering()
    return axis


def test_names_of_places_close_together_do_not_cover_each_other() -> None:
    axis = panel()
    names = {f"Site{n}": (5.0 + 0.3 * n, 4.0 + 0.1 * (n % 2)) for n in range(4)}
    write_names(axis, names)
    assert [text.get_text() for text in axis.texts] == list(names)
    assert overlapping(boxes(axis)) == 0


def test_names_keep_off_the_way_and_inside_the_panel() -> None:
    axis = panel()
    north_east = np.column_stack([np.linspace(5.0, 10.0, 200), np.linspace(4.0, 8.0, 200)])
    axis.plot(*north_east.T)
    write_names(axis, {"Gate": (5.0, 4.0), "Corner": (10.0, 8.0)})
    gate, corner = boxes(axis)
    points = axis.transData.transform(north_east)
    assert not any(gate.contains(x, y) for x, y in points)
    frame = axis.get_window_extent()
    assert frame.x0 <= corner.x0 and corner.x1 <= frame.x1 and corner.y1 <= frame.y1


def test_a_name_beside_a_fence_keeps_off_it_and_near_its_point() -> None:
    axis = panel()
    axis.add_patch(Rectangle((1.0, 1.0), 8.0, 6.0, fill=False))
    write_names(axis, {"Ford": (8.8, 4.0)})
    (name,) = boxes(axis)
    fence = [axis.transData.transform((9.0, north)) for north in np.linspace(1.0, 7.0, 200)]
    assert not any(name.contains(x, y) for x, y in fence)
    x, y = axis.transData.transform((8.8, 4.0))
    assert name.padded(0.1 * axis.figure.dpi).contains(x, y)


@pytest.mark.parametrize(
    ("name", "begins"),
    [
        pytest.param("a.pdf", b"%PDF", marks=pytest.mark.long),
        pytest.param("a.svg", b"<?xml", marks=pytest.mark.long),
        ("a.png", b"\x89PNG"),
    ],
)
def test_equal_flights_give_equal_files(tmp_path: Path, name: str, begins: bytes) -> None:
    files = []
    for _ in range(2):
        draw_flight(ROOM, flown(1), tmp_path / name)
        files.append((tmp_path / name).read_bytes())
    assert files[0] == files[1] and files[0].startswith(begins)


def test_the_words_of_an_svg_are_words(tmp_path: Path) -> None:
    draw_flight(ROOM, flown(1), tmp_path / "flight.svg")
    words = re.findall(r">([^<>]+)</text>", (tmp_path / "flight.svg").read_text())
    assert {"H", "A", "east [m]", "fence"} <= set(words)
