"""What becomes of the items of a .plan, and what is refused by its item."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
from plan_files import (
    HOME,
    HOME_AMSL_M,
    RETURN,
    TAKE_OFF,
    at,
    imported,
    item,
    plan,
    waypoint,
)

from companion import Planner, load_mission
from companion.errors import MissionError
from companion.geometry import distance
from companion.mission.model import Mission
from companion.plans.draft import MAX_PLACES, MAX_STOPS
from companion.plans.draft_places import Given

WAY = (waypoint(30, 0), waypoint(30, 40), waypoint(0, 40))


def mission_of(folder: Path, *items: dict[str, Any], **more: Any) -> Mission:
    return load_mission(imported(folder, plan(*items, **more))[0])


def told(folder: Path, *items: dict[str, Any], **more: Any) -> str:
    return "\n".join(imported(folder, plan(*items, **more))[1].notes)


def refusal(folder: Path, *items: dict[str, Any], given: Given = Given(), **more: Any) -> str:  # noqa: B008
    with pytest.raises(MissionError) as error:
        imported(folder, plan(*items, **more), "field.plan", given)
    assert str(error.value).startswith(f"{folder}/field.plan: ")
    return str(error.value).removeprefix(f"{folder}/field.plan: ")


def flown(mission: Mission) -> list[str]:
    """The actions of the plan's prefix, and of its loop behind a bar."""
    lasso = Planner(mission).plan().lasso
    prefix, loop = ([str(action.name) for action in part] for part in (lasso.prefix, lasso.loop))
    return [*prefix, "|", *loop]


def test_waypoints_lower_than_a_height_by_gps_is_certain_are_told(tmp_path: Path) -> None:
    low = [waypoint(30, 0, 1.2), waypoint(30, 40, 1.5), waypoint(0, 40, 1.0)]
    text, draft = imported(tmp_path, plan(TAKE_OFF, *low, RETURN))
    noticed = "W2 (1.2 m), W4 (1 m): flown to so low above what is below, and the height of a"
    (line,) = (each for each in draft.notes if each.startswith(noticed))
    assert f"# - {line}" in text


def test_waypoints_are_places_in_their_order_and_then_home(tmp_path: Path) -> None:
    mission = mission_of(tmp_path, TAKE_OFF, *WAY, RETURN)
    assert list(mission.places) == ["Home", "W2", "W3", "W4"]
    wanted = {"Home": (0, 0, -20), "W2": (30, 0, -20), "W3": (30, 40, -20), "W4": (0, 40, -20)}
    for name, position in wanted.items():
        assert distance(mission.places[name].position, position) < 0.001
    assert flown(mission)[:5] == [
        "move(Home, W2)",
        "move(W2, W3)",
        "move(W3, W4)",
        "move(W4, Home)",
        "|",
    ]


def test_an_order_that_is_not_the_shortest_is_kept(tmp_path: Path) -> None:
    crossed = (waypoint(30, 0), waypoint(0, 40), waypoint(30, 40), waypoint(0, 10))
    mission = mission_of(tmp_path, TAKE_OFF, *crossed, RETURN)
    assert flown(mission)[:4] == ["move(Home, W2)", "move(W2, W3)", "move(W3, W4)", "move(W4, W5)"]


def test_a_jump_without_an_end_is_a_patrol(tmp_path: Path) -> None:
    way = (waypoint(-20, 0), *WAY, item(177, 3, -1, frame=2))
    mission = mission_of(tmp_path, TAKE_OFF, *way)
    actions = flown(mission)
    loop = actions[actions.index("|") + 1 :]
    assert {name for action in loop for name in action[5:-1].split(", ")} == {"W3", "W4", "W5"}
    assert actions[0] == "move(Home, W2)"


def test_a_point_that_is_flown_twice_is_one_place(tmp_path: Path) -> None:
    way = (*WAY, waypoint(30.4, 0.3), waypoint(-10, 0))
    mission = mission_of(tmp_path, TAKE_OFF, *way, RETURN)
    assert list(mission.places) == ["Home", "W2", "W3", "W4", "W6"]
    wanted = ["move(Home, W2)", "move(W2, W3)", "move(W3, W4)", "move(W4, W2)", "move(W2, W6)"]
    assert flown(mission)[:5] == wanted


def test_the_same_point_at_another_height_is_refused(tmp_path: Path) -> None:
    said = refusal(tmp_path, TAKE_OFF, waypoint(30, 0), waypoint(30.4, 0, 40.0), RETURN)
    assert said.startswith("item 3: is above or below item 2, at another height")


