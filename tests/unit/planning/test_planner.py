"""What the planner makes once, what changes between two plans, and what it refuses to hand out."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import pytest
from meadow import DATA
from reference_search import best_lap_and_prefix
from synthetic import command, event, facts_of, mission, move, planner

from companion.errors import CompanionError, NoPlanError
from companion.ltl.automaton import successors
from companion.ltl.budget import Budget, TranslationLimit
from companion.mission.loader import load_mission
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT, Effort
from companion.planning.explain import NoPlan
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Objective
from companion.planning.planner import Planner

SHIPPED = "missions/surveillance.yaml"

AT_H = facts_of("at(H)")


def test_a_line_of_the_task_is_split_into_conjuncts_of_its_name() -> None:
    made = planner(mission({"go": "G (F at(A) & F at(B))", "stay": "F at(H)"}))
    assert [(c.name, str(c.formula)) for c in made.conjuncts] == [
        ("go", "G F at(A)"),
        ("go", "G F at(B)"),
        ("stay", "F at(H)"),
    ]


def test_all_lines_of_a_task_share_a_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each line costs 25,000 steps at least; the line at which they are spent is named."""
    asked = mission({f"l{i}": "F at(A)" for i in range(5)})
    monkeypatch.setattr(Budget, "of_a_mission", lambda: Budget(steps=80_000))
    with pytest.raises(
        TranslationLimit, match=r"^task\.l[23]: .* all lines of the task share\n.* 9"
    ):
        planner(asked)


def test_a_line_that_is_too_large_by_itself_is_told_where_it_stands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The advice is for this line, and not for those before it."""
    monkeypatch.setattr(Budget, "of_a_mission", lambda: Budget(steps=1))
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [29, -9], [29, 9], [-9, 9]]}
    data = DATA | {"limits": limits}
    goal = {key: value for key, value in data.items() if key != "task"} | {"goal": "at(A)"}
    for source, where in ((SHIPPED, f"{SHIPPED}:73:11"), (data, "task.visit"), (goal, "goal")):
        with pytest.raises(TranslationLimit) as caught:
            Planner(load_mission(source))
        place, advice = str(caught.value).split(": the automaton would take more than 1 steps of ")
        assert (
            place == where and advice == "work\n    write it with fewer operators or propositions"
        )


def test_task_facts_are_what_the_formulas_mention() -> None:
    asked = mission("G (found -> F at(A))", events=[event("found"), event("low")])
    assert planner(asked).task_facts == {"found", "at(A)"}


def test_beliefs_hold_but_for_those_that_were_withdrawn() -> None:
    made = planner(mission("F at(A)"))
    problem = made.problem(AT_H, (), facts_of("trans_ok(H, A)"))
    assert problem.facts == AT_H | made.actions.model.beliefs - {"trans_ok(H, A)"}


def test_between_two_problems_only_the_initial_state_differs() -> None:
    made = planner(mission("F at(A)"))
    first, _ = made.initial_problem()
    later = made.problem(facts_of("at(B)"), (frozenset({0}),))
    assert later.actions is first.actions
    assert later.conjuncts is first.conjuncts


def test_en_route_the_departures_come_last_with_their_beliefs() -> None:
    """So the mission's own actions keep their places from plan to plan."""
    made = planner(mission("F at(A)"))
    problem = made.problem(facts_of("at(here)"), (), is_en_route=True)
    own = len(made.actions.model.actions)
    assert problem.actions[:own] == made.actions.model.actions
    assert [a.name for a in problem.actions[own:]] == [
        "move(here, H)",
        "move(here, A)",
        "move(here, B)",
    ]
    assert "trans_ok(here, A)" in problem.facts


def test_a_withdrawn_belief_about_here_is_not_held() -> None:
    made = planner(mission("F at(A)"))
    withdrawn = facts_of("trans_ok(here, A)", "trans_ok(H, A)")
    assert made.problem(AT_H, (), withdrawn).withdrawn == {"trans_ok(H, A)"}
    problem = made.problem(facts_of("at(here)"), (), withdrawn, is_en_route=True)
    assert problem.withdrawn == withdrawn
    assert not problem.facts & withdrawn


def test_a_plan() -> None:
    made = planner(mission("F at(A) & F at(B)"))
    assert str(made.plan()) == "move(H, A), move(A, B), (wait)^w"


