"""Another rate is found where there is one, and never where there is none, whatever a link does."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.vehicle.clock_rate import NEARLY, PAIRS, ClockAnswer, ClockRate

DELAYS_S = st.floats(0.0, 3.0)
WAITS_S = st.floats(0.1, 5.0)
WIRES = st.lists(st.tuples(WAITS_S, DELAYS_S, DELAYS_S), min_size=1, max_size=40)
"""Of questions: after which time each is asked, how long it is under way, and its answer."""


def answers(wire: list[tuple[float, float, float]], rate: float) -> list[ClockAnswer]:
    """Of a clock that runs at a rate."""
    found, now_s = [], 1000.0
    for wait_s, there_s, back_s in wire:
        now_s += wait_s
        found.append(ClockAnswer(now_s, now_s + there_s + back_s, rate * (now_s + there_s)))
    return found


def news(rate: ClockRate, taken: list[ClockAnswer]) -> list[float]:
    """What is found, as each answer is taken."""
    found = []
    for answer in taken:
        rate.take(answer)
        if (each := rate.take_news()) is not None:
            found.append(each)
    return found


@given(WIRES, st.floats(1.0 - NEARLY, 1.0 + NEARLY))
def test_no_link_makes_another_rate_of_ours(
    wire: list[tuple[float, float, float]], rate: float
) -> None:
    assert news(ClockRate(), answers(wire, rate)) == []


@given(WIRES, st.floats(0.05, 20.0))
def test_what_is_found_is_on_the_right_side(
    wire: list[tuple[float, float, float]], rate: float
) -> None:
    """And within what the slowest questions leave open."""
    for found in news(ClockRate(), answers(wire, rate)):
        assert math.copysign(1.0, found - 1.0) == math.copysign(1.0, rate - 1.0)


@pytest.mark.parametrize("rate", [0.05, 0.5, 0.85, 1.2, 2.0, 4.0, 20.0])
@pytest.mark.parametrize("way_s", [0.0, 0.01, 0.02])
def test_the_rate_of_a_simulator_is_found_after_three_seconds(rate: float, way_s: float) -> None:
    """Answers come with the next tick, 0.05 s later at most."""
    wire = [(1.0, way_s, way_s + 0.0125 * i) for i in range(PAIRS + 1)]
    (found,) = news(ClockRate(), answers(wire, rate))
    assert found == pytest.approx(rate, rel=0.01)


@pytest.mark.parametrize("rate", [0.25, 4.0])
def test_a_computer_that_was_suspended_twice_goes_by_its_own_clock(rate: float) -> None:
    """Its clock stands meanwhile; or the autopilot's does."""
    before = answers([(1.0, 0.01, 0.01)] * 10, 1.0)
    again = [ClockAnswer(a + 30.0, h + 30.0, b + 30.0 * rate) for a, h, b in before]
    later = [ClockAnswer(a + 60.0, h + 60.0, b + 60.0 * rate) for a, h, b in before]
    assert news(ClockRate(), before + again + later) == []


def test_what_a_clock_showed_before_it_stepped_back_does_not_count() -> None:
    """Its rate is found from what it shows since."""
    taken = answers([(1.0, 0.01, 0.01)] * 7, 0.5)
    since = [answer._replace(boot_s=answer.boot_s - 0.6) for answer in taken[3:]]
    assert news(ClockRate(), taken[:3] + since) == pytest.approx([0.5])


def test_one_that_is_followed_is_followed_where_it_changes() -> None:
    """Its answers come by a clock that has the rate that was found."""
    rate = ClockRate()
    assert news(rate, answers([(1.0, 0.01, 0.01)] * 4, 4.0)) == pytest.approx([4.0])
    last = 4.0 * 1004.01
    followed = [ClockAnswer(1004.02 + i, 1004.03 + i, last + i) for i in range(1, 10)]
    assert news(rate, followed) == []
    end = followed[-1]
    slower = [
        ClockAnswer(end.asked_s + i, end.heard_s + i, end.boot_s + 0.5 * i)
        for i in range(1, PAIRS + 1)
    ]
    assert news(rate, slower) == pytest.approx([0.5], rel=0.01)


@pytest.mark.parametrize("rate", [0.0, 1e-6, 1e-3, 1e3])
def test_a_clock_that_stands_or_counts_in_other_units_is_not_followed(rate: float) -> None:
    clock = ClockRate()
    assert news(clock, answers([(1.0, 0.01, 0.01)] * 20, rate)) == []
    assert not clock.has_differed
