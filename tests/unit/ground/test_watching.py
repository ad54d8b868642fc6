"""What a person reads of a flight: texts joined from their chunks, one line of state, the end."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from companion.ground.watching import EXIT_CODE, StatusTextAssembler, WatchedFlight
from companion.mavlink.framing import MavlinkCodec, Message, dialect
from companion.mavlink.px4_modes import custom_mode
from companion.mavlink.statustext import chunks


def heard(watch: WatchedFlight, component: int, message: Message) -> list[str]:
    """What MAVSDK hands on of a message: its name and its fields."""
    (received,) = MavlinkCodec(0, 0).parse(MavlinkCodec(1, component).pack(message))
    fields: dict[str, Any] = received.to_dict()
    return watch.take(1.0, component, fields.pop("mavpackettype"), fields)


@given(st.lists(st.text(st.characters(min_codepoint=32, max_codepoint=126), min_size=1)))
def test_texts_of_any_length_come_out_as_they_went_in(texts: list[str]) -> None:
    watch, lines = WatchedFlight(0.0), []
    for number, text in enumerate(texts, start=1):
        for message in chunks(6, text, number):
            lines += heard(watch, 191, message)
    assert lines == texts


def test_a_text_whose_end_is_lost_comes_before_the_next() -> None:
    texts = StatusTextAssembler()
    assert texts.take("a" * 50, 7, 0) == []
    assert texts.take("b" * 50, 8, 0) == ["a" * 50]
    assert texts.take("c", 0, 0) == ["b" * 50, "c"]


def test_only_the_companion_speaks_and_ends_the_run() -> None:
    watch = WatchedFlight(0.0)
    (text,) = chunks(6, "PX4 says something", 1)
    assert heard(watch, 1, text) == []
    end = dialect.MAVLink_named_value_int_message(0, EXIT_CODE.encode(), 3)
    assert heard(watch, 1, end) == []
    assert watch.exit_code is None
    heard(watch, 191, dialect.MAVLink_named_value_int_message(0, b"target", 1))
    assert watch.exit_code is None
    heard(watch, 191, end)
    assert watch.exit_code == 3


def test_the_status_line_says_what_the_autopilot_said_last() -> None:
    watch = WatchedFlight(0.0)
    assert watch.status == "?  disarmed  battery ? %  height ? m"
    armed = dialect.MAV_MODE_FLAG_SAFETY_ARMED
    mode = custom_mode("OFFBOARD")
    heard(watch, 1, dialect.MAVLink_heartbeat_message(2, 12, armed, mode, 4, 3))
    heard(watch, 191, dialect.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3))
    heard(watch, 1, dialect.MAVLink_global_position_int_message(0, 0, 0, 0, 2540, 0, 0, 0, 0))
    status = dialect.MAVLink_sys_status_message(0, 0, 0, 0, 15000, 100, 81, 0, 0, 0, 0, 0, 0)
    heard(watch, 1, status)
    assert watch.status == "OFFBOARD  armed  battery 81 %  height 2.5 m"
    assert watch.heard_s == 1.0
