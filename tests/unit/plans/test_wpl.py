"""Text files of waypoints and of fences."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from plan_files import HOME, at, imported

from companion import load_mission
from companion.errors import MissionError
from companion.plans.draft_places import Given

Row = Sequence[float]


def wpl(*rows: Row, home: bool = True, blank: str = "\t") -> str:
    """A file in which the rows begin with frame and command."""
    numbered = [(0, 16, 0, 0, 0, 0, *HOME, 488.0), *rows] if home else rows
    first = 0 if home else 1
    lines = [
        blank.join(map(str, (first + index, 0, *row, *[0.0] * (9 - len(row)), 1)))
        for index, row in enumerate(numbered)
    ]
    return "\n".join(["QGC WPL 110", "# a comment", *lines]) + "\n"


def way(north_m: float, east_m: float, up_m: float = 20.0) -> Row:
    return (3, 16, 0, 0, 0, 0, *at(north_m, east_m), up_m)


TAKE_OFF, RETURN = (3, 22, 0, 0, 0, 0, 0, 0, 20), (3, 20)


@pytest.mark.parametrize("blank", ["\t", "  "])
@pytest.mark.parametrize("ending", ["txt", "waypoints"])
def test_waypoints_of_a_text_file(blank: str, ending: str, tmp_path: Path) -> None:
    text = wpl(TAKE_OFF, way(30, 0), way(30, 40, 25.0), RETURN, blank=blank)
    mission = load_mission(imported(tmp_path, text, f"field.{ending}")[0])
    assert list(mission.places) == ["Home", "W2", "W3"]
    assert mission.places["Home"].position == pytest.approx((0, 0, -20), abs=0.001)
    assert mission.places["W3"].position == pytest.approx((30, 40, -25), abs=0.001)


def test_a_first_item_above_home_is_a_waypoint_and_not_home(tmp_path: Path) -> None:
    text, draft = imported(tmp_path, wpl(way(0, 0), way(30, 0), home=False), "field.txt")
    assert list(load_mission(text).places) == ["Home", "W2"]
    assert any("says nothing of home; it is put at item 1" in line for line in draft.told)


def test_a_takeoff_after_an_unknown_item_is_the_first_one_still(tmp_path: Path) -> None:
    text = wpl((0, 0), TAKE_OFF, way(30, 0), RETURN, home=False)
    with pytest.raises(MissionError, match=r"field.txt: item 1: an unknown command \(0\) has no"):
        imported(tmp_path, text, "field.txt")


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "its first line is not QGC WPL 110"),
        ("QGC WPL 120\n", "its first line is not QGC WPL 110"),
        (wpl() + "3\t0\t3\t16\n", "item 3: has 4 columns, expected 12"),
        (wpl() + "3 0 3 16 0 0 0 x 47 8 20 1\n", "item 3: has something that is no number"),
        (wpl() + "3 0 3 16 0 0 0 0 47 8 1e300 1\n", "item 3: has a number that is too large"),
        (wpl() + "nan 0 3 16 0 0 0 0 47 8 20 1\n", "item nan: has something that is no number"),
        (wpl((10, 16, 0, 0, 0, 0, *at(5, 5), 9)), "item 1: its altitude is above the terrain"),
        (wpl((3, 84)), "item 1: NAV_VTOL_TAKEOFF (84) is for planes"),
        (wpl((3, 31, 0, 0, 0, 0, *at(5, 5), 9)), "item 1: NAV_LOITER_TO_ALT (31) circles"),
        ("QGC WPL 110\n" + "1 0 3 20 0 0 0 0 0 0 0 1\n" * 5001, "has 5001 items"),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, what: str, tmp_path: Path) -> None:
    with pytest.raises(MissionError) as error:
        imported(tmp_path, text, "field.txt")
    assert what in str(error.value)


FENCE = [at(0, 0), at(-50, -50), at(-50, 50), at(50, 50), at(50, -50), at(-50, -50)]


def test_a_fence_file_is_the_fence_of_a_mission_that_only_takes_off(tmp_path: Path) -> None:
    text = "\n".join(f"{latitude:.7f}\t{longitude:.7f}" for latitude, longitude in FENCE)
    given = Given(home=HOME, up_m=15.0)
    mission = load_mission(imported(tmp_path, text, "fence.txt", given)[0])
    assert len(mission.limits.fence) == 4 and list(mission.places) == ["Home"]
    with pytest.raises(MissionError, match="--home LAT,LON"):
        imported(tmp_path, text, "fence.txt")
    with pytest.raises(MissionError, match="no fence"):
        imported(tmp_path, "47.1 8.1\n47.2 8.2\n", "fence.txt", given)
