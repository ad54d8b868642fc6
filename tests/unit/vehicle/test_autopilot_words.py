"""What the autopilot says, by both ways; what of it explains a refusal, and what is news."""

from __future__ import annotations

import json
import struct

import pytest
from wordy_px4 import (
    ALTITUDE,
    CRITICAL,
    DENIED,
    ERROR,
    FILES,
    INFO,
    LOW_CPU,
    MANUAL,
    MODE_ONLY,
    NO_GPS,
    SUMMARY,
    SWITCHES,
    WARNING,
    WARNS,
    Px4,
    check,
)

from companion.mavlink.framing import dialect
from companion.mavlink.statustext import chunks
from companion.vehicle.autopilot_words import (
    LATELY_S,
    MAX_TEXTS,
    MOST_NEWS,
    NEWS_S,
    REPORT_TIMES,
)
from companion.vehicle.metadata_fetch import ATTEMPTS, PAUSE_S


@pytest.fixture
def px4() -> Px4:
    """Its words are known."""
    px4 = Px4()
    px4.tell_newest()
    px4.run(3.0)
    return px4


def test_the_report_is_asked_for_once_and_told_where_arming_is_refused() -> None:
    px4 = Px4()
    px4.report = [
        (LOW_CPU, ERROR, check(0xFFFFFFFF, 97.25)),
        (NO_GPS, CRITICAL, check(1 << 4)),
        (MODE_ONLY, ERROR, check(1 << 0)),
    ]
    px4.tell_newest()
    px4.run(10.0)
    assert px4.commands == [dialect.MAV_CMD_REQUEST_MESSAGE, dialect.MAV_CMD_RUN_PREARM_CHECKS]
    px4.event(DENIED, CRITICAL)
    assert px4.why_not == ["No GPS", "CPU load 97.2%", "Arming denied"]
    px4.words.custom_mode = MANUAL
    assert px4.why_not == ["CPU load 97.2%", "No stick", "Arming denied"]


def test_the_newest_report_alone_counts(px4: Px4) -> None:
    px4.report = [(NO_GPS, ERROR, check(1 << 4))]
    px4.say_report()
    px4.report = [(LOW_CPU, WARNING, check(1 << 4, 90.0))]
    assert px4.why_not == ["No GPS"]
    px4.say_report()
    assert px4.why_not == ["CPU load 90.0%"]  # a warning, as there is nothing worse
    px4.report = []
    px4.say_report()
    assert px4.why_not == []


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_report_with_a_lost_event_is_asked_for_and_left_out_if_that_is_gone(
    px4: Px4, lost: int
) -> None:
    px4.say_report()
    px4.report = [(NO_GPS, ERROR, check(1 << 4))]
    px4.say_report(lost)
    px4.tell_newest()
    assert px4.why_not == []
    px4.run(1.0)
    assert px4.asked and px4.why_not == ["No GPS"]
    px4.report = [(LOW_CPU, ERROR, check(1 << 4, 1.0))]
    px4.say_report(lost)
    px4.tell_newest()
    px4.kept.clear()
    px4.run(10.0)
    assert px4.why_not == ["No GPS"]


def test_what_comes_both_ways_is_told_once(px4: Px4) -> None:
    px4.say(dialect.MAVLink_statustext_message(CRITICAL, b"Arming was denied\t"))
    px4.event(DENIED, CRITICAL)
    px4.say(dialect.MAVLink_statustext_message(CRITICAL, b"Arming denied"))
    assert px4.why_not == ["Arming denied"]


def test_without_metadata_texts_are_told_and_events_by_their_number() -> None:
    px4 = Px4(hears=False)
    px4.say(dialect.MAVLink_statustext_message(CRITICAL, b"Arming denied\t"))
    px4.event(DENIED, CRITICAL)
    px4.event(SUMMARY, 8)
    assert px4.why_not == ["Arming denied"]  # words may still come
    px4.run(ATTEMPTS * (PAUSE_S + 10.0))
    px4.event(DENIED, CRITICAL)
    assert px4.why_not[-1] == f"event {1 << 24 | DENIED} (its words are not known)"
    asked = px4.commands.count(dialect.MAV_CMD_REQUEST_MESSAGE)
    px4.run(100.0)
    assert px4.commands.count(dialect.MAV_CMD_REQUEST_MESSAGE) == asked == len(px4.commands)


@pytest.mark.parametrize(
    "files",
    [
        {"g.json": "{"},
        {"g.json": FILES["g.json"]},
        {"g.json": FILES["g.json"], "/e.json": "no"},
        {"g.json": json.dumps({"metadataTypes": [{"type": 4, "uri": "https://example.org"}]})},
    ],
)
def test_files_that_are_not_there_or_spoilt_end_it(files: dict[str, str]) -> None:
    px4 = Px4(files)
    px4.event(DENIED, CRITICAL)
    px4.run(ATTEMPTS * (PAUSE_S + 10.0))
    assert len(px4.commands) == ATTEMPTS
    px4.event(DENIED, CRITICAL)
    assert px4.why_not == [f"event {1 << 24 | DENIED} (its words are not known)"]


