"""Speeds have a least value: slower than it no vehicle flies a mission."""

from __future__ import annotations

import pytest
from mistakes import FIELD

from companion import load_mission
from companion.errors import MissionError


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("speed_mps: 5", "speed_mps: 1e-9"),
        ("speed_mps: 5", "speed_mps: 0.09"),
        ("places:", "vehicle: {climb_mps: 1e-9}\nplaces:"),
        ("places:", "vehicle: {descent_mps: 0.01}\nplaces:"),
        ("places:", "vehicle: {speed_mps: 0.01}\nplaces:"),
    ],
)
def test_a_speed_at_which_nothing_is_flown_is_refused(right: str, wrong: str) -> None:
    with pytest.raises(MissionError, match=r"_mps is \S+, expected at least 0\.1"):
        load_mission(FIELD.replace(right, wrong, 1))


def test_the_least_speed_is_one() -> None:
    slow = load_mission(FIELD.replace("speed_mps: 5", "speed_mps: 0.1", 1))
    assert slow.limits.speed_mps == 0.1
