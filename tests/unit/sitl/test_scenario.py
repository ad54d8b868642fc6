"""Scenario files: what they mean, and what is told about a mistake."""

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from companion.errors import MissionError
from companion.geometry import GlobalOrigin
from companion.mavlink.framing import dialect
from companion.vehicle_profile import VehicleProfile
from sitl.flight.battery import BatterySpec
from sitl.flight.estimate import Wander
from sitl.results import MavResult
from sitl.world.lidar import LidarSpec
from sitl.world.payload import PayloadAnswer, PayloadScript, PayloadSite
from sitl.world.scenario import PX4_HOME, Scenario, parse_scenario, read_scenario
from sitl.world.scenario_events import ScenarioEvent, VisitTrigger
from sitl.world.visits import Circle

MISSIONS = Path(__file__).parents[3] / "missions"
FULL = """\
version: 1
map: maps/hall.yaml
start: {east_m: 2, north_m: 3, heading_deg: 90}
home: {latitude_deg: 48.0, longitude_deg: 11.0, altitude_m: 500}
wind: {east_mps: 1, north_mps: -2, turbulence_mps: 0.5}
battery: {charge: 0.8}
parameters: {COM_OBL_RC_ACT: 4, MIS_TAKEOFF_ALT: 3.5}
target:
  component: 30
  seen: {east_m: 5, north_m: 13, radius_m: 0.8, visit: 2}
payload:
  command: MAV_CMD_USER_1
  answers:
    - {east_m: 9, north_m: 4, radius_m: 1, result: FAILED, after_s: 2}
  otherwise: ACCEPTED
airframe: px4_sih
wander: {position_m: 0.4}
"""


def parse(text: str) -> Scenario:
    return parse_scenario(text, Path("missions/a.sim.yaml"))


def test_every_key_is_read_into_local_ned() -> None:
    assert parse(FULL) == Scenario(
        home=GlobalOrigin(48.0, 11.0, 500.0),
        start=(3.0, 2.0, -0.0),
        yaw_rad=math.pi / 2,
        airframe="px4_sih",
        wander=Wander(0.4, 0.3),
        wind=(-2.0, 1.0, -0.0),
        turbulence_mps=0.5,
        battery=BatterySpec(0.8),
        parameters={"COM_OBL_RC_ACT": 4, "MIS_TAKEOFF_ALT": 3.5},
        detector=30,
        lidar=LidarSpec(),
        events=(
            ScenarioEvent(
                VisitTrigger(Circle((13.0, 5.0), 0.8), 2), (("target", "seen"),), "target: seen"
            ),
        ),
        payload=PayloadScript(
            25,
            dialect.MAV_CMD_USER_1,
            (PayloadSite((4.0, 9.0), 1.0, PayloadAnswer(MavResult.FAILED, 2.0)),),
            MavResult.ACCEPTED,
        ),
        map=Path("missions/maps/hall.yaml"),
    )


def test_a_version_is_all_it_takes() -> None:
    assert parse("version: 1\n") == Scenario(home=PX4_HOME)


@pytest.mark.parametrize(
    ("right", "wrong", "place", "part"),
    [
        ("charge: 0.8", "charge: 80", "6:19", "charge"),
        ("wind:", "winds:", "5:1", "winds"),
        ("COM_OBL_RC_ACT: 4", "COM_OBL_RC_AKT: 4", "7:14", "COM_OBL_RC_ACT"),
        ("COM_OBL_RC_ACT: 4", "COM_OBL_RC_ACT: 4.5", "7:30", "whole number"),
        ("MAV_CMD_USER_1", "MAV_CMD_USR_1", "12:12", "MAV_CMD_USER_1"),
        ("result: FAILED", "result: OOPS", "14:52", "FAILED"),
        ("visit: 2", "visit: 0", "10:56", "visit"),
        ("  command:", "  component: 30\n  command:", "12:14", "same component id 30"),
    ],
)
def test_mistakes_are_placed_and_explained(right: str, wrong: str, place: str, part: str) -> None:
    with pytest.raises(MissionError) as caught:
        parse(FULL.replace(right, wrong))
    assert str(caught.value).startswith(f"missions/a.sim.yaml:{place}: ")
    assert part in str(caught.value)


