"""One mission as a file, a text and data: the same mission, and mistakes with their places."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML

from companion.documents import read_source
from companion.errors import FormulaError, KeyPath, Location, MissionError
from companion.mission.files import files_of
from companion.mission.loader import load_mission
from companion.mission.model import Mission

AREA = {"east_m": [0, 10], "north_m": [0, 8.5], "cell_m": 0.5}
Data = dict[str, Any]


@pytest.fixture
def data(good: str) -> Data:
    """The good mission as data, with an area in place of its map file."""
    return {**YAML(typ="safe", pure=True).load(good), "map": AREA}


@pytest.fixture
def text(good: str) -> str:
    return good.replace("map: room.yaml", "map: {east_m: [0, 10], north_m: [0, 8.5], cell_m: 0.5}")


def same(a: Mission, b: Mission) -> bool:
    """Whether two missions differ in nothing but their text and their path."""
    grid, other = a.grid, b.grid
    assert (grid.cell_m, grid.origin) == (other.cell_m, other.origin)
    assert np.array_equal(grid.occupied, other.occupied)
    return replace(a, text="", path="", grid=grid) == replace(b, text="", path="", grid=grid)


def test_file_text_and_data_say_the_same(text: str, data: Data, tmp_path: Path) -> None:
    path = tmp_path / "patrol.yaml"
    path.write_text(text, encoding="utf-8")
    of_file = load_mission(path)
    assert of_file.path == str(path)
    assert same(load_mission(str(path)), of_file)
    for given in (text, data):
        mission = load_mission(given)
        assert mission.path == ""
        assert same(mission, of_file)
        assert same(load_mission(mission.text), of_file), "the text can be read again"


def test_names_of_files_are_relative_to_a_folder(
    good: str, data: Data, load: Callable[..., Mission], tmp_path: Path
) -> None:
    of_file = load(good)
    folder = Path(of_file.path).parent
    assert same(load_mission(good, folder), of_file)
    assert same(load_mission({**data, "map": "room.yaml"}, folder), of_file)
    with pytest.raises(MissionError, match=r"^<mission>:4:6: .*room.yaml cannot be read"):
        load_mission(good, tmp_path / "elsewhere")
    with pytest.raises(MissionError, match=r"^map: .*room.yaml cannot be read"):
        load_mission({**data, "map": "room.yaml"}, tmp_path / "elsewhere")


def test_a_text_of_one_line_may_be_json(data: Data) -> None:
    json = load_mission(data).text.replace("\n", "")
    assert same(load_mission(json), load_mission(data))


def test_a_mistake_in_a_text_has_its_line_and_column(text: str) -> None:
    with pytest.raises(FormulaError) as caught:
        load_mission(text.replace("F at(A)", "F at(D)"))
    assert caught.value.where == Location("<mission>", 44, 16)


def changed(data: Any, keys: tuple[str | int, ...], value: Any) -> Any:
    """Data with another value at some keys."""
    if not keys:
        return value
    key, *rest = keys
    copy: Any = dict(data) if isinstance(data, dict) else list(data)
    inner = copy.get(key) if isinstance(copy, dict) else copy[key]
    copy[key] = changed(inner, tuple(rest), value)
    return copy


@pytest.mark.parametrize(
    ("keys", "value", "where", "what"),
    [
        (("task", "search"), "G F at(D)", "task.search", "unknown fact at(D)"),
        (("initially",), ["at(D)"], "initially[0]", "unknown fact at(D)"),
        (("places", "A", "east_m"), "5", "places.A.east_m", "east_m is '5', expected a number"),
        (("limits", "fence", 1), (0, "x"), "limits.fence[1][1]", "expected a number"),
        (("plces",), {}, "plces", "unknown key 'plces'"),
        (("version",), 2, "version", "expected 1"),
        (("skills", "move", "tries"), {1, 2}, "skills.move.tries", "a value of type set"),
        (("sets", "Place", 0), 1 + 2j, "sets.Place[0]", "a value of type complex"),
        (("limits", "speed_mps"), float("nan"), "limits.speed_mps", "nan is not a finite number"),
        (("places",), {1: {}}, "places", "the key 1 is not a text"),
        (("skills", "move", "assumes"), ["found"], "skills.move.assumes[0]", "in events.found"),
    ],
)
def test_a_mistake_in_data_has_its_keys(
    data: Data, keys: tuple[str | int, ...], value: Any, where: str, what: str
) -> None:
    with pytest.raises(MissionError) as caught:
        load_mission(changed(data, keys, value))
    assert isinstance(caught.value.where, KeyPath)
    assert str(caught.value.where) == where
    assert str(caught.value).startswith(f"{where}: ")
    assert what in str(caught.value)


def test_a_missing_key_of_data_is_told(data: Data) -> None:
    del data["limits"]
    with pytest.raises(MissionError, match=r"^top level: the key limits is missing"):
        load_mission(data)


def test_data_may_hold_paths_tuples_and_numbers_of_numpy(data: Data) -> None:
    limits = {"speed_mps": np.float32(2), "up_m": (0.5, 4.0), "fence": data["limits"]["fence"]}
    given = {**data, "limits": limits, "version": np.int64(1)}
    assert same(load_mission(given), load_mission(data))
    with pytest.raises(MissionError, match=r"^map: .*none.yaml cannot be read"):
        load_mission({**data, "map": Path("none.yaml")})


def test_endless_data_are_refused(data: Data) -> None:
    data["task"] = data
    with pytest.raises(MissionError, match="nested deeper than 16 levels"):
        load_mission(data)


# -- an area in place of a map file ----------------------------------------------------------------


def test_walls_are_occupied_and_the_rest_is_free(data: Data) -> None:
    walls = [{"east_m": [0, 1], "north_m": [3, 4]}, {"east_m": [9.75, 12], "north_m": [-1, 0.5]}]
    grid = load_mission({**data, "map": {**AREA, "walls": walls}}).grid
    assert (grid.occupied.shape, grid.cell_m, grid.origin) == ((17, 20), 0.5, (0.0, 0.0))
    rows, cols = np.nonzero(grid.occupied)
    expected = {(6, 0), (6, 1), (7, 0), (7, 1), (0, 19)}
    assert set(zip(rows.tolist(), cols.tolist(), strict=True)) == expected


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"east_m": [10, 0]}, "east_m of the map: 10 to 0 is not a range"),
        ({"north_m": [0, 0]}, "north_m of the map: 0 to 0 is not a range"),
        ({"east_m": [0, 1e4]}, "east_m of the map: 20000 cells are too many"),
        ({"east_m": [-1e308, 1e308]}, "east_m of the map: 1000000000 cells are too many"),
        ({"walls": [{"east_m": [2, 2], "north_m": [0, 1]}]}, "a wall of the map: 2 to 2"),
    ],
)
def test_an_area_that_cannot_be(data: Data, change: Data, what: str) -> None:
    with pytest.raises(MissionError, match=f"^map: {what}") as caught:
        load_mission({**data, "map": {**AREA, **change}})
    assert caught.value.where == KeyPath(("map",))


def test_a_place_in_a_wall_is_refused(data: Data) -> None:
    walls = [{"east_m": [4, 6], "north_m": [6, 8]}]
    with pytest.raises(MissionError, match=r"^places.A: place A is in a wall"):
        load_mission({**data, "map": {**AREA, "walls": walls}})


def test_a_mission_with_an_area_needs_no_other_file(text: str, tmp_path: Path) -> None:
    path = tmp_path / "mission.yaml"
    path.write_text(text, encoding="utf-8")
    assert files_of(path, tmp_path) == (path,)


def test_a_file_that_is_not_there_may_be_misspelt_and_a_folder_is_none(tmp_path: Path) -> None:
    (tmp_path / "first.sim.yaml").touch()
    with pytest.raises(MissionError, match=r"Did you mean first\.sim\.yaml\?"):
        read_source(tmp_path / "frist.sim.yaml", "scenario")
    with pytest.raises(MissionError, match="is a folder: name a file in it"):
        read_source(tmp_path, "mission")
