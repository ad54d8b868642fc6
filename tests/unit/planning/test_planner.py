"""What the planner makes once, what changes between two plans, and what it refuses to hand out."""

from __future__ import annotations

import pytest
from synthetic import at_the_start, command, event, mission, planner

from companion.errors import CompanionError, NoPlanError
from companion.planning import planner as module
from companion.planning.lasso import Lasso

AT_H = frozenset({"at(H)"})


def test_a_line_of_the_task_is_split_into_conjuncts_of_its_name() -> None:
    made = planner(mission({"go": "G (F at(A) & F at(B))", "stay": "F at(H)"}))
    assert [(c.name, str(c.formula)) for c in made.conjuncts] == [
        ("go", "G F at(A)"),
        ("go", "G F at(B)"),
        ("stay", "F at(H)"),
    ]


def test_task_facts_are_what_the_formulas_mention() -> None:
    asked = mission("G (found -> F at(A))", events=[event("found"), event("low")])
    assert planner(asked).task_facts == {"found", "at(A)"}


def test_beliefs_hold_but_for_those_that_were_withdrawn() -> None:
    made = planner(mission("F at(A)"))
    problem = made.problem(AT_H, (), frozenset({"trans_ok(H, A)"}))
    assert problem.facts == AT_H | made.model.beliefs - {"trans_ok(H, A)"}


def test_between_two_problems_only_the_initial_state_differs() -> None:
    made = planner(mission("F at(A)"))
    first, _ = at_the_start(made)
    later = made.problem(frozenset({"at(B)"}), (frozenset({0}),))
    assert later.actions is first.actions
    assert later.conjuncts is first.conjuncts


def test_en_route_the_departures_come_first_with_their_beliefs() -> None:
    made = planner(mission("F at(A)"))
    problem = made.problem(frozenset({"at(here)"}), (), is_en_route=True)
    assert problem.actions[3:] == made.model.actions
    assert [a.name for a in problem.actions[:3]] == [
        "move(here, H)",
        "move(here, A)",
        "move(here, B)",
    ]
    assert "trans_ok(here, A)" in problem.facts


def test_a_plan() -> None:
    made = planner(mission("F at(A) & F at(B)"))
    assert str(made.plan(*at_the_start(made))) == "move(H, A), move(A, B), (wait)^w"


def test_no_plan_is_explained() -> None:
    made = planner(mission({"stay": "G at(H)", "go": "F at(A)"}))
    with pytest.raises(NoPlanError, match="stay, go cannot hold together"):
        made.plan(*at_the_start(made))


def test_a_wrong_plan_is_never_handed_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The independent check comes after the search, whatever the search does."""
    made = planner(mission("F done", skills=[command("do", "at(H)", "done")]))
    wait = made.model.actions[-1]
    monkeypatch.setattr(module, "find_lasso", lambda problem: Lasso((), (wait,)))
    with pytest.raises(CompanionError, match=r"wrong plan.*does not satisfy task"):
        made.plan(*at_the_start(made))
