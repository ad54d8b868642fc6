"""What was measured is never taken for newer than it is, whatever the link does to its messages."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.vehicle.boot_clock import (
    BACK_S,
    FEW,
    NANO,
    QUESTION_S,
    RELAXED_S,
    WINDOW_S,
    BootClock,
    told_boot_s,
)

BOOTED_S = 1000.0
"""When the autopilot of these tests began, by our clock."""


def answer(question: Any, heard_s: float, booted_s: float = BOOTED_S) -> Any:
    """The autopilot's, to a question that it hears at a time of ours."""
    return dialect.MAVLink_timesync_message(round((heard_s - booted_s) * NANO), question.ts1)


def asked(clock: BootClock, now_s: float, there_s: float = 0.0, back_s: float = 0.0) -> None:
    """A question that takes a time to get there, and its answer."""
    (question,) = clock.due(now_s)
    clock.take(now_s + there_s + back_s, answer(question, now_s + there_s))


def measured_s(clock: BootClock, at_s: float, delay_s: float, booted_s: float = BOOTED_S) -> float:
    """When something was measured that was so at a time of ours, as it is told."""
    return clock.measured_s(at_s + delay_s, at_s - booted_s)


def test_without_an_answer_it_is_new_when_it_arrives() -> None:
    clock = BootClock()
    assert measured_s(clock, 1100.0, delay_s=3.0) == 1103.0


@pytest.mark.parametrize("delay_s", [0.0, 0.25, 2.0, 60.0])
def test_the_delay_of_a_link_is_part_of_the_age(delay_s: float) -> None:
    clock = BootClock()
    asked(clock, 1100.0)
    assert measured_s(clock, 1101.0, delay_s) == 1101.0


def test_nothing_is_measured_after_it_arrived() -> None:
    clock = BootClock()
    asked(clock, 1100.0)
    assert clock.measured_s(1101.0, 1102.0 - BOOTED_S) == 1101.0


def test_the_least_round_trip_counts_as_long_as_the_window_has_it() -> None:
    clock = BootClock()
    for i in range(FEW - 1):
        asked(clock, 1100.0 + i, there_s=0.5)
    asked(clock, 1110.0, there_s=0.125)
    asked(clock, 1120.0, there_s=0.25)
    assert measured_s(clock, 1121.0, 5.0) == 1120.875
    asked(clock, 1109.0 + WINDOW_S, there_s=1.0)
    assert measured_s(clock, 1141.0, 5.0) == 1140.875
    asked(clock, 1119.0 + WINDOW_S, there_s=1.0)
    assert measured_s(clock, 1151.0, 5.0) == 1150.75


def test_a_quick_way_back_is_no_better_than_a_slow_one() -> None:
    """Only the way there makes something look older than it is."""
    clock = BootClock()
    asked(clock, 1100.0, there_s=0.0, back_s=0.75)
    assert measured_s(clock, 1101.0, 2.0) == 1101.0


def test_the_last_answer_counts_until_there_is_another_one() -> None:
    clock = BootClock()
    asked(clock, 1100.0)
    for later_s in range(1, 200):
        clock.due(1100.0 + later_s)
    assert measured_s(clock, 1300.0, 1.0) == 1300.0


@pytest.mark.parametrize("tc1", [0, -1])
def test_a_question_of_the_autopilot_is_no_answer(tc1: int) -> None:
    clock = BootClock()
    (question,) = clock.due(1100.0)
    clock.take(1100.0, dialect.MAVLink_timesync_message(tc1, question.ts1))
    assert measured_s(clock, 1101.0, 2.0) == 1103.0


def test_an_answer_to_somebody_else_and_a_second_one_count_for_nothing() -> None:
    clock = BootClock()
    (question,) = clock.due(1100.0)
    clock.take(1100.0, dialect.MAVLink_timesync_message(100 * NANO, question.ts1 + 1))
    assert measured_s(clock, 1101.0, 2.0) == 1103.0
    clock.take(1100.0, answer(question, 1100.0))
    clock.take(1100.0, answer(question, 1050.0))
    assert measured_s(clock, 1101.0, 2.0) == 1101.0


def test_an_answer_that_comes_after_the_window_is_none() -> None:
    clock = BootClock()
    (question,) = clock.due(1100.0)
    clock.due(1100.0 + WINDOW_S + 1.0)
    clock.take(1100.0 + WINDOW_S + 1.0, answer(question, 1100.0))
    assert measured_s(clock, 1132.0, 2.0) == 1134.0


def test_it_asks_once_a_second_and_then_less() -> None:
    clock, asked_s = BootClock(), []
    for tick in range(20 * 40):
        now_s = 1100.0 + tick / 20
        for question in clock.due(now_s):
            assert question.tc1 == 0
            asked_s.append(now_s - 1100.0)
            clock.take(now_s + 0.05, answer(question, now_s))
    assert asked_s[: FEW + 1] == [i * QUESTION_S for i in range(FEW + 1)]
    assert {b - a for a, b in zip(asked_s[FEW:], asked_s[FEW + 1 :], strict=False)} == {RELAXED_S}