TASKS = [
    "F at(A) & F at(B)",
    "G F at(A) & G F at(B) & G F at(H)",
    "F (at(A) & F (at(B) & F at(H)))",
    "G (at(A) -> X !at(A) U at(B)) & G F at(A)",
    "G (F at(A) | found) & G (found -> F at(H))",
    "(!at(B) U at(A)) & F at(B)",
]


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("flown", ["", "A", "AB", "ABHA"])
@pytest.mark.parametrize("found", [False, True])
def test_interrupted_on_the_way_it_plans_from_there_and_forgets_nothing(
    task: str, flown: str, found: bool
) -> None:
    """What was flown and what is planned are one word, and it satisfies the task."""
    made = planner(mission(task, events=[event("found")]))
    events = facts_of(*(["found"] if found else []))
    letters = [facts_of(f"at({place})") | made.actions.model.beliefs for place in f"H{flown}"]
    states = [c.automaton.initial for c in made.conjuncts]
    for letter in letters:
        states = [
            successors(c.automaton, s, letter) for c, s in zip(made.conjuncts, states, strict=True)
        ]
    here = facts_of("at(here)") | events
    problem = made.problem(here, tuple(states), is_en_route=True)
    histories = [letters for _ in made.conjuncts]
    best = made.solver.solve(problem, histories).lasso
    assert best_lap_and_prefix(problem) == (best.lap_cost_ms, best.prefix_cost_ms)
    for lasso in (best, made.solver.replan(problem, histories)):
        assert lasso is not None and fault(problem, lasso, histories) is None
        assert not lasso.prefix or lasso.prefix[0].name.startswith("move(here, ")
        assert not any("here" in action.name for action in (*lasso.prefix[1:], *lasso.loop))


def test_a_replan_is_the_first_plan_and_a_plan_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    made = planner(mission("F at(A)", places="HA"))
    go, back, wait = made.actions.model.actions
    plans = [Lasso((go, back, go), (wait,)), Lasso((go,), (wait,))]
    offered = [Solution(plan, Objective.LAP, 100, 100, "test") for plan in plans]
    monkeypatch.setattr(Search, "solutions", lambda *args: iter(offered))
    assert made.solver.replan(*made.initial_problem()) == plans[0]
    assert made.plan().lasso == plans[1]
    assert list(made.solver.solutions(*made.initial_problem())) == offered