def test_holds_and_commands_are_done_at_their_stop_and_in_the_order(tmp_path: Path) -> None:
    photo = item(2000, 0, 0, 1, frame=2)
    crossed = (waypoint(0, 40, hold_s=5), waypoint(30, 0), photo, item(93, 7), waypoint(0, 10))
    text, _ = imported(tmp_path, plan(TAKE_OFF, *crossed, RETURN), "field.plan", Given(payload=100))
    mission = load_mission(text)
    actions = flown(mission)
    assert actions[:5] == ["move(Home, W2)", "act_W2", "move(W2, W3)", "act_W3", "move(W3, W6)"]
    steps = "command(payload, MAV_CMD_IMAGE_START_CAPTURE, 0, 0, 1)', wait(7)"
    assert "wait(5)" in text and steps in text and "payload: 100" in text


def test_the_work_of_a_patrol_is_done_in_each_lap(tmp_path: Path) -> None:
    mission = mission_of(
        tmp_path, TAKE_OFF, waypoint(30, 0, hold_s=5), waypoint(0, 40), item(177, 2, -1, frame=2)
    )
    actions = flown(mission)
    assert "act_W2" in actions[actions.index("|") :]


def test_commands_for_payloads_need_a_component_or_are_left_out(tmp_path: Path) -> None:
    photo = item(2000, 0, 0, 1, frame=2)
    items = (TAKE_OFF, waypoint(30, 0), photo, waypoint(30, 40), item(206, 25, frame=2))
    said = refusal(tmp_path, *items)
    assert said.splitlines()[0] == "2 items cannot be imported"
    assert "item 3: IMAGE_START_CAPTURE (2000) is for a payload" in said
    assert "item 5: DO_SET_CAM_TRIGG_DIST (206) is for a payload" in said
    assert "--payload 100" in said
    text, draft = imported(tmp_path, plan(*items), "field.plan", Given(), "payloads")
    assert (
        "command(" not in text
        and "item 3: IMAGE_START_CAPTURE (2000) left out" in draft.notes[-4:][0]
    )
    assert imported(tmp_path, plan(*items), "field.plan", Given(payload=100), "5")


@pytest.mark.parametrize(
    ("bad", "what"),
    [
        (item(84), "NAV_VTOL_TAKEOFF (84) is for planes"),
        (item(31, *at(5, 5), 10), "NAV_LOITER_TO_ALT (31) circles"),
        (item(112, 5), "CONDITION_DELAY (112) depends on what happens"),
        (item(92, 1), "NAV_GUIDED_ENABLE (92) hands the vehicle"),
        (item(94), "NAV_PAYLOAD_PLACE (94) lands"),
        (item(177, 2, 3), "DO_JUMP (177) 3 times"),
        (item(177, 99, -1), "DO_JUMP (177) leads to item 99, and not back"),
        (item(400, 1), "COMPONENT_ARM_DISARM (400) has no meaning"),
        (item(54321), "an unknown command (54321) has no meaning"),
        (TAKE_OFF, "NAV_TAKEOFF (22) in the middle"),
        (waypoint(0, 40, frame=10), "above the terrain (frame 10)"),
        (waypoint(0, 40, frame=1), "frame 1 says no altitude"),
        (waypoint(0, 40, up_m=0.2), "is at 0.2 m above home"),
        (waypoint(0, 20_000), "is 20 km from home"),
        (item(16, 0, 0, 0, None, 95.0, 8.5, 20), "is nowhere on the earth"),
        (item(16, 0, 0, 0, None, 0, 0, 20), "NAV_WAYPOINT (16) has no position"),
        (item(16, 0, 0, 0, None, *HOME, None), "has no altitude"),
        (waypoint(0, 40, HOME_AMSL_M - 30, frame=0), "above the sea, and home at 488 m"),
    ],
)
def test_an_item_that_a_mission_cannot_mean_is_refused(
    bad: dict[str, Any], what: str, tmp_path: Path
) -> None:
    said = refusal(tmp_path, TAKE_OFF, waypoint(30, 0), bad, waypoint(0, 10))
    assert said.startswith("item 3: ") and what in said


def test_all_items_that_are_refused_are_told_at_once(tmp_path: Path) -> None:
    said = refusal(tmp_path, item(84), waypoint(30, 0), item(85), item(31))
    assert [line.split(":")[0].strip() for line in said.splitlines()[1:4]] == [
        "item 1",
        "item 3",
        "item 4",
    ]
    assert "--leave-out 3,7" in said


