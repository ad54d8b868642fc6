"""Readings become facts: comparison, latch, hysteresis and time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.acting.event_detector import EventDetector
from companion.mission.conditions import parse_condition
from companion.mission.events import Event
from companion.mission.signals import COMMAND, Signal

LEVEL = Signal("BATTERY_STATUS", "", "battery_remaining")
Changes = list[tuple[float, bool]]


def event(
    name: str = "e",
    when: str = "BATTERY_STATUS.battery_remaining < 30",
    until: str | None = None,
    latch: bool = False,
    for_s: float = 0.0,
    stale_s: float | None = None,
) -> Event:
    condition = parse_condition(until) if until else None
    lines = frozenset[str]()
    return Event(name, parse_condition(when), condition, latch, for_s, lines, stale_s=stale_s)


def changes(watched: Event, readings: Sequence[tuple[float, float]]) -> Changes:
    """When the event changed and to what, for (time, value) readings of LEVEL."""
    detector = EventDetector({watched.name: watched})
    return [
        (now_s, holds)
        for now_s, value in readings
        for _, holds in detector.update(now_s, [(LEVEL, value)])
    ]


@pytest.mark.parametrize(
    ("comparison", "true_for"),
    [
        ("<", {29}),
        ("<=", {29, 30}),
        (">", {31}),
        (">=", {30, 31}),
        ("==", {30}),
        ("!=", {29, 31}),
    ],
)
def test_each_comparison_is_the_one_it_is_called(comparison: str, true_for: set[int]) -> None:
    watched = event(when=f"BATTERY_STATUS.battery_remaining {comparison} 30")
    assert {v for v in (29, 30, 31) if changes(watched, [(0.0, v)])} == true_for


@pytest.mark.parametrize("comparison", ["<", "!=", ">="])
def test_a_signal_that_was_never_heard_meets_no_condition(comparison: str) -> None:
    watched = event(when=f"BATTERY_STATUS.battery_remaining {comparison} 0")
    assert EventDetector({"e": watched}).update(5.0, []) == []


def test_without_until_the_opposite_ends_it() -> None:
    assert changes(event(), [(0, 20), (1, 29), (2, 30), (3, 20)]) == [
        (0, True),
        (2, False),
        (3, True),
    ]


def test_a_latched_event_stays() -> None:
    assert changes(event(latch=True), [(0, 20), (1, 90), (2, 20), (3, 90)]) == [(0, True)]


def test_until_has_the_last_word() -> None:
    watched = event(until="BATTERY_STATUS.battery_remaining > 80")
    assert changes(watched, [(0, 29), (1, 50), (2, 80), (3, 81), (4, 50)]) == [
        (0, True),
        (3, False),
    ]


@given(start=st.sampled_from([20, 90]), between=st.lists(st.integers(30, 80), max_size=20))
def test_between_the_thresholds_nothing_changes(start: int, between: list[int]) -> None:
    watched = event(until="BATTERY_STATUS.battery_remaining > 80")
    readings = [(float(t), float(v)) for t, v in enumerate([start, *between])]
    assert changes(watched, readings) == ([(0.0, True)] if start == 20 else [])


def test_a_condition_has_to_hold_for_its_time_without_a_break() -> None:
    readings = [(0, 20), (1.5, 20), (1.9, 40), (2.0, 20), (3.9, 20), (4.0, 20)]
    assert changes(event(for_s=2.0), readings) == [(4.0, True)]


def test_a_change_back_takes_as_long() -> None:
    readings = [(0, 20), (2, 20), (3, 40), (4.9, 40), (5, 40)]
    assert changes(event(for_s=2.0), readings) == [(2, True), (5, False)]


def test_time_passes_without_readings() -> None:
    detector = EventDetector({"e": event(for_s=2.0)})
    assert detector.update(0.0, [(LEVEL, 20.0)]) == []
    assert detector.update(1.9, []) == []
    assert detector.update(2.0, []) == [("e", True)]


@given(st.lists(st.tuples(st.floats(0.01, 3.0), st.sampled_from([20.0, 40.0])), max_size=40))
def test_the_fact_flaps_no_faster_than_its_time(steps: list[tuple[float, float]]) -> None:
    now_s, readings = 0.0, []
    for dt_s, value in steps:
        now_s += dt_s
        readings.append((now_s, value))
    found = changes(event(for_s=2.0), readings)
    assert [holds for _, holds in found] == [i % 2 == 0 for i in range(len(found))]
    assert all(later - earlier >= 2.0 for (earlier, _), (later, _) in pairwise(found))


def test_a_pulse_between_two_ticks_is_not_lost() -> None:
    detector = EventDetector({"e": event(latch=True)})
    assert detector.update(0.0, [(LEVEL, 90.0), (LEVEL, 20.0), (LEVEL, 90.0)]) == [("e", True)]


def test_only_the_signal_of_an_event_counts() -> None:
    other = Signal("SYS_STATUS", "", "battery_remaining")
    assert EventDetector({"e": event()}).update(0.0, [(other, 20.0)]) == []


def test_signals_are_those_of_all_conditions() -> None:
    watched = [
        event("low", until="SYS_STATUS.battery_remaining > 80"),
        event("home", when="COMMAND.MAV_CMD_NAV_RETURN_TO_LAUNCH"),
    ]
    assert EventDetector({e.name: e for e in watched}).signals == {
        LEVEL,
        Signal("SYS_STATUS", "", "battery_remaining"),
        Signal("COMMAND", "", "MAV_CMD_NAV_RETURN_TO_LAUNCH"),
    }


def test_both_changes_within_one_tick_count() -> None:
    detector = EventDetector({"e": event()})
    assert detector.update(0.0, [(LEVEL, 20.0), (LEVEL, 40.0)]) == [("e", True), ("e", False)]


# -- Commands --------------------------------------------------------------------------------------

CALL = Signal(COMMAND, "", "MAV_CMD_USER_1")
CALLED = "COMMAND.MAV_CMD_USER_1"


@given(st.lists(st.integers(0, 3), max_size=20))
def test_a_command_rises_each_time_it_comes_and_never_lasts(arrivals: list[int]) -> None:
    detector = EventDetector({"e": event(when=CALLED)})
    for now_s, count in enumerate(arrivals):
        pulse = [("e", True), ("e", False)]
        assert detector.update(now_s, [(CALL, 1.0)] * count) == (pulse if count else [])


@pytest.mark.parametrize("flaps", [1, 2, 3, 1000])
def test_a_flood_of_changes_within_a_tick_is_told_by_the_last_two(flaps: int) -> None:
    detector = EventDetector({"e": event(), "f": event(name="f", when=CALLED)})
    flood = [(LEVEL, 20.0), (LEVEL, 90.0)] * flaps
    changes = [("e", True), ("e", False)]
    assert detector.update(0.0, flood) == changes
    assert detector.update(1.0, [*flood, (LEVEL, 20.0)]) == [("e", False), ("e", True)]
    called = [("f", True), ("f", False)]
    assert detector.update(2.0, [(CALL, 1.0), (LEVEL, 90.0), *flood]) == [
        *called,
        ("e", True),
        ("e", False),
    ]


def test_a_latched_command_stays() -> None:
    detector = EventDetector({"e": event(when=CALLED, latch=True)})
    assert detector.update(0.0, [(CALL, 1.0), (CALL, 1.0)]) == [("e", True)]
    assert detector.update(9.0, [(CALL, 1.0)]) == []


def test_a_command_counts_at_once_where_levels_have_to_hold() -> None:
    """`for_s` is about levels: at either end of the event."""
    begun = event(when=CALLED, until="BATTERY_STATUS.battery_remaining > 80", for_s=2.0)
    detector = EventDetector({"e": begun})
    assert detector.update(0.0, [(CALL, 1.0), (LEVEL, 90.0)]) == [("e", True)]
    assert detector.update(1.9, []) == []
    assert detector.update(2.0, []) == [("e", False)]
    ended = event(until=CALLED, for_s=2.0)
    detector = EventDetector({"e": ended})
    assert detector.update(0.0, [(LEVEL, 20.0)]) == []
    assert detector.update(2.0, []) == [("e", True)]
    assert detector.update(3.0, [(CALL, 1.0)]) == [("e", False)]


def test_what_was_ended_rises_anew_when_its_condition_does() -> None:
    """An operator's command acknowledges: the same level does not raise the event again."""
    detector = EventDetector({"e": event(until=CALLED)})
    assert detector.update(0.0, [(LEVEL, 20.0)]) == [("e", True)]
    assert detector.update(1.0, [(CALL, 1.0)]) == [("e", False)]
    assert detector.update(2.0, [(LEVEL, 10.0)]) == []
    assert detector.update(3.0, [(LEVEL, 40.0), (LEVEL, 20.0)]) == [("e", True)]


