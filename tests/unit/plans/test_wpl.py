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
    assert any("says nothing of home; it is put at item 1" in line for line in draft.notes)


def test_home_is_where_the_plan_takes_off_unless_it_is_given(tmp_path: Path) -> None:
    text = wpl((3, 22, 0, 0, 0, 0, *HOME, 20), way(30, 0), home=False)
    note = "home is where the plan takes off: it says nothing else of home"
    assert note in imported(tmp_path, text, "field.txt")[1].notes
    given = Given(home=at(0, 20))
    assert note not in imported(tmp_path, text, "field.txt", given)[1].notes


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
        (wpl() + "3 0 3 16 0 0 0 x 47 8 20 1\n", "item 3: has something that is not a number"),
        (wpl() + "3 0 3 16 0 0 0 0 47 8 1e300 1\n", "item 3: has a number that is too large"),
        (wpl() + "nan 0 3 16 0 0 0 0 47 8 20 1\n", "item nan: has something that is not a number"),
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


AREA = ((-90, -90), (-90, 90), (90, 90), (90, -90))
POND = ((50, 50), (50, 60), (60, 60))


def corners(command: int, *points: tuple[float, float], said: int | None = None) -> list[Row]:
    count = len(points) if said is None else said
    return [(0, command, count, 0, 0, 0, *at(*point), 0) for point in points]


def test_fence_and_rally_points_may_be_items(tmp_path: Path) -> None:
    circles = [(3, 5003, 100, 0, 0, 0, *HOME, 0), (3, 5004, 9, 0, 0, 0, *at(-50, 0), 0)]
    rally = [(3, 5100, 0, 0, 0, 0, *at(0, 30), 25), (3, 5100, 0, 0, 0, 0, *at(0, -30), 0)]
    drawn = [*corners(5001, *AREA), *corners(5002, *POND), *circles, *rally]
    mission = load_mission(
        imported(tmp_path, wpl(TAKE_OFF, way(30, 0), RETURN, *drawn), "field.txt")[0]
    )
    assert max(north for north, _ in mission.limits.fence) == pytest.approx(90, abs=0.5)
    assert list(mission.limits.keep_out) == ["polygon_2", "circle_4"]
    assert mission.safe_places == ("Home", "R1", "R2")
    assert [-mission.places[each].position[2] for each in ("R1", "R2")] == pytest.approx([25, 20])
    text, draft = imported(tmp_path, wpl(TAKE_OFF, *drawn), "field.txt", Given(), "10", "11")
    assert list(load_mission(text).limits.keep_out) == ["polygon_2"]
    assert "item 10: NAV_FENCE_CIRCLE_EXCLUSION (5004) left out, as asked" in draft.notes


@pytest.mark.parametrize(
    ("rows", "what"),
    [
        (corners(5001, *AREA, said=5), "item 1: says that its polygon has 5 corners, and 4"),
        (corners(5001, *AREA, said=0), "item 1: says that its polygon has 0 corners, and 4"),
        (corners(5002, *POND[:2]), "items 1 to 2: a polygon of 2 corners has no area"),
        ([(0, 5003, 9)], "item 1: NAV_FENCE_CIRCLE_INCLUSION (5003) has no position"),
        ([(0, 5003, 0, 0, 0, 0, *HOME)], "item 1: a circle of 0 m"),
        ([(10, 5100, 0, 0, 0, 0, *HOME, 9)], "item 1: its altitude is above the terrain"),
    ],
)
def test_a_fence_that_is_none_is_refused(rows: list[Row], what: str, tmp_path: Path) -> None:
    with pytest.raises(MissionError) as error:
        imported(tmp_path, wpl(*rows), "fence.waypoints", Given(up_m=20.0))
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