def test_a_clock_that_begins_anew_makes_nothing_old() -> None:
    """The first stamp after a reboot is known for one; what was asked before says nothing."""
    clock = BootClock()
    asked(clock, 1100.0)
    assert measured_s(clock, 1101.0, 0.5) == 1101.0
    rebooted_s = 1110.0
    assert measured_s(clock, 1111.0, 0.5, rebooted_s) == 1111.5
    (question,) = clock.due(1112.0)
    clock.take(1112.0, answer(question, 1112.0, rebooted_s))
    assert measured_s(clock, 1113.0, 0.5, rebooted_s) == 1113.0


def test_the_answer_of_a_clock_that_begins_anew_makes_nothing_old() -> None:
    clock = BootClock()
    asked(clock, 1100.0)
    (question,) = clock.due(1110.0)
    clock.take(1110.0, answer(question, 1110.0, 1109.0))
    assert measured_s(clock, 1111.0, 0.5, 1109.0) == 1111.0


def test_what_comes_in_another_order_is_no_reboot() -> None:
    clock = BootClock()
    asked(clock, 1100.0)
    assert measured_s(clock, 1110.0, 0.0) == 1110.0
    assert measured_s(clock, 1110.0 - BACK_S, 2.0) == 1110.0 - BACK_S


DELAYS = st.floats(0, 5).map(lambda s: round(s * 64) / 64)


def test_a_clock_that_falls_behind_makes_nothing_old() -> None:
    """A simulated autopilot's time passes more slowly on a busy machine: by 2 % here."""
    clock, ages_s = BootClock(), []
    for tick in range(20 * 120):
        now_s = 1100.0 + tick / 20
        boot_s = 100.0 + 0.98 * (now_s - 1100.0)
        for question in clock.due(now_s):
            back_s = 0.05 + 0.001 * (tick % 7)
            message = dialect.MAVLink_timesync_message(round(boot_s * NANO), question.ts1)
            clock.take(now_s + back_s, message)
        ages_s.append(now_s - clock.measured_s(now_s, boot_s))
    assert max(ages_s) <= 0.02 * (RELAXED_S + 0.1)


@given(trips=st.lists(st.tuples(DELAYS, DELAYS), min_size=1, max_size=20), delay_s=DELAYS)
def test_nothing_is_taken_for_newer_than_it_is(
    trips: list[tuple[float, float]], delay_s: float
) -> None:
    """Nor for older than the slowest question makes it."""
    clock, now_s = BootClock(), 1100.0
    for there_s, back_s in trips:
        asked(clock, now_s, there_s, back_s)
        now_s += 16.0
    told_s = measured_s(clock, now_s, delay_s)
    assert now_s - max(there_s for there_s, _ in trips) <= told_s <= now_s


@pytest.mark.parametrize("rate", [0.5, 4.0])
def test_a_clock_of_another_rate_is_asked_each_second_and_its_newest_answer_counts(
    rate: float,
) -> None:
    """Ours has its rate from then on, by whoever takes the news."""
    clock = BootClock()
    for i in range(FEW):
        (question,) = clock.due(1100.0 + i)
        shown = round(rate * (100.0 + i) * NANO)
        clock.take(1100.0 + i, dialect.MAVLink_timesync_message(shown, question.ts1))
        if clock.rate.has_differed:
            break
    assert clock.rate.take_news() == pytest.approx(rate)
    booted_s = 1100.0 + i - rate * (100.0 + i)
    assert measured_s(clock, 1100.0 + i, 2.0, booted_s) == pytest.approx(1100.0 + i)
    for now_s in (1110.0, 1111.0, 1112.0, 1113.0, 1114.0, 1115.0, 1116.0):
        asked_of(clock, now_s, booted_s)
    assert clock.rate.take_news() is None


def asked_of(clock: BootClock, now_s: float, booted_s: float) -> None:
    (question,) = clock.due(now_s)
    clock.take(now_s, answer(question, now_s, booted_s))


def position(boot_s: float, system: int = 1, component: int = 1) -> bytes:
    stamped = dialect.MAVLink_local_position_ned_message(round(1000 * boot_s), *[0.0] * 6)
    return MavlinkCodec(system, component).pack(stamped)


def test_what_an_autopilot_stamps_its_position_with_is_what_its_clock_shows() -> None:
    other = MavlinkCodec(1, 1).pack(dialect.MAVLink_ping_message(7, 7, 0, 0))
    heard = [b"no frame", other, position(3.0, system=2), position(4.0, component=191)]
    assert told_boot_s(heard, 1) is None
    assert told_boot_s([*heard, position(12.25)], 1) == 12.25
