"""Every mission pattern, asked for as a task: the plan is what the pattern means, or there is none.

The missions are flown on one of two small maps, H where they begin:

    open:      every place has a way to every other
    corridor:  H -- B -- A -- C, and no other ways

`work` at B makes `done` true, and `call` at H makes `answered` true. On the open map `dock` leads
from H to A as well, and makes `docked` true. All flights take equally long, and of equal plans
the one whose places come first in H, A, B, C is taken, so it is known what the plan has to be.
It passes the independent check before the planner hands it out. Here it is written as the places
that are flown to, and `.` for rest.

Source: Menghi, Tsigkanos, Pelliccione, Ghezzi, Berger, Specification Patterns for Robotic
Missions, IEEE Transactions on Software Engineering, 2021.
"""

from __future__ import annotations

import math

import pytest
from synthetic import command, mission

from companion.errors import NoPlanError
from companion.ltl.patterns import PATTERNS
from companion.planning.domain import Action
from companion.planning.planner import Planner

OPEN, CORRIDOR = "HABC", "HBAC"

PLANS = {
    # task: (map, prefix, loop); why
    "visit(A, B, C)": (OPEN, "A B C", "."),
    "visit(C, B)": (CORRIDOR, "B A C", "."),
    "sequenced_visit(C, A, B)": (OPEN, "C A B", "."),
    "sequenced_visit(A, B)": (CORRIDOR, "B A B", "."),  # B before A does not count
    "ordered_visit(C, A, B)": (OPEN, "C A B", "."),
    "ordered_visit(B, A) & F at(C)": (CORRIDOR, "B A C", "."),
    "strict_ordered_visit(C, A, B)": (OPEN, "C A B", "."),
    "strict_ordered_visit(B, C)": (CORRIDOR, "B A C", "."),
    "fair_visit(A, B)": (OPEN, "A B H", "."),  # to stay at B would be a second visit
    "fair_visit(A, B) & F (at(B) & X F at(B))": (OPEN, "B A B H", "."),  # and A in between
    "patrolling(A, B, C)": (OPEN, "A", "B C A"),
    "patrolling(B, C)": (CORRIDOR, "B", "A C A B"),
    "sequenced_patrolling(C, B, A)": (OPEN, "A", "B C A"),  # C B A is met within two laps
    "ordered_patrolling(C, B, A)": (OPEN, "C", "B A C"),
    "strict_ordered_patrolling(C, B, A)": (OPEN, "C", "B A C"),
    "fair_patrolling(C, B, A)": (OPEN, "A", "C B A"),
    "past_avoidance(A, done) & F at(A)": (OPEN, "B work A", "."),
    "global_avoidance(B) & F at(C)": (OPEN, "C", "."),
    "global_avoidance(A, C) & F done": (CORRIDOR, "B work", "."),
    "future_avoidance(done, A) & F at(A) & F done": (OPEN, "A B work", "."),
    "upper_restricted_avoidance(A, 1) & F at(A)": (OPEN, "A H", "."),  # to stay is a second visit
    "upper_restricted_avoidance(A, 2) & F (at(A) & X F at(A))": (OPEN, "A . H", "."),
    "lower_restricted_avoidance(A, 3)": (OPEN, "A", "."),
    "lower_restricted_avoidance(A, 2) & G (at(A) -> X !at(A))": (OPEN, "A H A H", "."),
    "exact_restricted_avoidance(A, 2)": (OPEN, "A . H", "."),
    "exact_restricted_avoidance(B, 1) & F at(A)": (CORRIDOR, "B A", "."),
    "instantaneous_reaction(done, at(B)) & F done": (OPEN, "B work", "."),
    "instantaneous_reaction(at(C), done) & F at(C)": (OPEN, "B work C", "."),
    "delayed_reaction(done, at(C)) & F done": (CORRIDOR, "B work A C", "."),
    "prompt_reaction(done, at(A)) & F done": (OPEN, "B work A", "."),
    "prompt_reaction(at(B), at(C)) & F at(B)": (OPEN, "B C", "."),
    "bound_reaction(at(A), docked) & F at(A)": (OPEN, "dock", "."),
    "bound_reaction(at(A), docked) & G !at(A)": (OPEN, "", "."),
    "bound_delay(at(A), at(B)) & F at(A)": (OPEN, "A B H", "."),  # B only right after A
    "bound_delay(at(A), at(B)) & G F at(A)": (OPEN, "A", "B A"),
    "wait(H, answered) & F at(A)": (OPEN, "call A", "."),
    "wait(H, at(B)) & F at(B)": (OPEN, "B", "."),
}