def write_hall(folder: Path, start: str) -> Path:
    """A hall of 4 m by 4 m: walls around, home at the south-west corner."""
    pixels = np.full((40, 40), 254, dtype=np.uint8)
    pixels[[0, -1], :] = pixels[:, [0, -1]] = 0
    Image.fromarray(pixels).save(folder / "hall.pgm")
    (folder / "hall.yaml").write_text(
        "image: hall.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    path = folder / "hall.sim.yaml"
    path.write_text(f"version: 1\nmap: hall.yaml\nstart: {start}\n")
    return path


def test_the_map_lies_beside_the_scenario(tmp_path: Path) -> None:
    scenario, grid = read_scenario(write_hall(tmp_path, "{east_m: 2, north_m: 2}"))
    assert grid is not None
    assert grid.clearance_m(scenario.start[:2]) == pytest.approx(1.95, abs=0.11)


@pytest.mark.parametrize("start", ["{east_m: 0.2, north_m: 2}", "{east_m: 9, north_m: 9}"])
def test_a_start_in_a_wall_or_off_the_map_is_refused(tmp_path: Path, start: str) -> None:
    with pytest.raises(MissionError, match=r"hall\.sim\.yaml:3:8: the start lies in a wall"):
        read_scenario(write_hall(tmp_path, start))


def test_the_vehicle_may_differ_from_its_profile(tmp_path: Path) -> None:
    """What stands 40 cm from the wall with 35 cm of radius does not with 50 cm."""
    start = "{east_m: 0.45, north_m: 2}"
    scenario, _ = read_scenario(write_hall(tmp_path, start))
    assert scenario.vehicle == VehicleProfile()
    path = write_hall(tmp_path, f"{start}\nvehicle: {{radius_m: 0.5}}")
    with pytest.raises(MissionError, match=r"hall\.sim\.yaml:3:8: (.|\n)*needs 0\.5 m around it"):
        read_scenario(path)
    (tmp_path / "vehicles").mkdir()
    other = (MISSIONS / "vehicles" / "quad_35cm.yaml").read_text().replace("0.35 ", "0.25 ")
    (tmp_path / "vehicles" / "small.yaml").write_text(other)
    path = write_hall(tmp_path, f"{start}\nvehicle: {{profile: small, climb_mps: 1}}")
    scenario, _ = read_scenario(path)
    assert scenario.vehicle == VehicleProfile("small", radius_m=0.25, climb_mps=1.0)


@pytest.mark.parametrize(
    ("vehicle", "place", "part"),
    [
        ("quad_36cm", "4:10", "there is no vehicle profile quad_36cm"),
        ("{radius: 1}", "4:11", "Did you mean radius_m?"),
    ],
)
def test_mistakes_in_a_vehicle_are_placed(
    tmp_path: Path, vehicle: str, place: str, part: str
) -> None:
    path = write_hall(tmp_path, f"{{east_m: 2, north_m: 2}}\nvehicle: {vehicle}")
    with pytest.raises(MissionError) as caught:
        read_scenario(path)
    assert str(caught.value).startswith(f"{path}:{place}: ")
    assert part in str(caught.value)


def test_a_missing_file_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="cannot be read"):
        read_scenario(tmp_path / "no.sim.yaml")


CRATE = "obstacles: [{name: crate, circle: {east_m: 200, north_m: 20, radius_m: 1}}]"


@pytest.mark.parametrize("map_", ["", "map: {}", "map: {walls: []}"])
def test_obstacles_stand_in_an_open_field_where_no_map_is_named(map_: str) -> None:
    _, grid = read_scenario(f"version: 1\n{CRATE}\n{map_}\n")
    assert grid is not None
    assert grid.is_open
    assert grid.contains(*grid.cell((19.0, 201.0)))


def test_a_field_with_nothing_on_it_is_a_map() -> None:
    scenario, grid = read_scenario("version: 1\nmap: {}\n")
    assert grid is not None
    assert grid.clearance_m(scenario.start[:2]) == math.inf


@pytest.mark.parametrize(
    ("area", "hint"),
    [
        ("east_m: [-80, 250], north_m: [-60, 250]", "write cell_m: 0.2, or more"),
        ("east_m: [-800, 2500], north_m: [0, 9]", "at most 4000 along an edge: write cell_m: 1,"),
        ("east_m: [0, 9]", "or neither: it spans walls and obstacles then"),
    ],
)
def test_a_map_that_is_too_large_or_half_says_what_to_write(area: str, hint: str) -> None:
    with pytest.raises(MissionError) as error:
        read_scenario(f"version: 1\nmap: {{{area}}}\n")
    assert hint in error.value.hint
