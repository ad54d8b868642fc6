"""States that the mission does not begin in, and names that it does not know."""

from __future__ import annotations

from collections.abc import Collection

import pytest

from companion.errors import CompanionError, MissionError
from companion.mission.model import Mission
from companion.motion.layered_routes import LayeredRoutes
from companion.planning.flight_times import flight_times
from companion.planning.flown_routes import FlownRoutes
from companion.planning.objective import Objective
from companion.planning.planner import Planner


@pytest.fixture
def planner(surveillance: Mission, surveillance_routes: LayeredRoutes) -> Planner:
    return Planner(surveillance, flight_times(surveillance, FlownRoutes(surveillance_routes)))


def test_nothing_supposed_is_the_missions_own_beginning(planner: Planner) -> None:
    assert str(planner.plan()) == "move(Home, A), (move(A, B), move(B, C), move(C, A))^w"


def test_the_papers_replans_can_be_asked_for_on_the_ground(planner: Planner) -> None:
    found = planner.plan(at="r1", facts={"targetFound"})
    assert str(found) == "upload(r1), move(r1, Home), (wait)^w"
    refused = planner.plan(at="r1", facts={"targetFound"}, without={"canUpload(r1)"})
    assert str(refused) == "move(r1, r2), upload(r2), move(r2, Home), (wait)^w"


def test_a_fact_of_the_beginning_can_be_taken_away(planner: Planner) -> None:
    problem, _ = planner.initial_problem(facts={"!at(Home)"})
    assert problem.facts == planner.actions.model.beliefs


def test_what_is_taken_away_does_not_hold_whatever_else_is_said(planner: Planner) -> None:
    problem, _ = planner.initial_problem(at="A", facts=["! at(A)", "targetFound"])
    assert problem.facts - planner.actions.model.beliefs == {"targetFound"}


@pytest.mark.parametrize(
    ("at", "facts", "without", "what", "hint"),
    [
        ("D", (), (), "no place D", "known are A, B, C, Home"),
        (None, ("targetfound",), (), "no fact targetfound", "Did you mean targetFound?"),
        (None, ("!at(D)",), (), r"no fact at\(D\)", "Did you mean at"),
        (None, ("canUpload(r1)",), (), "no fact canUpload", "known are"),
        (None, (), ("canUpload(r9)",), "no belief", r"Did you mean canUpload\(r1\)"),
    ],
)
def test_a_name_that_the_mission_does_not_know(
    planner: Planner,
    at: str | None,
    facts: Collection[str],
    without: Collection[str],
    what: str,
    hint: str,
) -> None:
    for ask in (planner.plan, planner.explain):
        with pytest.raises(MissionError, match=f"(?s){what}.*{hint}"):
            ask(at=at, facts=facts, without=without)


@pytest.mark.parametrize("said", [{"at(A)"}, {"targetFound", "at(Home)"}])
def test_where_the_vehicle_is_is_no_fact_among_others(planner: Planner, said: set[str]) -> None:
    """It would be at two places."""
    with pytest.raises(MissionError, match="the vehicle is at one place"):
        planner.plan(facts=said)


def test_one_name_is_one_name(planner: Planner) -> None:
    """And not its letters."""
    assert planner.plan(facts="targetFound") == planner.plan(facts={"targetFound"})
    with pytest.raises(MissionError, match="no belief canUpload"):
        planner.plan(without="canUpload")


def test_objectives_have_names(planner: Planner) -> None:
    found = planner.plan(facts={"targetFound"}, objective="sum")
    assert found.objective is Objective.SUM
    with pytest.raises(CompanionError, match="no objective 'smu'; there are lap, sum, bottleneck"):
        planner.plan(objective="smu")
