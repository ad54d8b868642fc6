"""Vehicle profiles: the shipped one, overrides, and mistakes in them."""

import json
from dataclasses import asdict, fields
from pathlib import Path

import pytest

from companion.errors import MissionError
from companion.mission.files import files_of
from companion.mission.loader import load_mission
from companion.vehicle_files import json_schema, read_profile
from companion.vehicle_profile import DEFAULT_VEHICLE, VehicleProfile

MISSIONS = Path(__file__).parents[2] / "missions"
QUAD = VehicleProfile()
VALUES = {name: value for name, value in asdict(QUAD).items() if name != "name"}


def profile_text(**values: object) -> str:
    """A file with a line for each key."""
    return "".join(f"{key}: {value}\n" for key, value in {"version": 1, **VALUES, **values}.items())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Missions with the map of surveillance, without any vehicle profile."""
    (tmp_path / "maps").mkdir()
    for name in ("hall.yaml", "hall.pgm"):
        (tmp_path / "maps" / name).write_bytes((MISSIONS / "maps" / name).read_bytes())
    (tmp_path / "vehicles").mkdir()
    return tmp_path


def write_mission(folder: Path, vehicle: str | None) -> Path:
    text = (MISSIONS / "surveillance.yaml").read_text()
    line = "" if vehicle is None else f"vehicle: {vehicle}\n"
    path = folder / "patrol.yaml"
    path.write_text(text.replace("limits:", f"{line}limits:", 1))
    return path


def test_the_shipped_profile_is_the_built_in_one() -> None:
    path = MISSIONS / "vehicles" / f"{DEFAULT_VEHICLE}.yaml"
    assert read_profile(path) == QUAD
    first = path.read_text().splitlines()[0]
    assert first == "# yaml-language-server: $schema=../vehicle.schema.json"


def test_checked_in_schema_is_the_generated_one() -> None:
    """If this fails: python scripts/make_schema.py."""
    schema = json_schema()
    assert json.loads((MISSIONS / "vehicle.schema.json").read_text()) == schema
    optional = {"response_s", "feed_forward", "yaw_rate_radps"}
    assert list(schema["required"]) == ["version", *(v for v in VALUES if v not in optional)]
    assert all(part.get("description") for part in schema["properties"].values())


@pytest.mark.parametrize("vehicle", [None, "quad_35cm", "{}", "{profile: quad_35cm}"])
def test_the_default_profile_needs_no_file(folder: Path, vehicle: str | None) -> None:
    mission = write_mission(folder, vehicle)
    assert load_mission(mission).vehicle == QUAD
    assert folder / "vehicles" / "quad_35cm.yaml" not in files_of(mission, folder)


@pytest.mark.parametrize("vehicle", [None, "quad_35cm"])
def test_a_file_of_the_default_profile_counts(folder: Path, vehicle: str | None) -> None:
    profile = folder / "vehicles" / "quad_35cm.yaml"
    profile.write_text(profile_text(radius_m=0.2))
    mission = write_mission(folder, vehicle)
    assert load_mission(mission).vehicle == VehicleProfile(radius_m=0.2)
    assert profile in files_of(mission, folder)


def test_a_mission_names_another_profile_and_needs_its_file(folder: Path) -> None:
    profile = folder / "vehicles" / "small.yaml"
    profile.write_text(profile_text(radius_m=0.1, speed_mps=1.5))
    mission = write_mission(folder, "small")
    loaded = load_mission(mission)
    assert loaded.vehicle == VehicleProfile("small", radius_m=0.1, speed_mps=1.5)
    assert loaded.speed_limits.speed_mps == 1.5  # less than the mission's 2.0
    assert profile in files_of(mission, folder)


@pytest.mark.parametrize("key", [field.name for field in fields(QUAD) if field.name != "name"])
def test_each_value_can_be_overridden(folder: Path, key: str) -> None:
    mission = write_mission(folder, f"{{{key}: 0.3}}")
    assert asdict(load_mission(mission).vehicle) == {**asdict(QUAD), key: 0.3}


def test_a_profile_elsewhere_is_not_uploaded(folder: Path) -> None:
    elsewhere = folder.parent / f"{folder.name}-elsewhere.yaml"
    elsewhere.write_text(profile_text())
    (folder / "vehicles" / "linked.yaml").symlink_to(elsewhere)
    with pytest.raises(MissionError, match="the vehicle linked lies outside"):
        files_of(write_mission(folder, "linked"), folder)


@pytest.mark.parametrize(
    ("vehicle", "place", "part"),
    [
        ("quad_36cm", "13:10", "there is no vehicle profile quad_36cm"),
        ("../quad_35cm", "13:10", "expected letters, digits, - and _"),
        ("7", "13:10", "vehicle is 7, expected keys with values"),
        ("{radius_m: 0}", "13:21", "radius_m is 0, expected more than 0"),
        ("{radius_m: }", "13:11", "radius_m: has no value"),
        ("{radius: 0.4}", "13:11", "Did you mean radius_m?"),
    ],
)
def test_mistakes_in_a_mission_are_placed(
    folder: Path, vehicle: str, place: str, part: str
) -> None:
    path = write_mission(folder, vehicle)
    with pytest.raises(MissionError) as caught:
        load_mission(path)
    assert str(caught.value).startswith(f"{path}:{place}: ")
    assert part in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "place", "part"),
    [
        ({"climb_mps": "fast"}, "6:12", "climb_mps is 'fast', expected a number"),
        ({"version": 2}, "1:10", "version is 2, expected 1"),
        ({"colour": "red"}, "16:1", "unknown key 'colour'"),
    ],
)
def test_mistakes_in_a_profile_are_placed(
    folder: Path, wrong: dict[str, object], place: str, part: str
) -> None:
    profile = folder / "vehicles" / "bad.yaml"
    profile.write_text(profile_text(**wrong))
    with pytest.raises(MissionError) as caught:
        load_mission(write_mission(folder, "bad"))
    assert str(caught.value).startswith(f"{profile}:{place}: ")
    assert part in str(caught.value)


def test_a_profile_has_all_its_values(folder: Path) -> None:
    text = profile_text().replace("radius_m: 0.35\n", "")
    (folder / "vehicles" / "bad.yaml").write_text(text)
    with pytest.raises(MissionError, match="the key radius_m is missing"):
        load_mission(write_mission(folder, "bad"))


def test_a_wide_vehicle_does_not_fit_where_a_narrow_one_does(folder: Path) -> None:
    assert load_mission(write_mission(folder, "{radius_m: 0.5}")).vehicle.clearance_m == 0.75
    with pytest.raises(MissionError, match=r"2\.25 m are needed"):
        load_mission(write_mission(folder, "{radius_m: 2}"))
