"""The key `vary` of a scenario: what its paths mean, and what is told about a mistake."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from companion.documents import Source
from companion.errors import MissionError
from sitl.world.distributions import Chance, Choice, Normal, Uniform
from sitl.world.scenario import Scenario, parse_scenario
from sitl.world.varied_scenario import read_varied
from sitl.world.vary import Factor, with_values

WORLD = """\
version: 1
map: maps/hall.yaml
wind: {{east_mps: 1}}
payload:
  command: MAV_CMD_USER_1
  answers: [{{east_m: 9, north_m: 4, radius_m: 1, result: FAILED}}]
obstacles:
  - {{name: crate, circle: {{east_m: 6, north_m: 6, radius_m: 0.5}}}}
  - {{name: shed, box: {{east_m: [1, 2], north_m: [8, 9]}}, present: false}}
happens:
  - {{at_s: 30, obstacle: {{name: shed, present: true}}}}
  - {{at_s: 40, link: {{loss: 0.1}}}}
vary: {{{vary}}}
"""
DATA: dict[str, Any] = {
    "wind": {"east_mps": 1},
    "obstacles": [{"name": "crate", "circle": {"east_m": 6}}, {"name": "shed"}],
    "happens": [{"at_s": 1}, {"at_s": 2}, {"at_s": 3}],
    "vary": {},
}


def parse(vary: str) -> Scenario:
    return parse_scenario(WORLD.format(vary=vary), Path("missions/a.sim.yaml"))


def test_all_kinds_of_distributions_are_read() -> None:
    factors = parse(
        "wind.east_mps: [-3, 3], battery.charge: {normal: [0.9, 0.05], within: [0.7, 1]}, "
        "payload.answers.0.result: {choice: [ACCEPTED, FAILED], weights: [3, 1]}, "
        "obstacles.crate.circle.east_m: [1, 9], obstacles.1.box.east_m.0: [0, 1.5], "
        "happens.1: {chance: 0.3}, happens.1.link.loss: [0, 0.4]"
    ).factors
    assert [factor.distribution for factor in factors] == [
        Uniform(-3, 3),
        Normal(0.9, 0.05, 0.7, 1),
        Choice(("ACCEPTED", "FAILED"), (3, 1)),
        Uniform(1, 9),
        Uniform(0, 1.5),
        Chance(0.3),
        Uniform(0, 0.4),
    ]
    assert [factor.usual for factor in factors] == [1, None, "FAILED", 6, 1, None, 0.1]
    assert [factor.is_entry for factor in factors] == [False] * 5 + [True, False]


@pytest.mark.parametrize(
    ("vary", "told"),
    [
        ("wind.east_mps: [3, -3]", "empty range"),
        ("wind.east_mps: [-3, 40]", "wind.east_mps cannot be 40.0: east_mps is 40.0"),
        ("wind.esat_mps: [-3, 3]", "unknown key 'esat_mps' in wind"),
        ("obstacles.crat.circle.east_m: [1, 2]", "no entry crat"),
        ("happens.2.at_s: [1, 2]", "no entry 2"),
        ("obstacles.crate: [1, 2]", "not a single value"),
        ("wind: {chance: 0.5}", "not a single value"),
        ("wind.east_mps.more: [1, 2]", "leads into a value"),
        (
            "happens.1.at_s: [1, 2], happens.01.at_s: [1, 2]",
            "happens.01.at_s and happens.1.at_s are one key",
        ),
        ("happens.2.at_s: [1, 2]", "numbered from 0 to 1"),
        ("wind.east_mps.more: [1, 2]", "write wind.east_mps"),
        ("wind.east_mps: 3", "or [least, greatest] alone"),
        ("wind.east_mps: {choice: [[1, 2]]}", "entry 1 in vary.wind.east_mps.choice is a list"),
        ("obstacles.1: {chance: 0.5}", "obstacles.1 cannot be left out: there is no obstacle shed"),
        ("payload.answers.0.result: {choice: [ACEPTED]}", "cannot be ACEPTED"),
        ("battery.charge: {choice: [1, 0.5], weights: [1]}", "weights"),
        ("battery.charge: {normal: [0.5, 0]}", "no values"),
        ("battery.charge: {chance: 1.5}", "at most 1"),
        ("map: {choice: [maps/hall.yaml, maps/rooms.yaml]}", "fly a campaign for each map"),
        ("vehicle: {choice: [quad_35cm]}", "write vehicle: {profile: NAME}, and "),
        ("map.cell_m: [0.1, 0.2]", "fly a campaign for each map"),
        ("vehicle.profile: {choice: [quad_35cm]}", "names a file, and cannot be varied"),
    ],
)
def test_a_mistake_is_told_with_its_place(vary: str, told: str) -> None:
    with pytest.raises(MissionError) as error:
        parse(vary)
    assert told in str(error.value)
    assert str(error.value).startswith("missions/a.sim.yaml:13:")


def test_values_are_put_where_their_paths_lead() -> None:
    paths = (
        "wind.east_mps: [-3, 3], battery.charge: [0.5, 1], happens.1: {chance: 0.3}, "
        "happens.0: {chance: 0.3}, obstacles.crate.circle.radius_m: [0.1, 1]"
    )
    factors = parse(paths).factors
    values = {
        "wind.east_mps": 2.5,
        "battery.charge": 0.75,
        "happens.1": False,
        "happens.0": True,
        "obstacles.crate.circle.radius_m": 0.25,
    }
    varied = with_values(DATA, factors, values)
    assert varied == {
        "wind": {"east_mps": 2.5},
        "battery": {"charge": 0.75},
        "obstacles": [
            {"name": "crate", "circle": {"east_m": 6, "radius_m": 0.25}},
            {"name": "shed"},
        ],
        "happens": [{"at_s": 1}, {"at_s": 3}],
    }
    assert DATA["wind"] == {"east_mps": 1} and len(DATA["happens"]) == 3
    assert with_values(DATA, factors, {"happens.0": False, "happens.1": False})["happens"] == [
        {"at_s": 3}
    ]


def test_entries_within_entries_that_are_left_out_are_those_that_were_meant() -> None:
    here, there = ({"east_m": east, "north_m": 0, "radius_m": 1} for east in (1, 2))
    world = {"cameras": [{"fails": [here]}, {"fails": [here, there]}]}
    paths = ("cameras.0", "cameras.0.fails.0", "cameras.1.fails.0")
    steps = [("cameras", 0), ("cameras", 0, "fails", 0), ("cameras", 1, "fails", 0)]
    factors = [
        Factor(path, keys, Chance(0.5), None, is_entry=True)
        for path, keys in zip(paths, steps, strict=True)
    ]
    assert with_values(world, factors, dict.fromkeys(paths, False)) == {
        "cameras": [{"fails": [there]}]
    }


def test_a_scenario_is_flown_as_it_stands_whatever_varies() -> None:
    plain, varied = parse(""), parse("wind.east_mps: [-3, 3]")
    assert varied.wind == plain.wind and varied.events == plain.events


@pytest.mark.parametrize(
    ("vary", "hint"),
    [
        ("cameras.0.capacity: [1, 5]", "write {choice: [1, 2, 3, 4, 5]}"),
        ("cameras.0.capacity: {normal: [5, 0.5]}", "write {choice: [3, 4, 5, 6, 7]}"),
        ("cameras.0.capacity: [0, 1000]", "write {choice: [0, 111, 222, 333, 444, "),
        ("battery.charge: [0, 5]", "state of charge, 0 to 1"),
    ],
)
def test_a_range_of_a_key_of_whole_numbers_is_answered_with_a_choice(vary: str, hint: str) -> None:
    text = f"version: 1\ncameras: [{{component: 100}}]\nvary: {{{vary}}}"
    with pytest.raises(MissionError) as error:
        parse_scenario(text, Path("a.sim.yaml"))
    assert hint in error.value.hint


@pytest.mark.parametrize(
    ("path", "missing"),
    [
        ("happens.0.at_s", "happens"),
        ("obstacles.crate.circle.east_m", "obstacles"),
        ("payload.answers.0.after_s", "payload.answers"),
    ],
)
def test_an_entry_of_a_list_that_is_not_there_is_told_so(path: str, missing: str) -> None:
    with pytest.raises(MissionError) as error:
        parse_scenario(f"version: 1\nvary: {{{path}: [0, 5]}}", Path("a.sim.yaml"))
    assert error.value.what == f"{path}: the file has no {missing}"
    assert error.value.hint == "an entry of a list has to be there to be varied"


@pytest.mark.parametrize(
    ("path", "ends", "told"),
    [
        ("map.walls.0.east_m.0", [2, 6], "cannot be 6.0: a wall of the map: 6 to 5 is not a range"),
        ("map.cell_m", [0.0002, 1], "cannot be 0.0002: "),
        (
            "obstacles.0.circle.east_m",
            [0, 10000],
            "cannot be 10000.0: east_m of the map: 10007 ",
        ),
    ],
)
def test_the_map_is_drawn_at_the_ends_of_what_varies(
    path: str, ends: list[float], told: str
) -> None:
    walls = [{"east_m": [4, 5], "north_m": [-3, -2]}]
    crate = {"name": "crate", "circle": {"east_m": 5, "north_m": 9, "radius_m": 1}}
    world = {"version": 1, "map": {"walls": walls}, "obstacles": [crate], "vary": {path: ends}}
    with pytest.raises(MissionError) as error:
        read_varied(Source(world, "scenario", Path(), None))
    assert told in str(error.value)


def test_the_vehicle_in_the_file_of_a_row_is_that_of_the_row() -> None:
    vehicle = {"profile": "quad_35cm", "radius_m": 0.4}
    world = {"version": 1, "vehicle": vehicle, "vary": {"vehicle.radius_m": [0.2, 0.6]}}
    varied = read_varied(Source(world, "scenario", Path(), None))
    values = {"vehicle.radius_m": 0.25}
    assert varied.world(values)[0].vehicle.radius_m == 0.25
    assert varied.data_with(values)["vehicle"]["radius_m"] == 0.25


def test_the_field_of_obstacles_is_drawn_where_each_row_has_them() -> None:
    crate = {"name": "crate", "circle": {"east_m": 5, "north_m": 9, "radius_m": 1}}
    world = {
        "version": 1,
        "obstacles": [crate],
        "vary": {"obstacles.crate.circle.east_m": [5, 500], "obstacles.0": {"chance": 0.5}},
    }
    varied = read_varied(Source(world, "scenario", Path(), None))
    _, far = varied.world({"obstacles.crate.circle.east_m": 400.0})
    assert far is not None
    assert far.contains(*far.cell((9.0, 400.0)))
    scenario, _ = varied.world({"obstacles.0": False})
    assert scenario.obstacles == ()