def test_events_wait_for_their_words() -> None:
    px4 = Px4()
    px4.event(ALTITUDE, WARNING, struct.pack("<f", 1.5))
    assert px4.words.lately(px4.now_s) == []
    px4.run(2.0)
    assert px4.words.lately(px4.now_s) == ["Low at 1.5 m"]


def test_an_autopilot_without_events_is_asked_nothing() -> None:
    px4 = Px4()
    px4.say(dialect.MAVLink_statustext_message(CRITICAL, b"PreArm: check"))
    px4.run(60.0)
    assert (px4.commands, px4.why_not) == ([], [])
    px4.say(dialect.MAVLink_statustext_message(CRITICAL, b"PreArm: check"))
    assert px4.why_not == ["PreArm: check"]


def test_nothing_is_fetched_in_flight_but_lost_events() -> None:
    px4 = Px4()
    px4.is_flown = True
    px4.event(DENIED, CRITICAL)
    px4.event(DENIED, CRITICAL, is_lost=True)
    px4.tell_newest()
    px4.run(60.0)
    assert px4.commands == [] and len(px4.asked) == 1
    px4.is_flown = False
    px4.run(3.0)
    assert px4.words.lately(px4.now_s) == ["Arming denied"]


def test_the_report_is_asked_for_some_times() -> None:
    px4 = Px4()
    px4.tell_newest()
    px4.say_report = lambda lost=-1: None  # type: ignore[method-assign]
    px4.run(60.0)
    assert px4.commands.count(dialect.MAV_CMD_RUN_PREARM_CHECKS) == REPORT_TIMES


def test_less_than_a_warning_is_not_told_and_what_is_old_neither(px4: Px4) -> None:
    px4.event(DENIED, INFO)
    px4.say(dialect.MAVLink_statustext_message(INFO, b"Takeoff detected"))
    px4.event(ALTITUDE, WARNING, struct.pack("<f", 2.0))
    assert px4.why_not == ["Low at 2.0 m"]
    px4.run(LATELY_S + 1.0)
    assert px4.why_not == []


def test_the_last_texts_are_kept_once_each(px4: Px4) -> None:
    for i in (0, 1, 1, 2, 3, 4, 5, 6):
        px4.say(dialect.MAVLink_statustext_message(WARNING, f"text {i}".encode()))
    px4.say(dialect.MAVLink_statustext_message(WARNING, b"\t"))
    assert px4.why_not == [f"text {i}" for i in range(7 - MAX_TEXTS, 7)]


def test_what_is_said_again_and_again_is_told_once(px4: Px4) -> None:
    px4.event(ALTITUDE, WARNING, bytes(4))
    for _ in range(15):  # as a refusal is, while arming is tried
        px4.event(DENIED, CRITICAL)
        px4.run(1.1)
    assert px4.why_not == ["Low at 0.0 m", "Arming denied"]


def test_a_long_text_is_put_together(px4: Px4) -> None:
    long = "x" * 50 + "y" * 50 + " end"
    for message in chunks(WARNING, long, 7):
        px4.say(message)
    assert px4.why_not == [long]


def test_answers_to_somebody_else_are_not_ours(px4: Px4) -> None:
    fresh = Px4()
    fresh.tell_newest()
    fresh._serve = lambda payload: fresh.say(  # type: ignore[method-assign]
        dialect.MAVLink_file_transfer_protocol_message(0, 255, 190, [0] * 251)
    )
    fresh.run(5.0)
    fresh.event(DENIED, CRITICAL)
    assert fresh.why_not == []


def test_in_flight_what_is_said_is_news_a_bounded_number_of_it(px4: Px4) -> None:
    px4.event(DENIED, WARNING)
    px4.is_flown = True
    px4.run(0.1)
    for i in range(100):
        px4.event(ALTITUDE, WARNING, struct.pack("<f", float(i)))
    news = px4.words.take_news()
    assert news == [f"Low at {i}.0 m" for i in range(MOST_NEWS)]
    assert px4.words.take_news() == []
    px4.run(NEWS_S + 0.1)
    px4.event(ALTITUDE, WARNING, struct.pack("<f", 7.5))
    assert px4.words.take_news() == ["Low at 7.5 m"]


def test_a_failsafe_is_told_with_the_reasons_that_the_report_has_for_this_mode(px4: Px4) -> None:
    px4.is_flown = True
    px4.run(0.1)
    px4.report = [(MODE_ONLY, ERROR, check(1 << 0)), (NO_GPS, WARNING, check(1 << 4))]
    px4.say_report()
    px4.event(WARNS, WARNING)  # with no error for this mode it says nothing
    px4.event(SWITCHES, CRITICAL)
    assert px4.words.take_news() == ["Failsafe activated: switching"]
    px4.report = [(NO_GPS, ERROR, check(1 << 4))]
    px4.say_report()
    px4.event(WARNS, WARNING)
    px4.event(SWITCHES, CRITICAL)
    news = px4.words.take_news()
    assert news == ["Failsafe warning: No GPS", "Failsafe activated: switching: No GPS"]
