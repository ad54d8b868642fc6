"""The steps of payloads, as a mission writes them: what they mean, and what is refused where."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.errors import MissionError
from companion.mission.loader import load_mission
from companion.mission.payload_steps import Photo, PointGimbal
from companion.mission.places import PointOfInterest
from companion.mission.skills import Skill
from companion.mission.steps import Command

GRIPPER = 211


def skill(**keys: Any) -> Skill:
    """The skill `act` of a mission, with these keys."""
    mission = {
        "version": 1,
        "name": "payloads",
        "limits": {"speed_mps": 3, "up_m": [1, 4], "fence": [[-8, -8], [8, -8], [8, 8], [-8, 8]]},
        "places": {
            "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
            "A": {"east_m": 3, "north_m": 0, "up_m": 2},
        },
        "sets": {"Place": ["Home", "A"]},
        "components": {"camera": 100, "gimbal": 154, "gripper": 27, "px4": 1},
        "skills": {"act": {"precondition": "at(Home)", "effect": "done", **keys}},
        "initially": ["at(Home)"],
        "goal": "done",
    }
    return load_mission(mission).skills["act"]


def test_what_the_steps_mean() -> None:
    steps = ["gimbal(gimbal, -90, 45)", "photo(camera)", "grip(gripper)", "release(px4)"]
    name = "MAV_CMD_DO_GRIPPER"
    assert skill(execute=steps).execute == (
        PointGimbal(154, "gimbal", math.radians(-90), math.radians(45)),
        Photo(100, "camera"),
        Command(27, GRIPPER, name, (1.0, 1.0)),
        Command(1, GRIPPER, name, (1.0, 0.0)),
    )


def test_what_is_looked_at_has_a_height() -> None:
    point = {"east_m": 4, "north_m": 1, "up_m": 1.5}
    made = skill(execute="photo(camera)", look_at=point, gimbal="gimbal")
    assert made.look_at == PointOfInterest("east 4 m, north 1 m", (1.0, 4.0), 1.5)
    assert made.gimbal == 154


def test_confirmations_are_conditions() -> None:
    for text in ("NAMED_VALUE_INT[load].value > 0", "EVENT[load] > 0", "COMMAND.MAV_CMD_USER_2"):
        assert str(skill(execute="grip(gripper)", confirmed_by=text).confirmed_by) == text


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"execute": "photo(px4)"}, "the autopilot is not a camera"),
        ({"execute": "photo(lens)"}, "unknown component lens"),
        ({"execute": "photo()"}, "photo has 0 arguments"),
        ({"execute": "gimbal(gimbal, -120, 0)"}, "90 degrees down to 90 up"),
        ({"execute": "gimbal(gimbal, 0, 270)"}, "180 degrees to the left"),
        ({"execute": "gimbal(gimbal, down, 0)"}, "down is not a number"),
        ({"execute": "grip(hand)"}, "unknown component hand"),
        ({"execute": "photo(camera)", "gimbal": "gimbal"}, "looks at nothing"),
        ({"execute": "photo(camera)", "look_at": "A", "gimbal": "arm"}, "unknown component arm"),
        (
            {"execute": "gimbal(gimbal, 0, 0)", "look_at": "A", "gimbal": "gimbal"},
            "act holds nowhere",
        ),
        (
            {"execute": "grip(gripper)", "confirmed_by": "NAMED_VALUE_INT[load].value"},
            "is compared with nothing",
        ),
        (
            {"execute": "grip(gripper)", "confirmed_by": "NAMED_VALUE_INT[load].value is silent"},
            "silence confirms nothing",
        ),
    ],
)
def test_what_is_refused(keys: dict[str, Any], words: str) -> None:
    with pytest.raises(MissionError) as caught:
        skill(**keys)
    said = str(caught.value)
    assert words in said and "skills.act" in said


def test_a_place_right_below_can_be_looked_at_through_a_gimbal_alone() -> None:
    assert skill(execute="photo(camera)", look_at="Home", gimbal="gimbal").gimbal == 154
    with pytest.raises(MissionError, match="no direction leads there"):
        skill(execute="photo(camera)", look_at="Home")
