"""Events come in order and once, whatever the link loses, repeats or mixes up."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.event_sequence import ASK_S, FAR, ROUND, TRIES, EventSequence

KEPT = 20
"""Events that a component keeps, as PX4."""


def test_nothing_is_asked_before_the_first_and_of_what_was_before_it() -> None:
    events = EventSequence[str]()
    assert not events.has_begun and events.due(0.0) is None
    events.take_newest(41, is_reset=False)
    assert events.has_begun and events.due(0.0) is None
    events.take(42, "a")
    assert (events.ready(), events.due(1.0)) == (["a"], None)


def test_what_is_told_and_was_not_heard_is_asked_for() -> None:
    events = EventSequence[str]()
    events.take_newest(65533, is_reset=False)
    events.take_newest(1, is_reset=False)
    assert events.due(0.0) == (65534, 1)
    assert events.due(ASK_S / 2) is None
    assert events.due(ASK_S) == (65534, 1)


def test_what_nobody_sends_is_passed_over_after_some_tries() -> None:
    events = EventSequence[str]()
    events.take(5, "a")
    events.take(8, "b")
    times = [i * ASK_S for i in range(1, 4 * TRIES)]
    assert [events.due(now_s) for now_s in times if now_s] == [(6, 7)] * TRIES + [None] * (
        len(times) - TRIES
    )
    assert events.ready() == ["a", None, None, "b"]


def test_what_the_component_no_longer_has_is_passed_over_at_once() -> None:
    events = EventSequence[str]()
    events.take(5, "a")
    events.take(8, "b")
    for number in (6, 7, 99, 4):
        events.pass_over(number)
    assert events.ready() == ["a", None, None, "b"]
    assert events.due(1.0) is None


@pytest.mark.parametrize("number", [3, 5 + FAR + 1, 40_000])
def test_a_component_that_begins_anew_is_followed(number: int) -> None:
    events = EventSequence[str]()
    events.take(5, "a")
    events.take_newest(number, is_reset=True)
    events.take((number + 1) % ROUND, "b")
    assert events.ready() == ["a", "b"]


@given(
    st.integers(0, ROUND - 1),
    st.integers(0, 2**32),
    st.floats(0.0, 0.6),
    st.integers(1, 120),
)
def test_all_that_is_sent_arrives_once_and_in_order(
    first: int, seed: int, loss: float, count: int
) -> None:
    """A link that loses, doubles and mixes up; the component answers what it is asked."""
    chance = random.Random(seed)
    events = EventSequence[int]()
    heard: list[int | None] = []
    events.take_newest((first - 1) % ROUND, is_reset=True)
    sent, now_s, asked = 0, 0.0, 0
    while sent < count or now_s < count + 40 * ASK_S:
        now_s += 1.0 if sent < count else ASK_S
        leaving = [sent] if sent < count else []
        sent += len(leaving)
        if (wanted := events.due(now_s)) is not None:
            asked += 1
            start, last = ((number - first) % ROUND for number in wanted)
            assert 0 <= start <= last < sent and last - start < FAR
            for number in range(start, last + 1):
                if number < sent - KEPT:
                    events.pass_over((first + number) % ROUND)
                else:
                    leaving.append(number)
        leaving *= chance.choice((1, 1, 2))
        chance.shuffle(leaving)
        for number in leaving:
            if chance.random() >= loss:
                events.take((first + number) % ROUND, number)
        if chance.random() >= loss:
            events.take_newest((first + sent - 1) % ROUND, is_reset=False)
        heard += events.ready()
    assert len(heard) == count  # each in its place, or passed over
    assert all(number in (None, at) for at, number in enumerate(heard))
    assert asked <= TRIES * count
    if loss < 0.05:
        assert None not in heard
