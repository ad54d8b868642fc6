"""Clocks of bounded lines, against the definition of each on random timed words."""

from __future__ import annotations

from random import Random

import pytest

from companion.ltl.formula import Formula
from companion.ltl.parser import atom
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within

A, P = atom("a"), atom("p")
Timed = list[tuple[int, frozenset[str]]]
"""Positions: when each is reached, and what holds there."""


def in_time(bound: TimeBound, word: Timed) -> bool:
    """By the definition: nothing of a finite word is too late."""
    last = word[-1][0]

    def is_answered(start_ms: int, after: int) -> bool:
        due = start_ms + bound.limit_ms
        return due >= last or any(t <= due and "p" in letter for t, letter in word[after:])

    match bound:
        case Within():
            return is_answered(word[0][0], 0)
        case Response():
            asked = [(t, i) for i, (t, letter) in enumerate(word) if "a" in letter]
            return all(is_answered(t, i) for t, i in asked)
        case _:
            visits = [(t, i + 1) for i, (t, letter) in enumerate(word) if "p" in letter]
            return all(is_answered(t, i) for t, i in [(word[0][0], 0), *visits])


def by_clock(bound: TimeBound, word: Timed) -> bool:
    """By the clock of the bound."""
    clock, before = bound.begin(), word[0][0]
    for time_ms, letter in word:
        clock = None if clock is None else clock + time_ms - before
        if bound.is_late(clock):
            return False

        def is_true(formula: Formula, letter: frozenset[str] = letter) -> bool:
            return formula.atom in letter

        clock, before = bound.after(clock, is_true), time_ms
    return True


@pytest.mark.parametrize("seed", range(20))
def test_a_clock_is_late_where_the_definition_says_so(seed: int) -> None:
    random = Random(seed)
    verdicts = set()
    for _ in range(150):
        time_ms, word = random.randrange(50), []
        for _ in range(random.randint(1, 12)):
            letter = frozenset(name for name in "ap" if random.random() < 0.35)
            word.append((time_ms, letter))
            time_ms += random.randint(1, 30)
        limit = random.randint(1, 90)
        bounds = Within(P, limit), Response(P, limit, A), Revisit(P, limit)
        for bound in bounds:
            verdict = in_time(bound, word)
            assert by_clock(bound, word) is verdict, (bound, word)
            verdicts.add((type(bound), verdict))
    assert len(verdicts) == 6