def test_conditions_that_hold_together_do_not_flap() -> None:
    overlapping = event(until="BATTERY_STATUS.battery_remaining < 50")
    assert changes(overlapping, [(t, 20.0) for t in range(6)]) == [(0, True), (0, False)]


EVENTS = {
    "low": event("low", until="BATTERY_STATUS.battery_remaining > 80", for_s=0.5),
    "empty": event("empty", "BATTERY_STATUS.battery_remaining < 10"),
    "called": event("called", "COMMAND.MAV_CMD_USER_1"),
    "latched": event("latched", "COMMAND.MAV_CMD_USER_1", latch=True),
}
ONE_CALL = (Signal(COMMAND, "", "MAV_CMD_USER_1"), 1.0)
heard = st.lists(st.one_of(st.just(ONE_CALL), st.integers(0, 100).map(lambda v: (LEVEL, float(v)))))


@given(st.lists(st.tuples(st.floats(0.01, 1.0), heard), max_size=20))
def test_what_is_foreseen_comes_and_nothing_is_taken_before(
    steps: list[tuple[float, list[tuple[Signal, float]]]],
) -> None:
    detector, other, now_s = EventDetector(EVENTS), EventDetector(EVENTS), 0.0
    for passed_s, readings in steps:
        now_s += passed_s
        foreseen = detector.foresee(now_s, readings)
        found = detector.update(now_s, readings)
        assert found == other.update(now_s, readings)
        assert foreseen == ({name for name, _ in found} if readings else set())


