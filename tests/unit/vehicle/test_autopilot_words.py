"""What the autopilot says, by both ways; what of it explains a refusal, and what is news."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest

from companion.mavlink.framing import Message, dialect
from companion.mavlink.ftp_frames import Nak, Opcode
from companion.mavlink.statustext import chunks
from companion.vehicle.autopilot_words import (
    LATELY_S,
    MAX_TEXTS,
    MOST_NEWS,
    NEWS_S,
    REPORT_TIMES,
    AutopilotWords,
)
from companion.vehicle.metadata_fetch import ATTEMPTS, PAUSE_S

TICK_S = 0.05
AUTOPILOT = (1, 1)
HOLD, MANUAL = 50593792, 65536
CRITICAL, ERROR, WARNING, INFO = 2, 3, 4, 6
SUMMARY, HEALTH, NO_GPS, LOW_CPU, MODE_ONLY, DENIED, ALTITUDE = range(1, 8)
CHECK = [{"type": "uint32_t"}, {"type": "uint8_t"}]


def event(message: str, *types: str, **more: Any) -> dict[str, Any]:
    return {"name": "e", "message": message, "arguments": [{"type": t} for t in types]} | more


EVENTS = {
    "arming_check": {
        SUMMARY: event("", "uint8_t", type="summary"),
        NO_GPS: event("No GPS", "uint32_t", "uint8_t"),
        MODE_ONLY: event("No stick", "uint32_t", "uint8_t"),
    },
    "health": {
        HEALTH: event("", "uint8_t", type="summary"),
        LOW_CPU: event("CPU load {3:.1}%", "uint32_t", "uint8_t", "float"),
    },
    "default": {DENIED: event("Arming denied"), ALTITUDE: event("Low at {1:.1m_v}", "float")},
}
GROUPS = {group: {"events": about} for group, about in EVENTS.items()}
COMPONENT = {
    "namespace": "px4",
    "event_groups": GROUPS,
    "navigation_mode_groups": {"groups": {"0": [MANUAL], "4": [HOLD]}},
}
FILES = {
    "g.json": json.dumps({"metadataTypes": [{"type": 4, "uri": "mftp://[;comp=1]/e.json"}]}),
    "/e.json": json.dumps({"components": {"1": COMPONENT}}),
}


class Px4:
    """Answers what `AutopilotWords` asks, and says what a test wants."""

    def __init__(self, files: dict[str, str] = FILES, hears: bool = True) -> None:
        self.words = AutopilotWords()
        self.words.custom_mode = HOLD
        self.files, self.hears = files, hears
        self.now_s, self.sequence = 100.0, 65530
        self.is_flown = False
        self.kept: dict[int, Message] = {}
        self.commands: list[int] = []
        self.asked: list[tuple[int, int]] = []
        self.report: list[tuple[int, int, bytes]] = []
        self._open = ""

    def run(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.now_s += TICK_S
            for message in self.words.due(self.now_s, AUTOPILOT, self.is_flown):
                self._answer(message)

    def _answer(self, message: Message) -> None:
        kind = message.get_type()
        assert (message.target_system, message.target_component) == AUTOPILOT
        if kind == "COMMAND_LONG":
            self.commands.append(message.command)
            if not self.hears:
                return
            if message.command == dialect.MAV_CMD_RUN_PREARM_CHECKS:
                self.say_report()
            else:
                uri = next(iter(self.files)).encode()
                self.say(dialect.MAVLink_component_metadata_message(0, 0, b"mftp://" + uri))
        elif kind == "REQUEST_EVENT":
            self.asked.append((message.first_sequence, message.last_sequence))
            number = message.first_sequence
            while number != (message.last_sequence + 1) % 65536:
                if number in self.kept:
                    self.say(self.kept[number])
                number = (number + 1) % 65536
        else:
            self._serve(bytes(message.payload))

    def _serve(self, payload: bytes) -> None:
        sequence, _, opcode, size, *_, offset = struct.unpack_from("<HBBBBBBI", payload)
        data, nak = b"", 0
        if opcode == Opcode.OPEN_FILE_RO:
            self._open = payload[12 : 12 + size].decode()
            nak = 0 if self._open in self.files else Nak.FILE_NOT_FOUND
            data = struct.pack("<I", len(self.files.get(self._open, "")))
        elif opcode == Opcode.READ_FILE:
            data = self.files[self._open].encode()[offset : offset + size]
        if nak:
            data = bytes([nak])
        head = struct.pack(
            "<HBBBBBBI", sequence + 1, 0, 129 if nak else 128, len(data), opcode, 0, 0, offset
        )
        full = (head + data).ljust(251, b"\0")
        self.say(dialect.MAVLink_file_transfer_protocol_message(0, 1, 191, list(full)))

    def say(self, message: Message) -> None:
        self.words.take(self.now_s, message)

    def event(self, number: int, level: int, arguments: bytes = b"", is_lost: bool = False) -> None:
        self.sequence = (self.sequence + 1) % 65536
        message = dialect.MAVLink_event_message(
            0, 0, 1 << 24 | number, 0, self.sequence, 0x60 | level, list(arguments.ljust(40, b"\0"))
        )
        self.kept[self.sequence] = message
        if not is_lost:
            self.say(message)

    def tell_newest(self) -> None:
        self.say(dialect.MAVLink_current_event_sequence_message(self.sequence, 0))

    def say_report(self, lost: int = -1) -> None:
        self.event(SUMMARY, 8, is_lost=lost == 0)
        for at, (number, level, arguments) in enumerate(self.report, start=1):
            self.event(number, level, arguments, is_lost=lost == at)
        self.event(HEALTH, 8, is_lost=lost == len(self.report) + 1)

    @property
    def why_not(self) -> list[str]:
        return self.words.why_not_armed(self.now_s)


def check(modes: int, *values: float) -> bytes:
    return struct.pack(f"<IB{len(values)}f", modes, 0, *values)


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
