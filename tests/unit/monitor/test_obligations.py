"""What is still due: goals of a lap, demands of other lines, and neither of what is dropped."""

from __future__ import annotations

from companion.ltl.conjuncts import conjuncts
from companion.ltl.parser import parse
from companion.mission.facts import at
from companion.monitor.obligations import Obligations

PATROL = [("patrol", parse(f"G F at({place})")) for place in "AB"]


def read(obligations: Obligations, *facts: str) -> list[str]:
    obligations.read(frozenset(facts), ())
    return [words for _, words in obligations.due]


def test_a_goal_is_due_once_in_a_lap() -> None:
    due = Obligations(PATROL)
    assert due.due == (("patrol", "A, B still due in this lap"),)
    assert read(due, at("A")) == ["B still due in this lap"]
    assert read(due, at("A")) == ["B still due in this lap"]
    assert read(due, at("B")) == []
    assert read(due, at("A")) == ["B still due in this lap"], "another lap"


def test_goals_of_one_line_are_told_together_with_what_may_be_done_instead() -> None:
    line = parse("G F at(A) & G F at(B) & G F at(C) | F called")
    due = Obligations([("patrol", part) for part in conjuncts(line)])
    assert read(due, at("A")) == ["B, C still due in this lap, or called"]
    assert read(due, at("C")) == ["B still due in this lap, or called"]
    assert read(due, "called") == []
    assert read(due) == []


def test_an_answer_is_due_after_its_question_alone() -> None:
    due = Obligations(
        [("answer", parse("G (asked -> F told)")), ("home", parse("G (told -> X at(Home))"))]
    )
    assert due.due == ()
    assert read(due, "asked") == read(due) == ["told still due"]
    assert read(due, "told") == ["Home due at the next position"]
    assert read(due, at("Home")) == []


def test_rules_are_not_due_nor_is_what_is_dropped_or_begins_anew() -> None:
    due = Obligations([*PATROL, ("rule", parse("G !at(D)")), ("once", parse("F at(C)"))])
    due.drop("once", True)
    assert read(due, at("A")) == ["B still due in this lap"]
    due.drop("once", False)
    assert read(due) == ["B still due in this lap", "C still due"]
    due.read(frozenset({at("C")}), ())
    assert ("once", "C still due") not in due.due
    due.read(frozenset(), ("once",))
    assert ("once", "C still due") in due.due


def test_goals_of_a_line_that_begins_anew_are_due_again() -> None:
    """Those of other lines are not: the lap goes on."""
    due = Obligations([*PATROL, ("watch", parse("G F at(C) & G F at(D) | F called"))])
    for place in "ACB":
        read(due, at(place))
    assert due.due == (("watch", "D still due in this lap, or called"),)
    due.read(frozenset({at("Home")}), ("watch",))
    assert due.due == (("watch", "C, D still due in this lap, or called"),)
    assert read(due, "called") == []
    due.read(frozenset({at("C")}), ("watch",))
    assert [*due.due][1:] == [("watch", "D still due in this lap, or called")], "another lap"