NO_PLANS = {
    # task: (map, the lines that conflict); the reason
    "go: ordered_visit(A, B)": (CORRIDOR, "go"),  # the way to A leads through B
    "go: strict_ordered_visit(A, C) ; first: !at(C) U (at(A) & X (!at(C) U at(H)))": (
        CORRIDOR,
        "go, first",  # A would be visited twice before C
    ),
    "go: ordered_patrolling(B, A, C)": (CORRIDOR, "go"),  # the way back from C leads through A
    "go: strict_ordered_patrolling(B, A, C)": (CORRIDOR, "go"),  # as well
    "go: fair_patrolling(B, A, C)": (CORRIDOR, "go"),  # A is visited twice a lap
    "go: fair_visit(B, A) ; on: F at(C) & F G at(H)": (CORRIDOR, "go, on"),  # B again before A
    "never: past_avoidance(B, done) ; go: F done": (OPEN, "never"),  # done is made at B
    "never: global_avoidance(A) ; go: F at(C)": (CORRIDOR, "never, go"),  # the way leads through A
    "never: future_avoidance(done, B) ; go: F done": (OPEN, "never, go"),  # done is made at B
    "once: upper_restricted_avoidance(A, 1) ; go: F (at(C) & F at(B))": (CORRIDOR, "once, go"),
    "once: exact_restricted_avoidance(A, 1) ; go: F (at(C) & F at(B))": (CORRIDOR, "once, go"),
    "often: lower_restricted_avoidance(A, 3) ; once: upper_restricted_avoidance(A, 2)": (
        OPEN,
        "often, once",
    ),
    "react: instantaneous_reaction(at(A), lit) ; go: F at(A)": (OPEN, "react, go"),  # no lamp
    "react: delayed_reaction(at(A), lit) ; go: F at(A)": (OPEN, "react, go"),
    "react: prompt_reaction(at(B), at(C)) ; go: F at(B)": (CORRIDOR, "react, go"),  # not adjacent
    "bound: bound_reaction(at(A), at(B)) ; go: F at(A)": (OPEN, "bound, go"),  # one place at a time
    "bound: bound_delay(at(B), at(C)) ; go: F at(B)": (CORRIDOR, "bound, go"),  # not adjacent
    "stay: wait(H, done)": (OPEN, "stay"),  # done is made elsewhere
}


def planner(task: dict[str, str], order: str) -> Planner:
    skills = [
        command("work", "at(B)", "done"),
        command("call", "at(H)", "answered"),
        *[command("dock", "at(H)", "at(A) & docked & !at(H)", cost_s=9.0)] * (order == OPEN),
    ]
    asked = mission(task, places="HABC", skills=skills)

    def flight_time(origin: str, goal: str) -> float:
        is_next = abs(order.index(origin) - order.index(goal)) == 1
        return 4.0 if order == OPEN or is_next else math.inf

    return Planner(asked, flight_time)


def written(actions: tuple[Action, ...]) -> str:
    """The goal of a flight, the name of any other skill, and . for rest."""
    return " ".join(
        "." if action.skill == "wait" else action.name.removesuffix(")").split(", ")[-1]
        for action in actions
    )


@pytest.mark.parametrize("task", PLANS)
def test_the_plan_is_what_the_pattern_means(task: str) -> None:
    order, prefix, loop = PLANS[task]
    made = planner({"task": task}, order)
    lasso = made.plan().lasso
    assert (written(lasso.prefix), written(lasso.loop)) == (prefix, loop)
    assert made.solver.replan(*made.initial_problem()) == lasso


@pytest.mark.parametrize("task", NO_PLANS)
def test_where_the_world_has_no_room_for_a_pattern_it_is_named(task: str) -> None:
    order, named = NO_PLANS[task]
    lines = dict(line.strip().split(": ", 1) for line in task.split(";"))
    made = planner(lines, order)
    with pytest.raises(NoPlanError, match=f"no plan: {named} cannot hold"):
        made.plan()


def test_every_pattern_has_been_planned() -> None:
    assert {task.partition("(")[0] for task in PLANS} == set(PATTERNS)
