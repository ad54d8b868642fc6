"""The commands between missions and the files of other programs, as a user meets them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from commands import Companion
from plan_files import HOME, RETURN, TAKE_OFF, at, item, plan, waypoint

from companion import load_mission

SURVEILLANCE = Path(__file__).parents[1] / "missions" / "surveillance.yaml"
IMPORT = "companion import field.plan -o field.yaml"
EXPORTS = (
    "companion export field.yaml -o field.geojson",
    "companion export field.yaml -o shown.plan",
)
WAY = (TAKE_OFF, waypoint(30, 0), item(2000, 0, 0, 1, frame=2), waypoint(30, 40), RETURN)


@pytest.fixture
def field(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a plan in it, in which commands are given."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "field.plan").write_text(json.dumps(plan(*WAY)), encoding="utf-8")
    return tmp_path


def test_import_tells_what_it_has_made(field: Path, companion: Companion) -> None:
    ended = companion(*IMPORT.split()[1:], "--leave-out", "3")
    assert ended.code == 0, ended.err
    assert ended.out.splitlines() == [
        "places     Home W2 W4",
        "distances  70 m along the route, 50 m back to Home; up to 50 m from Home",
        "altitudes  20 to 20 m above home",
        "task       route: ordered_visit(W2, W4)",
        "task       home: F G at(Home)",
        "notice     item 3: IMAGE_START_CAPTURE (2000) left out, as asked",
        "notice     a plan of QGroundControl has no fence; the box 20 m around all places is one: "
        "make it as large as the vehicle may fly",
        "notice     no speed is given; 5 m/s is written",
        "written    field.yaml",
    ]
    text = (field / "field.yaml").read_text(encoding="utf-8")
    assert all(line[11:] in text for line in ended.out.splitlines() if line.startswith("notice"))
    assert list(load_mission(field / "field.yaml").places) == ["Home", "W2", "W4"]


@pytest.mark.parametrize(
    ("items", "rally", "said"),
    [
        (
            (waypoint(30, 0), waypoint(30, 40), RETURN),
            (),
            "70 m along the route, 50 m back to Home",
        ),
        ((waypoint(30, 0), waypoint(30, 40), RETURN), ((0, -60),), "70 m along the route, 50 m"),
        ((waypoint(30, 0), waypoint(0, 0), waypoint(30, 0)), (), "90 m along the route, 30 m back"),
        ((waypoint(30, 0), item(21, 0, 0, 0, None, *at(30, 40))), (), "70 m along the route; up"),
        ((waypoint(30, 0), waypoint(0, 0), RETURN), (), "30 m along the route, 30 m back to Home"),
        (
            (waypoint(30, 0), waypoint(30, 40), item(177, 2, -1, frame=2)),
            (),
            "up to 50 m from Home",
        ),
        ((RETURN,), (), "up to 0 m from Home"),
    ],
)
def test_the_route_is_as_long_as_what_is_flown(
    items: Any, rally: Any, said: str, field: Path, companion: Companion
) -> None:
    content = plan(TAKE_OFF, *items, rally=[[*at(*point), 20] for point in rally])
    (field / "field.plan").write_text(json.dumps(content), encoding="utf-8")
    ended = companion(*IMPORT.split()[1:])
    assert f"distances  {said}" in ended.out, ended


def test_points_in_any_order_make_no_route_of_a_known_length(
    field: Path, companion: Companion
) -> None:
    coordinates = [list(reversed(at(*point))) for point in ((30, 0), (30, 40))]
    (field / "map.geojson").write_text(
        json.dumps({"type": "MultiPoint", "coordinates": coordinates})
    )
    home = ",".join(map(str, HOME))
    ended = companion("import", "map.geojson", "-o", "x.yaml", "--up-m", "9", "--home", home)
    assert "distances  up to 50 m from Home\n" in ended.out, ended


def test_a_refusal_names_the_item_and_writes_nothing(field: Path, companion: Companion) -> None:
    ended = companion(*IMPORT.split()[1:])
    assert ended.code == 2 and ended.out == ""
    assert ended.err.startswith("field.plan: item 3: IMAGE_START_CAPTURE (2000) is for a payload")
    assert not (field / "field.yaml").exists()


def test_what_somebody_has_edited_is_not_written_over(field: Path, companion: Companion) -> None:
    (field / "field.yaml").write_text("mine\n", encoding="utf-8")
    ended = companion(*IMPORT.split()[1:], "--payload", "100")
    assert ended.code == 2 and "field.yaml is there already" in ended.err
    assert (field / "field.yaml").read_text(encoding="utf-8") == "mine\n"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("zones.shp", "zones.shp: is a shapefile; save it as GeoJSON"),
        ("track.gpx", "track.gpx: is a GPS track"),
        ("field.xyz", "field.xyz: is of an unknown kind '.xyz'"),
        ("none.plan", "the plan none.plan cannot be read: No such file or directory"),
    ],
)
def test_other_files_are_refused_by_name(
    name: str, said: str, field: Path, companion: Companion
) -> None:
    if not name.startswith("none"):
        (field / name).write_bytes(b"\x00\x00\x27\x0a")
    ended = companion("import", name, "-o", "field.yaml")
    assert ended.code == 2 and ended.err.startswith(said)


@pytest.mark.parametrize("home", ["47.4", "47.4;8.5", "95,8.5", "47.4,8.5,500,1", "nan,8"])
def test_a_home_that_is_none_is_refused(home: str, field: Path, companion: Companion) -> None:
    assert "--home" in companion("import", "field.plan", "-o", "x.yaml", "--home", home).err


def test_export_writes_what_can_be_imported_again(field: Path, companion: Companion) -> None:
    assert companion(*IMPORT.split()[1:], "--leave-out", "3").code == 0
    for command in EXPORTS:
        name = command.split()[-1]
        ended = companion(*command.split()[1:])
        assert (ended.code, ended.out) == (0, f"written    {name}\n"), ended.err
        assert companion("import", name, "-o", f"{name}.yaml").code == 0
        again = load_mission(field / f"{name}.yaml")
        assert again.limits.fence and len(again.places) == 3


def test_a_mission_in_metres_is_put_on_the_earth(field: Path, companion: Companion) -> None:
    refused = companion("export", SURVEILLANCE, "-o", "hall.geojson")
    assert refused.code == 2 and "--home LAT,LON" in refused.err
    home = ("--home", "47.4,8.5,450")
    assert companion("export", SURVEILLANCE, "-o", "hall.geojson", *home).code == 0
    assert companion("export", SURVEILLANCE, "-o", "hall.plan", *home).code == 0
    mission = json.loads((field / "hall.plan").read_text(encoding="utf-8"))["mission"]
    assert mission["plannedHomePosition"] == pytest.approx([47.4, 8.5, 450])
    assert [entry["command"] for entry in mission["items"]][-1] == 177


def test_without_a_plan_the_world_is_exported_and_it_is_said(
    field: Path, companion: Companion
) -> None:
    by_hand = SURVEILLANCE.with_name("by_hand.yaml")
    ended = companion("export", by_hand, "-o", "hall.geojson", "--home", "47.4,8.5")
    assert ended.code == 0 and "no plan is drawn: the mission has a tree of its own" in ended.out
    assert "/hall.geojson" not in ended.err and (field / "hall.geojson").exists()


def test_other_endings_and_folders_are_refused(field: Path, companion: Companion) -> None:
    assert "neither .plan nor .geojson" in companion("export", SURVEILLANCE, "-o", "x.kml").err
    ended = companion("export", field, "-o", "x.geojson")
    assert ended.code == 2 and "scene.json cannot be read" in ended.err