def test_nothing_after_the_end_is_dropped_in_silence(tmp_path: Path) -> None:
    assert "item 4: NAV_WAYPOINT (16) comes after item 3, with" in refusal(
        tmp_path, TAKE_OFF, waypoint(30, 0), RETURN, waypoint(0, 40)
    )


def test_a_landing_elsewhere_ends_there(tmp_path: Path) -> None:
    mission = mission_of(
        tmp_path, TAKE_OFF, waypoint(30, 0), item(21, 0, 0, 0, None, *at(30, 40), 0)
    )
    actions = flown(mission)
    assert actions[1:3] == ["move(W2, W3)", "|"] and str(mission.task["end"]) == "F G at(W3)"
    assert mission.places["W3"].position[2] == pytest.approx(-20.0)


def test_a_landing_without_a_position_is_where_the_vehicle_is(tmp_path: Path) -> None:
    mission = mission_of(tmp_path, TAKE_OFF, waypoint(30, 0), item(21, frame=3))
    actions = flown(mission)
    assert actions[:2] == ["move(Home, W2)", "|"] and str(mission.task["end"]) == "F G at(W2)"
    take_off = item(22, 0, 0, 0, None, *HOME, 20)
    assert flown(mission_of(tmp_path, take_off, item(21, frame=3)))[0] == "|"


def test_the_box_of_px4_takes_off_lower_than_it_flies_and_lands_at_home(tmp_path: Path) -> None:
    over_home, land = waypoint(0, 0, 30), item(21, 0, 0, 0, None, *HOME, 0)
    items = (TAKE_OFF, waypoint(30, 0, 30), waypoint(30, 40, 30), over_home, land)
    mission = mission_of(tmp_path, *items)
    assert list(mission.places) == ["Home", "W2", "W3"]
    wanted = ["move(Home, W2)", "move(W2, W3)", "move(W3, Home)", "|"]
    assert flown(mission)[:4] == wanted
    assert mission.places["Home"].position[2] == pytest.approx(-30)
    assert "item 4: above home; so the takeoff is to 30 m and not to 20 m" in told(tmp_path, *items)
    lower = (TAKE_OFF, waypoint(30, 0, 10), waypoint(0, 0, 10), RETURN)
    assert refusal(tmp_path, *lower).startswith("item 3: is above or below home")


def test_loitering_without_a_position_is_a_wait_there(tmp_path: Path) -> None:
    items = (TAKE_OFF, waypoint(30, 0), item(19, 5, 0, 0, 0, 0, 0, 20), RETURN)
    assert flown(mission_of(tmp_path, *items))[:2] == ["move(Home, W2)", "act_W2"]


def test_altitudes_above_the_sea_stay_so(tmp_path: Path) -> None:
    text, _ = imported(tmp_path, plan(TAKE_OFF, waypoint(30, 0, 520.0, frame=0), RETURN))
    place = load_mission(text).places["W2"]
    assert place.amsl_m == 520.0


def test_the_frame_counts_where_the_mode_disagrees(tmp_path: Path) -> None:
    way = waypoint(30, 0, 20.0, AltitudeMode=2)
    assert "item 2: AltitudeMode 2 and frame 3 disagree" in told(tmp_path, TAKE_OFF, way, RETURN)
    way = waypoint(30, 0, 20.0, AltitudeMode=1, Altitude=120)
    said = told(tmp_path, TAKE_OFF, way, RETURN)
    assert "item 2: Altitude 120 and the seventh param 20 disagree; the param counts" in said
    above_terrain = waypoint(30, 0, 508.0, AltitudeMode=3, Altitude=20) | {"frame": 0}
    assert "disagree" not in told(tmp_path, TAKE_OFF, above_terrain, RETURN)


def test_an_unknown_height_of_home_refuses_heights_above_the_sea(tmp_path: Path) -> None:
    said = refusal(
        tmp_path, TAKE_OFF, waypoint(30, 0, 520.0, frame=0), plannedHomePosition=[*HOME, None]
    )
    assert said.startswith("item 2: its altitude is above the sea") and "--home" in said


def test_the_least_of_several_speeds_counts(tmp_path: Path) -> None:
    speeds = (item(178, 1, 7.5, frame=2), item(178, 1, 3.0, frame=2), item(178, 1, -1, frame=2))
    items = (TAKE_OFF, speeds[0], waypoint(30, 0), *speeds[1:], waypoint(0, 40), RETURN)
    assert mission_of(tmp_path, *items).limits.speed_mps == 3.0
    assert "speeds 7.5, 3 m/s: the least is meant" in told(tmp_path, *items)


