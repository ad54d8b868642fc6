"""What if? States that the mission does not begin in, and names that it does not know."""

from __future__ import annotations

import pytest

from companion.errors import MissionError
from companion.mission.model import Mission
from companion.motion.routes import RouteMap
from companion.planning.flight_times import flight_times
from companion.planning.planner import Planner
from companion.planning.supposition import Supposition
from companion.planning.task_state import TaskState


@pytest.fixture
def planner(surveillance: Mission, surveillance_routes: RouteMap) -> Planner:
    return Planner(surveillance, flight_times(surveillance, surveillance_routes))


def plan(planner: Planner, supposed: Supposition) -> str:
    task = TaskState(planner)
    task.facts, task.withdrawn = supposed.facts(planner), supposed.withdrawn(planner)
    return str(planner.plan(*task.problem()))


def test_nothing_supposed_is_the_missions_own_beginning(planner: Planner) -> None:
    assert plan(planner, Supposition()) == ("move(Home, A), (move(A, B), move(B, C), move(C, A))^w")


def test_the_papers_replans_can_be_asked_for_on_the_ground(planner: Planner) -> None:
    found = Supposition(at="r1", holds=("targetFound",))
    assert plan(planner, found) == "upload(r1), move(r1, Home), (wait)^w"
    refused = Supposition(at="r1", holds=("targetFound",), without=("canUpload(r1)",))
    assert plan(planner, refused) == "move(r1, r2), upload(r2), move(r2, Home), (wait)^w"


def test_a_fact_of_the_beginning_can_be_taken_away(planner: Planner) -> None:
    assert Supposition(fails=("at(Home)",)).facts(planner) == frozenset()


@pytest.mark.parametrize(
    ("supposed", "what", "hint"),
    [
        (Supposition(at="D"), "no place D", "known are A, B, C, Home"),
        (Supposition(holds=("targetfound",)), "no fact targetfound", "Did you mean targetFound?"),
        (Supposition(fails=("at(D)",)), r"no fact at\(D\)", "Did you mean at"),
        (Supposition(holds=("canUpload(r1)",)), "no fact canUpload", "known are"),
        (Supposition(without=("canUpload(r9)",)), "no belief", r"Did you mean canUpload\(r1\)"),
    ],
)
def test_a_name_that_the_mission_does_not_know(
    planner: Planner, supposed: Supposition, what: str, hint: str
) -> None:
    with pytest.raises(MissionError, match=f"(?s){what}.*{hint}"):
        supposed.facts(planner)
        supposed.withdrawn(planner)
