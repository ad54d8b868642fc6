"""What a mission may say of a place that is found in flight, and what it may not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from companion import NoPlanError, Planner, load_mission
from companion.acting.preparation import prepare
from companion.errors import MissionError
from companion.planning.flight_times import route_map

LOST_PERSON = Path(__file__).parents[3] / "missions" / "lost_person.yaml"
TEXT = LOST_PERSON.read_text(encoding="utf-8")
EVENT = '{when: "EVENT[person] > 0", latch: true}'


def refused(before: str, after: str) -> MissionError:
    assert before in TEXT
    with pytest.raises(MissionError) as caught:
        load_mission(TEXT.replace(before, after, 1))
    return caught.value


@pytest.mark.parametrize(
    ("before", "after", "what"),
    [
        (
            "found_by: personSeen",
            "found_by: personSen",
            "found by personSen, which is not an event",
        ),
        (EVENT, '{when: "EVENT[person] > 0"}', "what was found stays found, and the event"),
        (EVENT, '{when: "EVENT[person] > 1", latch: true}', "it does not come when something"),
        (EVENT, '{when: "EVENT[person] < 3", latch: true}', "it does not come when something"),
        (
            EVENT,
            '{when: "EVENT[person] is silent", stale_s: 2, latch: true}',
            "it does not come when something is found",
        ),
        (
            EVENT,
            '{when: "NAMED_VALUE_INT[person].value > 0", latch: true}',
            "is not a report of another program",
        ),
        ("at(Home)]", "at(Person)]", "the mission begins at Person, which is only found in flight"),
        (
            "precondition: at(Person)",
            "precondition: at(West)\n    look_at: Person",
            "drop looks at Person, and where that is, is known in flight alone",
        ),
        (
            "execute: fly(to)",
            "execute: fly(to)\n    look_at: to",
            "move looks at Person, and where that is, is known in flight alone",
        ),
        (
            "  West: {east_m: 8, north_m: 25, up_m: 6}",
            "  West: {east_m: 8, north_m: 25, up_m: 6, found_by: personSeen}",
            "places West and Person are found by the same report",
        ),
    ],
)
def test_what_no_report_can_find_is_refused_with_its_place(
    before: str, after: str, what: str
) -> None:
    error = refused(before, after)
    assert what in error.what
    assert error.where is not None and error.hint


def test_until_it_is_found_no_way_leads_there() -> None:
    mission = load_mission(LOST_PERSON)
    routes = prepare(mission).routes
    home = mission.home.position
    assert not routes.knows("Person") and not routes.is_connected(home, "Person")
    assert routes.distance_m(home, "Person") == float("inf")
    assert routes.route(home, "Person") is None
    assert routes.route_from_motion(home, home, "Person") is None
    version = routes.version
    routes.find_place("Person", (20.0, 5.0, -4.0))
    assert routes.version > version
    route = routes.route(home, "Person")
    assert route is not None
    assert route.waypoints[-1].tolist() == [20.0, 5.0, -4.0]


def test_a_task_that_does_not_wait_for_it_has_no_plan() -> None:
    mission = load_mission(TEXT.replace("G (personSeen -> F helped)", "F at(Person)"))
    first = prepare(mission).first_plan
    assert first is not None and isinstance(first.outcome, NoPlanError)


def test_on_the_desk_it_is_planned_for_as_if_it_lay_where_the_mission_says() -> None:
    plan = Planner(load_mission(LOST_PERSON)).plan()
    assert "Person" not in str(plan.lasso)
    assert route_map(load_mission(LOST_PERSON)).knows("Person")


def test_its_region_is_crossed_by_other_flights() -> None:
    """It is the whole field; a place that the task names is not crossed otherwise."""
    mission = load_mission(LOST_PERSON)
    routes: Any = route_map(mission)
    assert routes.route(mission.home.position, "South") is not None