def test_in_flight_less_is_tried_than_before(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = []
    solutions = Search.solutions

    def spied(search: Search, problem: Problem, objective: Objective, effort: Effort) -> Any:
        tried.append(effort)
        return solutions(search, problem, objective, effort)

    monkeypatch.setattr(Search, "solutions", spied)
    made = planner(mission("F at(A)"))
    made.plan()
    made.solver.replan(*made.initial_problem())
    assert tried == [BEFORE_FLIGHT, IN_FLIGHT]
    assert IN_FLIGHT.product_edges < BEFORE_FLIGHT.product_edges
    assert IN_FLIGHT.dijkstra_steps < BEFORE_FLIGHT.dijkstra_steps
    assert IN_FLIGHT.held_karp_additions < BEFORE_FLIGHT.held_karp_additions


def test_the_objective_is_passed_on() -> None:
    made = planner(mission("G F (at(A) & X at(H)) | G F at(B)"))
    by_sum = list(made.solver.solutions(*made.initial_problem(), Objective.SUM))[-1]
    by_lap = list(made.solver.solutions(*made.initial_problem()))[-1]
    assert (by_sum.objective, by_lap.objective) == (Objective.SUM, Objective.LAP)
    assert by_lap.cost_ms == 100 < by_sum.lasso.lap_cost_ms + by_sum.lasso.prefix_cost_ms


def test_no_plan_is_explained() -> None:
    made = planner(mission({"stay": "G at(H)", "go": "F at(A)"}))
    with pytest.raises(NoPlanError, match="stay, go cannot hold together") as caught:
        made.plan()
    assert isinstance(caught.value, NoPlan)
    assert [c.name for c in caught.value.explanation.conflict] == ["stay", "go"]

    problem, histories = made.initial_problem()
    assert made.solver.replan(problem, histories) is None
    assert made.solver.explain_soon(problem) == caught.value.explanation


LIMITS = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
FOUND = {"found": {"when": "COMMAND.MAV_CMD_USER_1"}}


def test_in_flight_a_charge_that_is_too_little_is_told_and_no_event() -> None:
    about = {"limits": LIMITS, "events": FOUND, "battery": {"reserve": 20}}
    task = {"go": "F at(A) & G (found -> F at(Home))"}
    made = Planner(load_mission(DATA | about | {"task": task}))
    problem, _ = made.initial_problem()
    assert problem.energy is not None
    little = replace(problem.energy, level=problem.energy.floors["Home"] + 1)
    told = str(made.solver.explain_soon(replace(problem, energy=little)))
    assert re.search(r"\n  the charge, 2\d %, is too little$", told)


def test_in_flight_a_bound_that_comes_too_soon_is_told_and_no_event() -> None:
    task = {"go": "G (found -> F at(Home))", "soon": "F[<=3s] at(A)"}
    made = Planner(load_mission(DATA | {"limits": LIMITS, "events": FOUND, "task": task}))
    told = str(made.solver.explain_soon(made.initial_problem()[0]))
    assert told.endswith("\n  F[<=3s] at(A) cannot be kept in time from here")


def test_it_is_explained_without_a_plan_alone() -> None:
    made = planner(mission({"go": "F at(A)"}, skills=[move(precondition="at(from) & !shut")]))
    assert made.explain() is None
    reason = made.explain(facts={"shut"})
    assert reason is not None
    assert [conjunct.name for conjunct in reason.conflict] == ["go"]
    blocked = {f"trans_ok({place}, A)" for place in "HB"}
    reason = made.explain(without=blocked)
    assert reason is not None
    assert set(reason.restoring) == blocked


def test_flight_times_are_those_of_the_map_unless_others_are_given() -> None:
    asked = mission("F at(B)")
    assert str(Planner(asked).plan()) == "move(H, B), (wait)^w"
    table = {("H", "A"): 1.0, ("A", "B"): 1.0}
    assert str(Planner(asked, table).plan()) == "move(H, A), move(A, B), (wait)^w"
    detour = Planner(asked, lambda origin, goal: 9.0 if (origin, goal) == ("H", "B") else 1.0)
    assert str(detour.plan()) == "move(H, A), move(A, B), (wait)^w"


def test_a_plan_is_a_prefix_and_a_loop_with_their_costs() -> None:
    plan = planner(mission("F at(A)")).plan()
    assert [action.name for action in plan.prefix] == ["move(H, A)"]
    assert [action.name for action in plan.loop] == ["wait"]
    assert (plan.prefix_cost_s, plan.lap_cost_s) == (4.0, 0.1)
    assert (plan.cost_s, plan.bound_s, plan.is_optimal) == (0.1, 0.1, True)
    assert plan.as_json()["optimal"]


def test_a_wrong_plan_is_never_handed_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The independent check comes after the search, whatever the search does."""
    made = planner(mission("F done", skills=[command("do", "at(H)", "done")]))
    wait = made.actions.model.actions[-1]
    wrong = Solution(Lasso((), (wait,)), Objective.LAP, 100, 100, "test")
    monkeypatch.setattr(Search, "solutions", lambda *args: iter([wrong]))
    for ask in (made.solver.solve, made.solver.replan):
        with pytest.raises(CompanionError, match=r"wrong plan.*does not satisfy task"):
            ask(*made.initial_problem())


def test_what_it_takes_is_measured_by_the_clock_it_is_given() -> None:
    ticks = iter([10.0, 10.5, 13.0])
    made = Planner(mission("F at(A)"), lambda origin, goal: 4.0, lambda: next(ticks))
    assert (made.instantiating_s, made.translating_s) == (0.5, 2.5)
    assert planner(mission("F at(A)")).translating_s == 0.0


# -- a map that changes ----------------------------------------------------------------------------


def test_moves_cost_what_they_cost_now_and_none_is_planned_without_a_route() -> None:
    asked = mission("F at(B)")
    seconds = {("H", "B"): 8.0}
    made = Planner(asked, lambda origin, goal: seconds.get((origin, goal), 3.0))
    assert str(made.plan()) == "move(H, A), move(A, B), (wait)^w"
    beliefs, actions = made.actions.model.beliefs, made.actions.model.actions
    seconds |= {("H", "B"): 5.0, ("H", "A"): math.inf}
    made.reinstantiate()
    assert str(made.plan()) == "move(H, B), (wait)^w"
    assert made.actions.model.beliefs == beliefs
    assert "move(H, A)" not in {a.name for a in made.actions.model.actions}
    assert [a for a in made.actions.model.actions if a.name == "move(A, B)"] == [
        a for a in actions if a.name == "move(A, B)"
    ]
    seconds |= {("H", "B"): 8.0, ("H", "A"): 3.0}
    made.reinstantiate()
    assert made.actions.model.actions == actions
    assert str(made.plan()) == "move(H, A), move(A, B), (wait)^w"


def test_moves_that_no_longer_exist_are_no_way_out() -> None:
    seconds: dict[tuple[str, str], float] = {}
    made = Planner(mission("F at(B)"), lambda origin, goal: seconds.get((origin, goal), 3.0))
    seconds |= {(origin, "B"): math.inf for origin in "HAC"}
    made.reinstantiate()
    with pytest.raises(NoPlanError):
        made.plan()