# -- silence ---------------------------------------------------------------------------------------


def at_times(watched: Event, heard: Mapping[float, float], end_s: float) -> Changes:
    """When the event changed, of values heard at some times, looked at twenty times a second."""
    detector = EventDetector({watched.name: watched})
    found = []
    for tick in range(round(20 * end_s)):
        now_s = tick / 20
        readings = [(LEVEL, heard[now_s])] if now_s in heard else []
        found += [(now_s, holds) for _, holds in detector.update(now_s, readings)]
    return found


def test_what_is_silent_stays_as_it_was() -> None:
    """Neither does it fall, nor does the time of a change go on."""
    watched = event(stale_s=2.0, for_s=1.0)
    assert at_times(watched, {0.0: 10}, 20.0) == [(1.0, True)]
    assert at_times(event(stale_s=2.0, for_s=3.0), {0.0: 10}, 20.0) == []
    falls = {0.0: 10, 5.0: 50, 6.0: 50}
    assert at_times(watched, falls, 20.0) == [(1.0, True), (6.0, False)]


def test_without_a_time_for_it_nothing_falls_silent() -> None:
    assert at_times(event(for_s=10.0), {0.0: 10}, 20.0) == [(10.0, True)]


def test_silence_is_an_event_of_its_own() -> None:
    """From the beginning on, if nothing is ever heard; over as soon as something is."""
    silent = event(when="BATTERY_STATUS.battery_remaining is silent", stale_s=2.0)
    assert at_times(silent, {}, 10.0) == [(2.05, True)]
    assert at_times(silent, {1.0: 5, 4.0: 5, 5.0: 5}, 6.5) == [(3.05, True), (4.0, False)]


def test_silence_of_an_event_is_told_once_and_its_end() -> None:
    detector = EventDetector({"e": event(stale_s=2.0), "other": event(name="other")})
    told = []
    for tick in range(200):
        now_s = tick / 20
        detector.update(now_s, [(LEVEL, 5.0)] if now_s in (0.0, 6.0) else [])
        told += [(now_s, e.name, is_silent) for e, is_silent in detector.silences(now_s)]
    assert told == [(2.05, "e", True), (6.0, "e", False), (8.05, "e", True)]


def test_an_event_that_is_silence_does_not_keep_its_value() -> None:
    silence = event(name="blind", when="BATTERY_STATUS.battery_remaining is silent", stale_s=2.0)
    detector = EventDetector({"blind": silence})
    told = []
    for tick in range(100):
        now_s = tick / 20
        detector.update(now_s, [(LEVEL, 5.0)] if now_s == 4.0 else [])
        told += detector.silences(now_s)
    assert told == []


def test_until_may_be_heard_while_when_is_silent() -> None:
    watched = event(until="COMMAND.MAV_CMD_USER_1", stale_s=1.0)
    detector = EventDetector({"e": watched})
    assert detector.update(0.0, [(LEVEL, 5.0)]) == [("e", True)]
    assert detector.update(9.0, [(Signal(COMMAND, "", "MAV_CMD_USER_1"), 1.0)]) == [("e", False)]
