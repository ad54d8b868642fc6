"""A table of contingencies: folded for people, as JSON for programs, in a line."""

from __future__ import annotations

import json

import pytest

from companion.acting.contingencies.answers import Answer, GoesOn, LandsAt, Replans, short_of
from companion.acting.contingencies.changes import BeliefLost, Change, EventTurns, SiteLost
from companion.acting.contingencies.fold_words import (
    answers_in_words,
    labels_in_words,
    positions_in_words,
)
from companion.acting.contingencies.table import Contingency, ContingencyTable, PlanPosition
from companion.flight_events.plans import PlannedAction, PlannedLasso
from companion.mission.facts import Fact

WHY = "no plan: patrol cannot hold from here."
ALARM = EventTurns("alarm", holds=True)


def plan(prefix: str, loop: str, way_s: float) -> PlannedLasso:
    steps = [
        tuple(PlannedAction(f"fly({place})", "fly", (place,), 4.0) for place in places)
        for places in (prefix, loop)
    ]
    return PlannedLasso(steps[0], steps[1], way_s, 4.0 * len(loop))


def table(*rows: tuple[int, Change, Answer]) -> ContingencyTable:
    positions = tuple(PlanPosition(n, "AB"[n % 2], f"fly({'BA'[n % 2]})", True) for n in range(3))
    found = tuple(Contingency(n, change, answer) for n, change, answer in rows)
    return ContingencyTable("two", "(fly(A), fly(B))^w", positions, found)


def test_equal_answers_are_one_line() -> None:
    """A lap is the same wherever it is entered, and whatever the way there takes."""
    anew = [
        Replans(plan("", "ABC", 0.0)),
        Replans(plan("C", "BCA", 5.0)),
        Replans(plan("", "CBA", 0.0)),
    ]
    (one, other) = table(*((n, ALARM, answer) for n, answer in enumerate(anew))).folded()
    assert (one.positions, other.positions) == ((0, 1), (2,))
    words = "lap of 12.0 s: fly(A), fly(B), fly(C); the way there 0.0 to 5.0 s"
    assert answers_in_words(one) == words


def test_changes_with_equal_answers_everywhere_are_one_line() -> None:
    rows = [(n, SiteLost(place), GoesOn()) for place in "ABCDEFGHIJ" for n in range(3)]
    (fold,) = table(*rows).folded()
    assert labels_in_words(fold).endswith("no way to H; and 2 more")
    assert positions_in_words(fold.positions) == "0-2"


def test_the_line_says_how_all_of_them_end() -> None:
    lands = [LandsAt("B", WHY), LandsAt("A", WHY), LandsAt("A", WHY, (), 0.5)]
    rows: list[tuple[int, Change, Answer]] = [(n, ALARM, answer) for n, answer in enumerate(lands)]
    rows += [(0, SiteLost("A"), GoesOn())]
    unsafe = (1, SiteLost("A"), LandsAt("A", WHY, (), 3.0, 1.0))
    found = table(*rows, unsafe)
    said = "5 contingencies: 1 planned, 1 end at A, 1 end at B, 1 land on the reserve, 1 unsafe"
    assert found.summary == said
    assert [each.position for each in found.unsafe] == [1]


@pytest.mark.parametrize(
    ("missing_wh", "short_wh", "words"),
    [
        (0.0, 0.0, ""),
        (0.4, 0.0, ", with 0.40 Wh of the reserve"),
        (3.0, 0.6, ", for which 0.60 Wh are missing although the reserve is used"),
    ],
)
def test_what_is_missing_is_told(missing_wh: float, short_wh: float, words: str) -> None:
    assert short_of(missing_wh, short_wh) == words
    lands = LandsAt("A", WHY, ("the map",), missing_wh, short_wh)
    (fold,) = table((0, ALARM, lands)).folded()
    waits = ", after waiting for the map (patrol cannot hold from here)"
    assert answers_in_words(fold) == f"lands at A{words}{waits}"


def test_what_follows_an_event_is_a_row_of_its_own() -> None:
    lost = BeliefLost(Fact.parse("ok(B)"))
    row = Contingency(1, lost, GoesOn(), after=ALARM)
    assert row.label == "alarm comes, then ok(B) withdrawn"
    assert json.loads(json.dumps(row.as_json())) == {
        "position": 1,
        "kind": "belief",
        "subject": "ok(B)",
        "after": "alarm",
        "contingency": "alarm comes, then ok(B) withdrawn",
        "verdict": "as_planned",
    }


def test_json_has_the_plan_or_the_place() -> None:
    found = table((0, ALARM, Replans(plan("A", "AB", 4.0), ("dock",), 20.0)))
    (told,) = found.as_json()["contingencies"]
    assert (told["verdict"], told["dropped"], told["waited_s"]) == ("lines_dropped", ["dock"], 20)
    assert (told["prefix_cost_s"], told["lap_cost_s"]) == (4.0, 8.0)
    found = table((0, ALARM, Replans(plan("A", "AB", 4.0), (), 0.0, 0.25)))
    (told,) = found.as_json()["contingencies"]
    assert (told["verdict"], told["of_reserve_wh"]) == ("on_reserve", 0.25)
    (fold,) = found.folded()
    assert answers_in_words(fold).endswith("the way there 4.0 s, with 0.25 Wh of the reserve")
    found = table((0, ALARM, LandsAt("A", WHY, (), 3.0, 1.0)))
    (told,) = found.as_json()["contingencies"]
    assert (told["lands_at"], told["of_reserve_wh"], told["missing_wh"]) == ("A", 2.0, 1.0)
    assert found.as_json()["verdicts"]["unsafe"] == 1
