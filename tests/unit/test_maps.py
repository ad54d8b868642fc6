"""Map files: the meaning of grey values and axes, and what each mistake is answered with."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from companion.drawn_maps import MapEntry, drawn_map
from companion.errors import Location, MissionError
from companion.maps import MAX_CELLS, read_map

ROOT = Path(__file__).resolve().parents[2]

FIELDS = {
    "image": "map.png",
    "resolution": "0.5",
    "origin": "[-2.0, -1.0, 0.0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}
FREE, UNKNOWN, OCCUPIED = 254, 205, 0  # as ROS map_saver writes them


def write_map(folder: Path, pixels: list[list[int]], **changes: str | None) -> Path:
    """A map of grey pixels, with some of its fields changed, or left out where None."""
    fields = {key: value for key, value in (FIELDS | changes).items() if value is not None}
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(folder / "map.png")
    path = folder / "map.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in fields.items()))
    return path


def test_top_row_of_the_image_is_north_and_columns_go_east(tmp_path: Path) -> None:
    grid = read_map(write_map(tmp_path, [[FREE, FREE, OCCUPIED], [FREE, FREE, FREE]]))
    assert grid.occupied.tolist() == [[False, False, False], [False, False, True]]
    assert grid.cell((-0.75, -0.75)) == (0, 2)  # half a cell from the south-east corner
    assert grid.origin == (-1.0, -2.0)  # north, east
    assert grid.cell_m == 0.5


@pytest.mark.parametrize(
    ("negate", "is_occupied"), [("0", [False, True, True]), ("1", [True, True, False])]
)
def test_only_pixels_below_the_free_threshold_are_free(
    tmp_path: Path, negate: str, is_occupied: list[bool]
) -> None:
    grid = read_map(write_map(tmp_path, [[FREE, UNKNOWN, OCCUPIED]], negate=negate))
    assert grid.occupied.tolist() == [is_occupied]


def test_free_threshold_is_exclusive_and_a_share_of_255(tmp_path: Path) -> None:
    grid = read_map(write_map(tmp_path, [[204, 205]], free_thresh="0.2"))  # 51/255, 50/255
    assert grid.occupied.tolist() == [[True, False]]


def test_transparent_pixels_are_unknown(tmp_path: Path) -> None:
    path = write_map(tmp_path, [[FREE]])
    Image.new("RGBA", (2, 1), (254, 254, 254, 255)).save(tmp_path / "map.png")
    assert read_map(path).occupied.tolist() == [[False, False]]
    Image.new("RGBA", (2, 1), (254, 254, 254, 128)).save(tmp_path / "map.png")
    assert read_map(path).occupied.tolist() == [[True, True]]


def test_text_pgm_and_explicit_mode_are_read(tmp_path: Path) -> None:
    path = write_map(tmp_path, [[FREE]], image="map.pgm", mode="trinary", extra="ignored")
    (tmp_path / "map.pgm").write_text("P2\n# a comment\n2 1\n255\n0 254\n")
    assert read_map(path).occupied.tolist() == [[True, False]]


@pytest.mark.parametrize(
    ("changes", "what", "line"),
    [
        ({"image": None}, "no `image`", 1),
        ({"image": "[1]"}, "not a file name", 1),
        ({"image": "absent.pgm"}, "there is no image", 1),
        ({"image": "x" * 5000}, "cannot be read", 1),
        ({"image": "map.yaml"}, "not a usable PGM or PNG", 1),
        ({"resolution": "0"}, "resolution is 0", 2),
        ({"resolution": ".nan"}, "resolution is nan", 2),
        ({"resolution": "true"}, "resolution is True", 2),
        ({"resolution": "9" * 400}, "resolution is 9", 2),
        ({"resolution": "five"}, "resolution is 'five'", 2),
        ({"origin": "[0, 0]"}, "three numbers", 3),
        ({"origin": "[0, .inf, 0]"}, "three numbers", 3),
        ({"origin": "[0, 0, 0.1]"}, "rotated by 0.1 rad", 3),
        ({"negate": "2"}, "neither 0 nor 1", 4),
        ({"occupied_thresh": "1.5"}, "occupied_thresh is 1.5", 5),
        ({"free_thresh": "0.7"}, "greater than occupied_thresh", 6),
        ({"mode": "scale"}, "not trinary", 7),
        ({"mode": "[unclosed"}, "no YAML", 8),
    ],
)
def test_a_mistake_is_reported_at_its_line(
    tmp_path: Path, changes: dict[str, str | None], what: str, line: int
) -> None:
    path = write_map(tmp_path, [[FREE]], **changes)
    with pytest.raises(MissionError, match=what) as caught:
        read_map(path)
    where = caught.value.where
    assert isinstance(where, Location)
    assert (where.path, where.line) == (str(path), line)


@pytest.mark.parametrize(
    "text", [b"", b"- 1", b"just words", b"\xff\xfe\x00", b"[" * 1000, b"a: 1\n" * 20_000]
)
def test_a_file_that_is_no_map_is_refused(tmp_path: Path, text: bytes) -> None:
    path = tmp_path / "map.yaml"
    path.write_bytes(text)
    with pytest.raises(MissionError):
        read_map(path)
    with pytest.raises(MissionError, match="cannot be read"):
        read_map(tmp_path / "absent.yaml")


def test_a_huge_image_is_refused_before_it_is_decoded(tmp_path: Path) -> None:
    path = write_map(tmp_path, [[FREE]], image="map.pgm")
    (tmp_path / "map.pgm").write_bytes(b"P5\n4001 1\n255\n")  # a head without pixels
    with pytest.raises(MissionError, match="4001 x 1 cells"):
        read_map(path)
    (tmp_path / "map.pgm").write_bytes(b"P5\n2001 2000\n255\n")
    with pytest.raises(MissionError, match=r"map.yaml:\d+:\d+: the map has 2001 x 2000 cells"):
        read_map(path)
    with pytest.raises(MissionError, match="the map has 2001 x 2000 cells"):
        drawn_map(MapEntry(east_m=(0.0, 200.1), north_m=(0.0, 200.0)), ())
    whole = MapEntry(east_m=(0.0, 200.0), north_m=(0.0, 200.0))
    assert drawn_map(whole, ()).occupied.size == MAX_CELLS


@pytest.mark.parametrize("pixels", [b"P5\n4 4\n255\n\0", b"P5\n1 1\n65535\n\0\0", b"\x89PNG\r\n"])
def test_a_broken_or_deep_image_is_refused(tmp_path: Path, pixels: bytes) -> None:
    path = write_map(tmp_path, [[FREE]])
    (tmp_path / "map.png").write_bytes(pixels)
    with pytest.raises(MissionError):
        read_map(path)


def test_the_checked_in_maps_are_what_their_script_draws(tmp_path: Path) -> None:
    runpy.run_path(str(ROOT / "scripts" / "make_maps.py"))["main"](tmp_path)
    maps = ROOT / "missions" / "maps"
    assert {path.name for path in maps.iterdir()} == {path.name for path in tmp_path.iterdir()}
    for path in tmp_path.iterdir():
        assert (maps / path.name).read_bytes() == path.read_bytes()
