"""Clocks of bounded lines, against the definition of each on 10,200 random timed words.

At equal steps rtamt is a further authority: Nickovic and Yamaguchi, RTAMT: online robustness
monitors from STL, ATVA 2020.
"""

from __future__ import annotations

from collections.abc import Callable
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
    for _ in range(170):
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


SPECIFICATIONS = {
    Within: "eventually[0:{limit}] (p >= 0.5)",
    Response: "always[0:{last}] ((a >= 0.5) implies (eventually[0:{limit}] (p >= 0.5)))",
    Revisit: "(eventually[0:{limit}] (p >= 0.5)) and "
    "always[0:{last}] ((p >= 0.5) implies (eventually[1:{limit}] (p >= 0.5)))",
}
STEPS = 16


def by_rtamt(kind: type[TimeBound], limit: int) -> Callable[[Timed], bool]:
    """The verdicts on words of `STEPS` positions, one a millisecond, after which p holds."""
    rtamt = pytest.importorskip("rtamt")
    specification = rtamt.StlDiscreteTimeSpecification()
    for name in "ap":
        specification.declare_var(name, "float")
    specification.spec = SPECIFICATIONS[kind].format(limit=limit, last=STEPS - 1)
    specification.parse()

    def verdict(word: Timed) -> bool:
        signals = {name: [float(name in letter) for _, letter in word] for name in "ap"}
        times = [time for time, _ in word]
        return bool(specification.evaluate({"time": times, **signals})[0][1] > 0)

    return verdict


@pytest.mark.parametrize("limit", [1, 2, 3, 5, 9, 15])
def test_rtamt_says_the_same_at_equal_steps(limit: int) -> None:
    random = Random(limit)
    bounds = Within(P, limit), Response(P, limit, A), Revisit(P, limit)
    verdicts = set()
    for bound in bounds:
        asked = by_rtamt(type(bound), limit)
        for _ in range(100):
            share = random.choice((0.1, 0.35, 0.7, 0.95))
            letters = [
                frozenset(name for name in "ap" if random.random() < share) for _ in range(STEPS)
            ]
            word = list(enumerate([*letters, *[frozenset("p")] * limit]))
            verdict = asked(word)
            assert by_clock(bound, word) is verdict, (bound, word)
            verdicts.add((type(bound), verdict))
    assert len(verdicts) == 6
