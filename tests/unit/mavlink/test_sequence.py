"""The order of messages that overtake each other on the way."""

import random

import pytest

from companion.mavlink.sequence import SequenceTracker


@pytest.mark.parametrize("rate_hz", [1, 20, 100, 127, 128, 200, 255, 256, 300, 400, 600])
def test_a_rare_message_is_heard_whatever_comes_in_between(rate_hz: int) -> None:
    order = SequenceTracker()
    for number in range(10 * rate_hz):
        kind = "HEARTBEAT" if number % rate_hz == 0 else "ATTITUDE"
        assert not order.is_overtaken(number / rate_hz, kind, number % 256)


@pytest.mark.parametrize("seed", range(5))
def test_with_delays_exactly_those_are_overtaken_that_are_older_than_a_known_one(seed: int) -> None:
    rng = random.Random(seed)
    sent = [(i / 300, rng.choice(["POSITION", "HEARTBEAT", "ATTITUDE"]), i) for i in range(3000)]
    arrivals = sorted((at_s + rng.uniform(0, 0.2), kind, i) for at_s, kind, i in sent)
    order, newest = SequenceTracker(), dict.fromkeys(("POSITION", "HEARTBEAT", "ATTITUDE"), -1)
    for at_s, kind, number in arrivals:
        assert order.is_overtaken(at_s, kind, number % 256) == (number < newest[kind])
        newest[kind] = max(newest[kind], number)


@pytest.mark.parametrize("lost", [1, 100, 127, 128, 200, 255, 256, 1000])
def test_after_an_outage_messages_are_heard_again_at_once(lost: int) -> None:
    order = SequenceTracker()
    for number in range(50):
        order.is_overtaken(number / 100, "POSITION", number)
    again = 50 + lost
    assert not order.is_overtaken(again / 100 + 0.3, "POSITION", again % 256)