def test_plans_of_planes_and_other_versions_are_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path, *WAY, vehicleType=20).startswith(
        "is for a vehicle that is not a copter"
    )
    assert refusal(tmp_path, *WAY, version=7).startswith("its mission has version 7")
    for version in (2, 42):
        with pytest.raises(MissionError, match=f"the file has version {version}, and 1 is known"):
            imported(tmp_path, plan(*WAY) | {"version": version})


def test_a_position_that_is_missing_is_told(tmp_path: Path) -> None:
    assert refusal(tmp_path, *WAY, rally=[[None, 8.5]]).startswith(
        "rally point 1: its position is missing"
    )


def test_more_places_than_are_planned_are_refused(tmp_path: Path) -> None:
    way = [waypoint(10 + 5 * i, 0) for i in range(MAX_PLACES + 1)]
    assert f"leads to more than {MAX_PLACES} places" in refusal(tmp_path, TAKE_OFF, *way)
    again = [waypoint(30, 40 * (i % 2)) for i in range(MAX_STOPS + 1)]
    assert f"leads to more than {MAX_STOPS} stops" in refusal(tmp_path, TAKE_OFF, *again)


# -- other forms of items --------------------------------------------------------------------------


def test_a_coordinate_in_place_of_params_is_the_same(tmp_path: Path) -> None:
    old = []
    for each in (TAKE_OFF, *WAY, RETURN):
        form = copy.deepcopy(each)
        *form["params"], latitude, longitude, up_m = form["params"]
        form["coordinate"] = [latitude, longitude, up_m]
        old.append(form)
    older = copy.deepcopy(old)
    for form in older:
        form["type"] = "missionItem"
        for index, value in enumerate(form.pop("params"), 1):
            form[f"param{index}"] = value
    new, *others = (
        mission_of(tmp_path, *items) for items in ((TAKE_OFF, *WAY, RETURN), old, older)
    )
    for other in others:
        assert other.places == new.places and other.task == new.task


@pytest.mark.parametrize("version", [1, 2])
def test_mission_files_of_before_are_read(version: int, tmp_path: Path) -> None:
    items = [
        {"type": "missionItem", "command": 16, "frame": 3, "id": i, "coordinate": [*at(*where), 20]}
        for i, where in enumerate(((30, 0), (30, 40)), 1)
    ]
    old = {
        "MAV_AUTOPILOT": 12,
        "version": "1.0",
        "complexItems": [],
        "items": items,
        "plannedHomePosition": {"type": "missionItem", "coordinate": [*HOME, 488]},
    }
    if version == 2:
        old = {"version": 2, "items": items, "plannedHomePosition": [*HOME, 488]}
    text, _ = imported(tmp_path, old, "old.mission")
    assert list(load_mission(text).places) == ["Home", "W1", "W2"]


def survey(**style: Any) -> dict[str, Any]:
    return {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "version": 5,
        "TransectStyleComplexItem": style,
    }


def test_a_survey_is_its_points(tmp_path: Path) -> None:
    points = [waypoint(30, 0), waypoint(30, 40), waypoint(40, 40), waypoint(40, 0)]
    mission = mission_of(tmp_path, TAKE_OFF, survey(Items=points), RETURN)
    assert list(mission.places) == ["Home", "W2_1", "W2_2", "W2_3", "W2_4"]
    camera = {"DistanceToSurface": 35, "DistanceToSurfaceRelative": True}
    drawn = survey(VisualTransectPoints=[at(30, 0), at(30, 40)], CameraCalc=camera)
    mission = mission_of(tmp_path, TAKE_OFF, drawn, RETURN)
    assert mission.places["W2_2"].position == pytest.approx((30, 40, -35), abs=0.001)


def test_what_is_not_worked_out_is_refused_or_left_out(tmp_path: Path) -> None:
    camera = {"DistanceToSurface": 35, "DistanceToSurfaceRelative": False}
    drawn = survey(VisualTransectPoints=[at(30, 0)], CameraCalc=camera)
    assert refusal(tmp_path, TAKE_OFF, drawn).startswith(
        "item 2: survey has no altitude above home"
    )
    assert refusal(tmp_path, survey()).startswith("item 1: survey has no points")
    assert "version 9" in refusal(tmp_path, survey() | {"version": 9})
    scan = survey() | {"complexItemType": "StructureScan"}
    assert refusal(tmp_path, scan).startswith("item 1: StructureScan is not flown point by point")
    text, draft = imported(tmp_path, plan(scan, *WAY), "field.plan", Given(), "1")
    assert load_mission(text) and "item 1: StructureScan left out, as asked" in draft.notes
