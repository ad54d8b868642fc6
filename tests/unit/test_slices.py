"""Work in slices: put aside at any depth, abandoned anywhere, and the same in the end."""

from __future__ import annotations

import gc
import random
import weakref
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from problems import surveillance, unit_legs
from random_missions import random_mission

from companion import slices
from companion.errors import SearchLimit
from companion.planning.builtin.search import Search
from companion.planning.effort import IN_FLIGHT
from companion.planning.lasso import Problem, Solution
from companion.slices import Answered, InSlices, Question, ask_once, spent, wait_a_tick


def counted(steps: int, done: list[int]) -> Callable[[], int]:
    """Work of half a slice a step."""

    def step(number: int) -> None:
        done.append(number)
        spent(slices.SLICE_US / 2)

    def work() -> int:
        for number in range(steps):
            step(number)
        return steps

    return work


def test_a_slice_ends_in_the_middle_of_the_work() -> None:
    done: list[int] = []
    work = InSlices(counted(5, done))
    assert [(work.step(), len(done)) for _ in range(3)] == [(False, 2), (False, 4), (True, 5)]
    assert work.step() and work.result == 5


def test_outside_of_slices_work_is_done_at_once() -> None:
    assert counted(99, [])() == 99
    with pytest.raises(RuntimeError, match="in slices"):
        wait_a_tick()


def test_an_error_of_the_work_is_one_of_its_slice() -> None:
    def work() -> None:
        wait_a_tick()
        raise SearchLimit("2 ticks")

    failing = InSlices(work)
    assert not failing.step()
    with pytest.raises(SearchLimit, match="2 ticks"):
        failing.step()


def test_what_is_abandoned_is_cleared_up() -> None:
    cleared = []

    def work() -> None:
        try:
            wait_a_tick()
        finally:
            cleared.append(True)

    begun, not_begun = InSlices(work), InSlices(work)
    begun.step()
    for abandoned in (begun, not_begun, begun):
        abandoned.abandon()
        assert abandoned.step()
    assert cleared == [True]


def test_works_take_turns() -> None:
    done: list[int] = []
    works = [InSlices(counted(4, done)) for _ in range(2)]
    assert [work.step() for work in (*works, *works)] == [False, False, False, False]
    assert done == [0, 1, 0, 1, 2, 3, 2, 3]
    assert [work.step() for work in works] == [True, True]


def test_another_question_is_asked_anew() -> None:
    done: list[int] = []
    question = Question[int]()
    assert question.ask("a", counted(3, done)) is None
    assert question.ask("b", counted(3, done)) is None
    assert question.ask("b", counted(3, done)) == Answered(3)
    assert done == [0, 1, 0, 1, 2]
    assert question.ask("b", counted(1, done)) == Answered(1)  # it is not remembered


def test_what_has_to_be_known_at_once_may_take_a_slice() -> None:
    assert ask_once(counted(1, [])) == 1
    assert ask_once(counted(2, [])) is None


def plans(search: Search, problem: Problem) -> list[Solution]:
    return list(search.solutions(problem))


@given(st.integers(0, 10**6), st.integers(0, 30))
def test_plans_are_the_same_in_slices_also_after_others_were_abandoned(
    seed: int, abandoned_after: int
) -> None:
    """What a search keeps from plan to plan is right, wherever one was put aside for good."""
    problem, _ = random_mission(random.Random(seed))
    expected = plans(Search(problem.actions[:-1]), problem)
    search = Search(problem.actions[:-1])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(slices, "SLICE_US", 30)
        first = InSlices(lambda: plans(search, problem))
        for _ in range(abandoned_after):
            first.step()
        first.abandon()
        second = InSlices(lambda: plans(search, problem))
        while not second.step():
            pass
    assert second.result == expected


@pytest.mark.parametrize("sites", [15, 60])
def test_no_step_of_a_search_takes_half_a_slice(sites: int) -> None:
    """As rated: with 15 sites the tables of an exact tour are filled, with 60 it is a good one."""
    problem = surveillance(sites, unit_legs(["H", *(f"s{i}" for i in range(sites))]))
    searching = InSlices(lambda: next(Search().solutions(problem, effort=IN_FLIGHT)))
    ended_at_us = []
    while not searching.step():
        ended_at_us.append(searching._routine.left_us)
    assert len(ended_at_us) > 2
    assert all(-slices.SLICE_US / 2 < left_us <= 0 for left_us in ended_at_us)


class Held:
    """What some work refers to."""


def test_what_is_put_aside_at_the_end_of_a_flight_is_let_go_of() -> None:
    """A suspended coroutine is not looked through for garbage: what it holds would be left."""

    def put_aside() -> weakref.ref[Held]:
        held = Held()
        cycle: list[object] = [held]

        def work() -> int:
            spent(2 * slices.SLICE_US)
            return len(cycle)

        working = InSlices(work)
        cycle.append(working)
        assert not working.step()
        return weakref.ref(held)

    left = put_aside()
    gc.collect()
    assert left() is not None, "else there is no need for it"
    slices.abandon_all()
    gc.collect()
    assert left() is None
